// From the CSG tree to surfaces and a tape (ARCHITECTURE.md, stage "compile").
//
// Every primitive is split into its smooth surfaces; complements are pushed down to them; what is left is a
// monotone formula over signed surfaces, emitted as a postfix tape whose stack depth is logarithmic in its
// length (the child that needs the deepest stack comes first). Surfaces that are equal up to sign are merged
// when the model is bound to its root box.
#pragma once

#include <string>
#include <vector>

#include "kernels/shared/bounds.h"
#include "kernels/shared/surface.h"
#include "kernels/shared/tape.h"
#include "mortise/model.hpp"

namespace mortise::tape {

/// A surface in model coordinates: `map` takes model units to the surface's own frame.
struct WorldSurface {
    Surface surface{};
    std::uint32_t name = 0;  ///< index into CompiledModel::surface_names
};

/// A polyhedron in model coordinates. In a compiled tape, a spatial word holds its index.
struct WorldPolyhedron {
    TriangleSurface shape;
    std::vector<std::uint32_t> surface;  ///< per triangle: index into CompiledModel::surfaces
};

/// A SizeHint of the model, with surfaces for nodes: indices into `surfaces` of the model that has it,
/// ascending.
struct SurfaceHint {
    SizeHint::Kind kind = SizeHint::Kind::kPoint;
    Vec3 at{};
    std::vector<std::vector<std::uint32_t>> groups;
    double max_size = 0;  ///< 0: kHintLevels
};

/// A PeriodicPair of the model as surfaces; kNoSurface where its solid has none in the model.
struct PeriodicSurfaces {
    static constexpr std::uint32_t kNoSurface = 0xffffffffu;
    std::uint32_t first = kNoSurface;
    std::uint32_t second = kNoSurface;
};

/// Signed surfaces of one conjunction, or of one disjunction: the sides of a solid. Where a point of one of
/// them lies inside all others of a conjunction, or outside all others of a disjunction (a solid that is cut
/// away), it is on the solid's own face.
struct Sides {
    bool is_conjunction = true;
    std::vector<std::uint32_t> literals;  ///< as words of a tape
};

/// A model as formula over surfaces, in model units.
struct CompiledModel {
    std::vector<WorldSurface> surfaces;
    std::vector<ExpressionOp> expression_ops;
    std::vector<std::uint32_t> tape;  ///< literals index `surfaces`
    std::vector<WorldPolyhedron> polyhedra;
    std::vector<Sides> sides;
    std::vector<std::uint32_t> sides_of;  ///< per surface: its place in `sides`; kNoSides: a polyhedron's
    static constexpr std::uint32_t kNoSides = 0xffffffffu;
    std::vector<std::string> surface_names;
    std::vector<std::string> region_names;
    std::vector<double> surface_size;  ///< per surface: element size wanted on it; infinity: none
    std::vector<double> region_size;   ///< per region: element size wanted in it; infinity: none
    std::vector<SurfaceHint> hints;
    std::vector<PeriodicSurfaces> periodic;  ///< parallel to Model::periodic
    Box3 bounds{};                           ///< holds the solid; components may be infinite
    bool is_cut = false;                     ///< by a box, the caller's or the model's
    double scale = 1;  ///< a length that is large compared with every number in the model
};

/// A polyhedron in box-local coordinates, on surfaces that may be shared with other solids.
struct BoundPolyhedron {
    TriangleSurface shape;
    std::vector<std::uint32_t> surface;  ///< per triangle: index into BoundModel::surfaces, plane or patch
    Box3 bounds;                         ///< of the triangles: outside it the polyhedron is not
};

/// One of several surfaces of other names that are equal, and therefore one in the bound model.
struct Namesake {
    std::uint32_t surface = 0;   ///< index into BoundModel::surfaces
    std::int32_t region = 0;     ///< from 1: whose formula has it
    std::uint32_t compiled = 0;  ///< index into CompiledModel::surfaces
};

/// A compiled model in box-local coordinates of a cube: what the octree and all later stages work on.
struct BoundModel {
    std::vector<Surface> surfaces;
    std::vector<SurfaceBounds> bounds;         ///< one per surface
    std::vector<ExpressionOp> expression_ops;  ///< never empty, so that a device buffer exists
    std::vector<std::uint32_t> tape;
    std::vector<std::uint32_t> spatial;        ///< kernels/shared/spatial.h; empty: polyhedra are not divided
    std::vector<BoundPolyhedron> polyhedra;    ///< spatial words hold their index until they are divided
    std::vector<std::uint32_t> surface_name;   ///< per surface, index into CompiledModel::surface_names
    std::vector<Namesake> namesakes;           ///< by surface, region, compiled surface
    std::vector<std::uint32_t> bound_surface;  ///< per compiled surface: the one that stands for it
    std::vector<double> surface_size;          ///< per surface, as in CompiledModel, but box-local
    std::vector<double> region_size;           ///< per region, likewise
    std::vector<SurfaceHint> hints;            ///< box-local
    std::vector<PeriodicSurfaces> periodic;    ///< as in CompiledModel
    std::uint64_t nearly_equal = 0;  ///< surfaces merged with one that they are not equal to (MergeDistances)
    std::uint64_t alike = 0;         ///< the same
    Vec3 origin{};                   ///< model coordinates of the cube's minimum corner
    double side = 1;
};

/// What CsgNode::bounds are: known to hold the solid, or planes that cut it (for find_bounds only).
enum class NodeBounds { kHint, kCut };

/// Compiles a model; `clip` (if given) and Model::clip cut the solid by planes named box_xmin, ….
/// Throws Error(kInput) for a formula that cannot be parsed and for a solid that is empty by its structure.
CompiledModel compile(const Model& model, const Box3* clip = nullptr, NodeBounds use = NodeBounds::kHint);

/// How close to a surface before them surfaces are taken for it: everywhere in the cube, in its edges.
struct MergeDistances {
    double any = 0;    ///< whatever they bound
    double alike = 0;  ///< if both only bound one region, the same, from the same side: nothing lies between
};

/// Binds to the cube [origin, origin + side]^3 and merges surfaces that are equal, or as close as `merge`
/// says. Polyhedra stay undivided (host/triangles): their cells are undecided.
BoundModel bind(const CompiledModel& compiled, const Vec3& origin, double side,
                const MergeDistances& merge = {});

/// A box that holds the solid, each side within about 1/64 of its extent. Throws Error(kInput) if the solid
/// is empty (as far as interval arithmetic can tell) or unbounded.
///
/// Where nothing tells whether the solid ends, a part around the origin with a wide empty shell about it is
/// taken for all of it; then a line is added to `warnings`, if given.
Box3 find_bounds(const CompiledModel& compiled, const std::string& source,
                 std::vector<std::string>* warnings = nullptr);

/// The same for a model and what it was compiled to. Far from the solid intervals of formulas (a twist) tell
/// nothing; where that makes it look unbounded, the boxes that nodes are known to lie in cut them.
Box3 find_bounds(const Model& model, const CompiledModel& compiled, const Box3* clip = nullptr,
                 std::vector<std::string>* warnings = nullptr);

}  // namespace mortise::tape
