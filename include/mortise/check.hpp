// Independent validation and quality of a finished mesh: shares no code with the stages that make it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise {

/// One kind of defect with its count and the first place where it was seen.
struct Defect {
    std::string what;  ///< e.g. "hexahedron with non-positive Jacobian"
    std::uint64_t count = 0;
    std::string first;  ///< e.g. "hexahedron 17 at (0.1, 0.2, 0.3): minimum Jacobian -0.01"
};

/// Figures of a mesh. Lengths in model units, angles in degrees.
struct CheckReport {
    std::vector<Defect> defects;  ///< empty: the mesh is valid
    std::array<std::uint64_t, kElementTypes> elements{};
    std::uint64_t nodes = 0;
    std::uint64_t middle_nodes = 0;      ///< of these, of second order: in the middles of edges
    std::uint64_t boundary_facets = 0;   ///< facets that belong to one element only
    std::uint64_t interface_facets = 0;  ///< facets between two regions
    /// Boundary edges with other than two boundary facets (not a defect).
    std::uint64_t nonmanifold_edges = 0;
    /// Boundary nodes whose boundary facets, joined by edges, are several fans (not a defect).
    std::uint64_t nonmanifold_nodes = 0;
    std::int64_t euler_characteristic = 0;  ///< V - E + F of the outer boundary
    std::uint64_t components = 0;           ///< connected components by shared facets
    std::uint64_t parts = 0;                ///< by shared nodes: fewer if components touch at edges or nodes
    double volume = 0;
    double boundary_area = 0;
    std::vector<double> region_volume;                        ///< by region, index 0 is region 1
    std::array<double, kElementTypes> min_scaled_jacobian{};  ///< 1 where a type has no elements
    double min_dihedral = 0;
    double max_dihedral = 0;

    bool valid() const { return defects.empty(); }
};

/// Validates a mesh: O(elements log elements) time, about 60 bytes per facet. `threads` of the host, here and
/// below; 0: all cores.
///
/// Checked: indices in range; no repeated node in an element; unused nodes; coincident nodes; duplicate
/// elements; Jacobian positive everywhere (a lower bound by Bézier coefficients with subdivision, not
/// corners only; of curved elements of second order at 189 points); every facet shared by at most two
/// elements, oppositely oriented, a quadrilateral never against triangles; hanging nodes in the middle of
/// their masters, and the faces that they tell of those of one element on one side and of four on the other,
/// in one region; the boundary closed; facet list equal to the boundary and the region interfaces, with the
/// right orientation and regions. Where indices or lengths of arrays are wrong, that alone is told. Of second
/// order also: one node in the middle of each edge, the same for all elements and facets; volumes and areas
/// are those of curved elements.
CheckReport check_mesh(const Mesh& mesh, int threads = 0);

/// Scaled Jacobian per element, in the order of mesh.elements: the smallest corner triple product of unit
/// edges; a regular tetrahedron gives 0.707; a pyramid's apex is left out. Length: element_count(). Throws
/// Error(kMeshing) if element arrays have wrong lengths or name nodes that are not there.
std::vector<float> scaled_jacobians(const Mesh& mesh, int threads = 0);

}  // namespace mortise
