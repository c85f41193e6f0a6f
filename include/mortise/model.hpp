// The model: regularised CSG trees over primitives, with regions and named surfaces.
//
// A Model is plain data in one arena: children are stored before their parents, so a loop over
// `nodes` visits every node after its children, whatever the depth of the tree (no recursion).
// Nodes may be shared (a Netgen solid that is used twice is one node with two parents).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mortise/error.hpp"

namespace mortise {

using Vec3 = std::array<double, 3>;

/// Affine map x -> M x + t, row-major 3×4: {m00, m01, m02, t0, m10, ...}. Maps local to parent space.
using Affine = std::array<double, 12>;

inline constexpr Affine kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// Axis-aligned box in model units.
struct Box3 {
    Vec3 min{};
    Vec3 max{};
};

/// Half-space { x : normal·x <= offset }. `normal` points outwards and need not have unit length.
struct Plane {
    Vec3 normal{};
    double offset = 0;
    std::string name;  ///< suffix of the surface's name, e.g. "xmin"; may be empty
};

/// A closed surface of triangles, counter-clockwise seen from outside. Small holes and overlaps are borne:
/// a point is inside where the winding number is above one half.
struct TriangleSurface {
    std::vector<Vec3> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into `points`
    /// Per triangle an index into `group_names`; empty: no groups. Surfaces end where a group ends, and are
    /// called after the primitive and their group, or the primitive alone if the group's name is empty.
    std::vector<std::uint32_t> group;
    std::vector<std::string> group_names;
};

/// A ball; in a RoundedSolid of discs a disc in the plane of the first two coordinates.
struct Ball {
    Vec3 center{};
    double radius = 0;
};

/// A solid without edges: its whole surface is smooth. All but rings are convex.
struct RoundedSolid {
    enum class Shape : std::uint8_t {
        kHull,        ///< the hull of `balls`
        kColumn,      ///< the hull of discs in the xy plane, at all heights z
        kPlate,       ///< the Minkowski sum of such a column between two heights and a ball; radii may be 0
        kRevolution,  ///< the hull of discs in the plane (distance from the z axis, z), turned about z
        kRing,        ///< the same of discs that are clear of the axis, without the hole between: not convex
    };
    Shape shape = Shape::kHull;
    std::vector<Ball> balls;  ///< none need be inside the hull of the others; some may
    double low = 0;           ///< kPlate: heights of the column
    double high = 0;
    double rounding = 0;  ///< kPlate: radius of the ball
};

/// One primitive in its own local frame. The region inside is { x : f(x) <= 0 }.
struct Primitive {
    enum class Kind : std::uint8_t {
        kConvex,      ///< intersection of `planes` (half-space: one; box: six; wedge: five; prisms)
        kSphere,      ///< x² + y² + z² <= radius²
        kCylinder,    ///< x² + y² <= radius², infinite along z
        kCone,        ///< single nappe: sqrt(x² + y²) <= radius + slope·z  (z beyond the apex: outside)
        kDoubleCone,  ///< both nappes: x² + y² <= (radius + slope·z)²
        kTorus,       ///< (sqrt(x² + y²) - major)² + z² <= radius²; axis z
        kExpression,  ///< expression <= 0; see `expression`
        kPolyhedron,  ///< what `triangles` enclose
        kRounded,     ///< see `rounded`
    };
    Kind kind = Kind::kConvex;
    std::vector<Plane> planes;  ///< kConvex only, at least one
    double radius = 0;          ///< sphere, cylinder, torus (minor); cone: radius at z = 0
    double slope = 0;           ///< cones: change of radius per unit of z
    double major = 0;           ///< torus: distance from the axis to the tube's centre line
    std::string expression;     ///< kExpression: formula in x, y, z (grammar: docs/formulas.md)
    std::shared_ptr<const TriangleSurface> triangles;  ///< kPolyhedron only
    double sharp_angle = 0;  ///< kPolyhedron: edges where the normal turns by more degrees are creases
    std::shared_ptr<const RoundedSolid> rounded;  ///< kRounded only
};

/// A node of the CSG tree.
struct CsgNode {
    enum class Op : std::uint8_t {
        kPrimitive,     ///< no children
        kUnion,         ///< any number of children; none: the empty set
        kIntersection,  ///< any number of children; none: all of space
        kDifference,    ///< the first child minus all others; none: the empty set
        kComplement,    ///< exactly one child
        kTransform,     ///< exactly one child, mapped by `map` (regular: |det| > 0; mirrors allowed)
    };
    Op op = Op::kPrimitive;
    std::vector<std::uint32_t> children;  ///< indices into Model::nodes, each less than this node's own
    Primitive primitive;                  ///< kPrimitive only
    Affine map = kIdentity;               ///< kTransform only
    std::string name;     ///< names the surfaces of the primitives below; the innermost non-empty name wins
    double max_size = 0;  ///< element size wanted on the surfaces below and inside; 0: none
    double surface_size = 0;  ///< element size wanted on the surfaces below, not inside; 0: none
    /// A box known to hold the solid of this node, in its own frame: helps to find the model's bounds.
    std::optional<Box3> bounds;
    SourceLocation where;
};

/// One material. Regions are tried in order; a point belongs to the first whose solid holds it.
struct Region {
    std::string name;
    std::uint32_t root = 0;  ///< index into Model::nodes
    double max_size = 0;     ///< element size wanted inside; 0: none
    std::string metadata;    ///< text that the file attached to the region, verbatim
};

/// Small cells at parts of the model that have no node of their own.
struct SizeHint {
    enum class Kind : std::uint8_t {
        kPoint,    ///< at a point
        kMeeting,  ///< where a surface of each group meets those of the others; one group: on its surfaces
        kGap,      ///< between the surfaces of two groups: cells no larger than half of their distance there
    };
    Kind kind = Kind::kPoint;
    Vec3 at{};                                       ///< kPoint
    std::vector<std::vector<std::uint32_t>> groups;  ///< primitives, by their indices in Model::nodes
    double max_size = 0;                             ///< element size wanted; 0: kHintLevels below `level`
    SourceLocation where;
};

/// Levels below that of the boundary for hints without a size, and at most for gaps that are not flat.
inline constexpr int kHintLevels = 2;
inline constexpr int kGapLevels = 4;

/// Two planes between which the solid repeats: their facets shall match, moved from one to the other.
struct PeriodicPair {
    std::vector<std::uint32_t> first, second;  ///< primitives, as in SizeHint; the first plane of each counts
    std::string name;                          ///< as the file calls them, for messages
    SourceLocation where;
};

/// A whole model as read from a file or built in code.
struct Model {
    std::vector<CsgNode> nodes;
    std::vector<Region> regions;  ///< at least one, at most 4095: the mesher refuses others
    std::optional<Box3>
        clip;  ///< the file's own bounding box: the solid ends there, its faces are boundaries
    std::vector<SizeHint> hints;
    std::vector<PeriodicPair> periodic;
    std::vector<std::string> warnings;  ///< one line each
    std::string source = "model";       ///< path or description, for messages

