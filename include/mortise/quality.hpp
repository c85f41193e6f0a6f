// What a mesh keeps of its model, and how good it is: features, shape of elements, distance to the surface.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise {

/// A crease of the model as the mesh has it: mesh edges between two corners, or a closed ring.
struct FeatureCurve {
    std::string name;  ///< "A+B" by its surfaces; "A+B.1", "A+B.2", … if they meet along several curves
    /// Indices into Mesh::surface_names, ascending; may be equal. The lowest, where surfaces at it change
    /// names.
    std::array<std::uint32_t, 2> surfaces{};
    std::vector<NodeId> nodes;  ///< in order; a closed curve does not repeat its first node
    bool closed = false;
    double length = 0;       ///< model units
    double model_angle = 0;  ///< degrees; smallest angle of material between the two tangent planes
};

/// A point of the model: where three surfaces meet, where a crease ends, branches or passes a cone's apex.
struct FeatureCorner {
    NodeId node = 0;
    std::vector<std::uint32_t> surfaces;  ///< indices into Mesh::surface_names, ascending
    double model_angle = 0;               ///< degrees; smallest of its creases', 360 if it has none
};

/// How the nodes of a mesh lie on the model (Finite Octree's classification).
struct Features {
    std::vector<std::uint8_t> model_dimension;  ///< per node: 3 region, 2 face, 1 crease, 0 corner
    std::vector<FeatureCurve> curves;           ///< by surfaces, then by smallest end node
    std::vector<FeatureCorner> corners;         ///< by node
};

/// Shape of the elements of one type; scaled Jacobians as in mortise/check.hpp.
struct ElementShape {
    std::uint64_t count = 0;
    double minimum = 1;                       ///< scaled Jacobian
    double percentile = 1;                    ///< the first: 1 % of the elements are below
    double mean = 1;                          ///< 1 where there are no elements
    std::uint64_t not_positive = 0;           ///< not counted in the histogram
    std::array<std::uint64_t, 20> histogram;  ///< of scaled Jacobians, bins of 0.05
    ElementShape() { histogram.fill(0); }
};

/// Dihedral angles of all elements, one at each end of each element edge; degrees.
struct AngleFigures {
    std::uint64_t count = 0;
    double minimum = 0;
    double maximum = 0;
    double low_percentile = 0;                ///< 1 % of the angles are below; within 0.05
    double high_percentile = 0;               ///< 1 % of the angles are above; within 0.05
    std::array<std::uint64_t, 36> histogram;  ///< bins of 5 degrees
    AngleFigures() { histogram.fill(0); }
};

struct WorstElement {
    ElementType type = ElementType::kHexahedron;
    std::uint64_t index = 0;  ///< within its type
    double scaled_jacobian = 0;
    double min_dihedral = 0;  ///< degrees
    double max_dihedral = 0;
    Vec3 place{};  ///< mean of its nodes
    ElementKind kind = ElementKind::kIn;
    std::string cause;  ///< the features that it touches, with the model's own angle; empty without a model
};

/// Distances in model units.
struct DistanceFigures {
    std::uint64_t samples = 0;     ///< measured
    std::uint64_t unmeasured = 0;  ///< others, near which a formula shows no surface
    double maximum = 0;
    double mean = 0;
    Vec3 place{};  ///< where the largest is
};

/// A corner of the model, found without looking at the mesh.
struct ModelCorner {
    Vec3 place{};
    std::vector<std::string> surfaces;
    double nearest = 0;  ///< distance to the nearest corner of the mesh, model units; -1: the mesh has none
};

struct SurfaceFigures {
    std::string name;
    std::uint64_t facets = 0;
    std::uint64_t components = 0;  ///< model faces: parts that creases separate
    double area = 0;
};

/// Everything that `--quality` tells. The second half needs the model and is empty without it.
struct QualityReport {
    std::array<ElementShape, kElementTypes> shapes;
    AngleFigures angles;
    std::vector<WorstElement> worst;  ///< by scaled Jacobian, ascending

    bool has_model = false;         ///< false: what follows is empty
    double cell_size = 0;           ///< edge of a cell, model units: to see distances by
    DistanceFigures mesh_to_model;  ///< from the facets to their own surfaces
    DistanceFigures model_to_mesh;  ///< from points of the solid's boundary to the nearest facet
    double max_normal_angle = 0;    ///< degrees between facet normals and surface normals
    double mean_normal_angle = 0;   ///< weighted by area
    Vec3 max_normal_place{};
    std::uint64_t corners_expected = 0;
    std::uint64_t corners_found = 0;   ///< corners of the mesh within 1e-6 of the root box of an expected one
    std::uint64_t corners_extra = 0;   ///< corners of the mesh that are no corner of the model
    std::vector<ModelCorner> missing;  ///< at most 20
    double crease_length = 0;          ///< of all curves of the mesh
    std::vector<SurfaceFigures> surfaces;
};

inline constexpr int kWorstElements = 10;

/// The part of the report that needs no model: shapes, angles and the worst elements. Deterministic. Throws
/// Error(kMeshing) if element arrays have wrong lengths or name nodes that are not there.
QualityReport element_quality(const Mesh& mesh, int worst = kWorstElements);

}  // namespace mortise