    /// Appends a node and returns its index. Throws kInput if a child index is not an earlier node.
    std::uint32_t add(CsgNode node);
    std::uint32_t add_primitive(Primitive primitive, std::string name = {}, SourceLocation where = {});
    std::uint32_t add_operation(CsgNode::Op op, std::vector<std::uint32_t> children, std::string name = {});
    std::uint32_t add_transform(const Affine& map, std::uint32_t child);
};

/// Throws Error(kInput) for the first thing wrong with a model whose fields were filled in by hand: indices
/// out of range, nodes above themselves, numbers that are not finite or have the wrong sign. Whatever takes a
/// model calls it; formulas are parsed later.
void check_model(const Model& model);

// Ready-made primitives, each in the frame that its name suggests. Sizes are checked: a radius or
// edge that is not positive and finite throws Error(kInput).
Primitive half_space(const Vec3& point, const Vec3& outward_normal);
Primitive box(const Vec3& min, const Vec3& max);   ///< planes xmin, xmax, ymin, ymax, zmin, zmax
Primitive wedge(double dx, double dy, double dz);  ///< right triangle (0,0) (dx,0) (0,dy) in xy, 0 <= z <= dz
Primitive sphere(double radius);
Primitive infinite_cylinder(double radius);
Primitive cone(double radius, double slope);
Primitive double_cone(double radius, double slope);
Primitive torus(double major, double minor);
/// Needs at least four triangles, finite points, indices in range; `sharp_angle` in degrees, 0 to 180.
Primitive polyhedron(TriangleSurface triangles, double sharp_angle = 0);
/// Needs a ball at least, and a solid with a volume; radii positive (of a plate its rounding).
Primitive rounded(RoundedSolid solid);

/// How OpenSCAD's circles, cylinders and spheres are read.
enum class Facets : std::uint8_t {
    kSmooth,  ///< as true curves, unless $fn asks for at most twelve sides: a deliberate prism
    kExact,   ///< as the polyhedra that OpenSCAD makes of them
};

struct ReadOptions {
    Facets facets = Facets::kSmooth;  ///< .csg and .scad only
    /// Height of the solid above a function of x and y alone (.vm, .frep, .formula); 0: refuse such a
    /// function.
    double extrude = 0;
    /// The solid is to be cut (MeshOptions::box), so that a function of x and y alone describes one, too.
    bool is_cut = false;
    /// .scad only: NAME=VALUE, each as if it stood at the end of the file.
    std::vector<std::string> definitions;
    /// .scad only: longest time for the program openscad, which converts it.
    double conversion_seconds = 300;
};

/// Reads a model; the format follows from the extension, in any case of letters (.csg, .scad, .geo, .stl,
/// .obj, .off, .formula, .vm, .frep). A .scad file is converted by the program openscad, which must be
/// installed.
///
/// Throws Error(kFiles) if the file cannot be read and Error(kInput), with file:line:column, what was
/// expected and what to do, for anything that is not understood. Nothing is skipped silently.
Model read_model(const std::string& path, const ReadOptions& options = {});

/// The same for a text in memory; `source` is used in messages, `format` is the extension, with or without
/// dot.
Model parse_model(const std::string& text, const std::string& format, const std::string& source,
                  const ReadOptions& options = {});

}  // namespace mortise
