// The model arena and the ready-made primitives: every node that enters a Model is checked here, and again
// with all else before it is used, since its fields are open to everybody.
#include "mortise/model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/text.hpp"

namespace mortise {
namespace {

using model_reader::number_text;

[[noreturn]] void refuse(const std::string& message) { throw Error(ExitCode::kInput, message); }

void require_positive(const char* primitive, const char* quantity, double value) {
    if (!(value > 0) || !std::isfinite(value)) {
        refuse(std::string(primitive) + ": " + quantity + " is " + number_text(value) +
               "; expected a positive, finite number");
    }
}

void require_finite(const char* primitive, const char* quantity, double value) {
    if (!std::isfinite(value)) {
        refuse(std::string(primitive) + ": " + quantity + " is " + number_text(value) +
               "; expected a finite number");
    }
}

void require_finite(const char* primitive, const char* quantity, const Vec3& value) {
    for (const double component : value) require_finite(primitive, quantity, component);
}

void require_normal(const char* primitive, const Vec3& normal) {
    require_finite(primitive, "normal", normal);
    if (!(model_reader::length(normal) > 0)) {
        refuse(std::string(primitive) + ": the normal is (0, 0, 0); expected a direction");
    }
}

/// A cone's radius may be zero or negative at z = 0 in a node (its apex is then elsewhere on the axis),
/// as long as it is not zero everywhere.
void require_cone(const char* primitive, const Primitive& cone) {
    require_finite(primitive, "radius", cone.radius);
    require_finite(primitive, "slope", cone.slope);
    if (cone.slope == 0) require_positive(primitive, "radius of a cone without slope", cone.radius);
}

void require_polyhedron(const Primitive& primitive) {
    if (!primitive.triangles || primitive.triangles->triangles.size() < 4) {
        refuse("polyhedron: a closed surface needs at least four triangles");
    }
    for (const Vec3& point : primitive.triangles->points) require_finite("polyhedron", "point", point);
    const std::size_t count = primitive.triangles->points.size();
    for (const auto& triangle : primitive.triangles->triangles) {
        for (const std::uint32_t point : triangle) {
            if (point < count) continue;
            refuse("polyhedron: point " + std::to_string(point) + " does not exist; there are " +
                   std::to_string(count));
        }
    }
    const TriangleSurface& surface = *primitive.triangles;
    if (!surface.group.empty() && surface.group.size() != surface.triangles.size()) {
        refuse("polyhedron: " + std::to_string(surface.group.size()) + " group numbers for " +
               std::to_string(surface.triangles.size()) + " triangles");
    }
    for (const std::uint32_t group : surface.group) {
        if (group >= surface.group_names.size()) {
            refuse("polyhedron: group " + std::to_string(group) + " has no name");
        }
    }
    if (!(primitive.sharp_angle >= 0 && primitive.sharp_angle <= 180)) {
        refuse("polyhedron: the sharp angle is " + number_text(primitive.sharp_angle) +
               " degrees; expected 0 to 180");
    }
}

void require_rounded(const Primitive& primitive) {
    if (!primitive.rounded || primitive.rounded->balls.empty()) {
        refuse("rounded solid: it has no balls; expected at least one");
    }
    const RoundedSolid& solid = *primitive.rounded;
    if (solid.shape > RoundedSolid::Shape::kRing)
        refuse("rounded solid: unknown shape " + std::to_string(static_cast<int>(solid.shape)));
    const bool plate = solid.shape == RoundedSolid::Shape::kPlate;
    for (const Ball& ball : solid.balls) {
        require_finite("rounded solid", "center", ball.center);
        if (plate && ball.radius == 0) continue;
        require_positive("rounded solid", "radius", ball.radius);
        if (solid.shape == RoundedSolid::Shape::kRing)
            require_positive("rounded ring", "distance of a disc from the axis",
                             ball.center[0] - ball.radius);
    }
    if (!plate) return;
    require_positive("rounded solid", "rounding", solid.rounding);
    require_positive("rounded solid", "height", solid.high - solid.low);
}

void check_primitive(const Primitive& primitive) {
    switch (primitive.kind) {
        case Primitive::Kind::kConvex:
            if (primitive.planes.empty()) refuse("convex primitive: it has no planes; expected at least one");
            for (const Plane& plane : primitive.planes) {
                require_normal("convex primitive", plane.normal);
                require_finite("convex primitive", "offset of a plane", plane.offset);
            }
            return;
        case Primitive::Kind::kSphere: require_positive("sphere", "radius", primitive.radius); return;
        case Primitive::Kind::kCylinder: require_positive("cylinder", "radius", primitive.radius); return;
        case Primitive::Kind::kCone: require_cone("cone", primitive); return;
        case Primitive::Kind::kDoubleCone: require_cone("double cone", primitive); return;
        case Primitive::Kind::kTorus:
            require_positive("torus", "major radius", primitive.major);
            require_positive("torus", "minor radius", primitive.radius);
            return;
        case Primitive::Kind::kExpression:
            if (primitive.expression.empty()) refuse("expression primitive: the formula is empty");
            return;
        case Primitive::Kind::kPolyhedron: require_polyhedron(primitive); return;
        case Primitive::Kind::kRounded: require_rounded(primitive); return;
    }
    refuse("primitive: unknown kind " + std::to_string(static_cast<int>(primitive.kind)));
}

/// What a node says of others.
void check_children(const CsgNode& node, std::size_t index) {
    for (const std::uint32_t child : node.children) {
        if (child >= index) {
            refuse("model node " + std::to_string(index) + ": child " + std::to_string(child) +
                   " is not an earlier node; add children before their parents");
        }
    }
    const std::size_t count = node.children.size();
    switch (node.op) {
        case CsgNode::Op::kPrimitive:
            if (count != 0) refuse("model node " + std::to_string(index) + ": a primitive has no children");
            return;
        case CsgNode::Op::kUnion:
        case CsgNode::Op::kIntersection:
        case CsgNode::Op::kDifference: return;
        case CsgNode::Op::kTransform:
        case CsgNode::Op::kComplement:
            if (count == 1) return;
            refuse("model node " + std::to_string(index) + ": it has " + std::to_string(count) +
                   " children; expected exactly one");
    }
    refuse("model node " + std::to_string(index) + ": unknown operation " +
           std::to_string(static_cast<int>(node.op)) + "; expected one of CsgNode::Op");
}

/// What a node says of itself.
void check_content(const CsgNode& node) {
    if (node.op == CsgNode::Op::kPrimitive) check_primitive(node.primitive);
    if (node.op != CsgNode::Op::kTransform) return;
    for (const double entry : node.map) require_finite("transform", "an entry of the matrix", entry);
    if (std::fabs(model_reader::relative_determinant(node.map)) <= model_reader::kSingular) {
        refuse(
            "transform: the matrix is singular, it would flatten the solid; expected a determinant other "
            "than 0");
    }
}

void require_size(const char* quantity, double size) {
    if (size >= 0 && std::isfinite(size)) return;
    refuse(std::string(quantity) + " is " + number_text(size) +
           "; expected a positive, finite length, or 0 for none");
}

void check_sizes_and_bounds(const CsgNode& node) {
    require_size("max_size", node.max_size);
    require_size("surface_size", node.surface_size);
    if (!node.bounds) return;
    for (std::size_t j = 0; j < 3; ++j) {
        if (!std::isnan(node.bounds->min[j]) && !std::isnan(node.bounds->max[j])) continue;
        refuse(std::string("its bounds along ") + "xyz"[j] + " are not numbers");
    }
}

/// Indices of primitives, as in hints and periodic pairs.
void check_primitives(const std::vector<CsgNode>& nodes, const std::vector<std::uint32_t>& indices) {
    for (const std::uint32_t index : indices) {
        if (index >= nodes.size()) {
            refuse("node " + std::to_string(index) + " does not exist; there are " +
                   std::to_string(nodes.size()));
        }
        if (nodes[index].op != CsgNode::Op::kPrimitive)
            refuse("node " + std::to_string(index) + " is not a primitive");
    }
}

void check_hint(const std::vector<CsgNode>& nodes, const SizeHint& hint) {
    require_size("max_size", hint.max_size);
    const std::size_t groups = hint.groups.size();
    switch (hint.kind) {
        case SizeHint::Kind::kPoint: require_finite("point", "coordinate", hint.at); break;
        case SizeHint::Kind::kMeeting:
            if (groups == 0) refuse("it has no groups of primitives; expected at least one");
            break;
        case SizeHint::Kind::kGap:
            if (groups == 2) break;
            refuse("it has " + std::to_string(groups) + " groups of primitives; a gap is between two");
        default: refuse("unknown kind " + std::to_string(static_cast<int>(hint.kind)));
    }
    for (const auto& group : hint.groups) check_primitives(nodes, group);
}

/// Runs a check; what it refuses is told with the place.
template <class Check>
void check_at(const std::string& place, std::size_t index, const Check& check) {
    try {
        check();
    } catch (const Error& error) {
        throw Error(error.code(), place + std::to_string(index) + ": " + error.what());
    }
}

Primitive with_radius(Primitive::Kind kind, double radius, double slope = 0) {
    Primitive result;
    result.kind = kind;
    result.radius = radius;
    result.slope = slope;
    return result;
}

}  // namespace

void check_model(const Model& model) {
    const std::string start = model.source + ": ";
    const std::size_t count = model.nodes.size();
    for (std::size_t i = 0; i < count; ++i) {
        const CsgNode& node = model.nodes[i];
        try {
            check_children(node, i);
        } catch (const Error& error) {
            throw Error(error.code(), start + error.what());
        }
        check_at(start + "model node ", i, [&] {
            check_content(node);
            check_sizes_and_bounds(node);
        });
    }
    for (std::size_t i = 0; i < model.regions.size(); ++i) {
        const Region& region = model.regions[i];
        check_at(start + "region ", i, [&] {
            if (region.root >= count) {
                refuse("its root is node " + std::to_string(region.root) + "; the model has " +
                       std::to_string(count) + " nodes, from 0");
            }
            require_size("max_size", region.max_size);
        });
    }
    for (std::size_t j = 0; model.clip && j < 3; ++j) {
        if (!(model.clip->min[j] < model.clip->max[j]) ||
            !std::isfinite(model.clip->max[j] - model.clip->min[j]))
            refuse(start + "its clip is empty along " + "xyz"[j] +
                   "; expected finite corners, min below max");
    }
    for (std::size_t i = 0; i < model.hints.size(); ++i)
        check_at(start + "size hint ", i, [&] { check_hint(model.nodes, model.hints[i]); });
    for (std::size_t i = 0; i < model.periodic.size(); ++i) {
        check_at(start + "periodic pair ", i, [&] {
            check_primitives(model.nodes, model.periodic[i].first);
            check_primitives(model.nodes, model.periodic[i].second);
        });
    }
}

std::uint32_t Model::add(CsgNode node) {
    if (nodes.size() >= 0xffffffffU) refuse("model: more than 4294967295 nodes");
    check_children(node, nodes.size());
    check_content(node);
    nodes.push_back(std::move(node));
    return static_cast<std::uint32_t>(nodes.size() - 1);
}

std::uint32_t Model::add_primitive(Primitive primitive, std::string name, SourceLocation where) {
    CsgNode node;
    node.primitive = std::move(primitive);
    node.name = std::move(name);
    node.where = where;
    return add(std::move(node));
}

std::uint32_t Model::add_operation(CsgNode::Op op, std::vector<std::uint32_t> children, std::string name) {
    CsgNode node;
    node.op = op;
    node.children = std::move(children);
    node.name = std::move(name);
    return add(std::move(node));
}

std::uint32_t Model::add_transform(const Affine& map, std::uint32_t child) {
    CsgNode node;
    node.op = CsgNode::Op::kTransform;
    node.children = {child};
    node.map = map;
    return add(std::move(node));
}

Primitive half_space(const Vec3& point, const Vec3& outward_normal) {
    require_finite("half-space", "point", point);
    require_normal("half-space", outward_normal);
    Primitive result;
    result.planes = {{outward_normal, dot(outward_normal, point), ""}};
    require_finite("half-space", "offset", result.planes[0].offset);
    return result;
}

Primitive box(const Vec3& min, const Vec3& max) {
    require_finite("box", "corner", min);
    require_finite("box", "corner", max);
    static constexpr std::array<const char*, 3> kEdges = {"edge along x", "edge along y", "edge along z"};
    for (std::size_t k = 0; k < 3; ++k) require_positive("box", kEdges[k], max[k] - min[k]);
    Primitive result;
    result.planes = {{{-1, 0, 0}, -min[0], "xmin"}, {{1, 0, 0}, max[0], "xmax"},
                     {{0, -1, 0}, -min[1], "ymin"}, {{0, 1, 0}, max[1], "ymax"},
                     {{0, 0, -1}, -min[2], "zmin"}, {{0, 0, 1}, max[2], "zmax"}};
    return result;
}

Primitive wedge(double dx, double dy, double dz) {
    require_positive("wedge", "edge along x", dx);
    require_positive("wedge", "edge along y", dy);
    require_positive("wedge", "edge along z", dz);
    // x/dx + y/dy <= 1, scaled so that the larger component of the normal is 1.
    const double larger = std::max(dx, dy);
    const Vec3 slant = {dy / larger, dx / larger, 0};
    Primitive result;
    result.planes = {{{-1, 0, 0}, 0, "xmin"},
                     {{0, -1, 0}, 0, "ymin"},
                     {slant, std::min(dx, dy), "slant"},
                     {{0, 0, -1}, 0, "zmin"},
                     {{0, 0, 1}, dz, "zmax"}};
    return result;
}

Primitive sphere(double radius) {
    require_positive("sphere", "radius", radius);
    return with_radius(Primitive::Kind::kSphere, radius);
}

Primitive infinite_cylinder(double radius) {
    require_positive("cylinder", "radius", radius);
    return with_radius(Primitive::Kind::kCylinder, radius);
}

Primitive cone(double radius, double slope) {
    require_positive("cone", "radius", radius);
    require_finite("cone", "slope", slope);
    return with_radius(Primitive::Kind::kCone, radius, slope);
}

Primitive double_cone(double radius, double slope) {
    require_positive("double cone", "radius", radius);
    require_finite("double cone", "slope", slope);
    return with_radius(Primitive::Kind::kDoubleCone, radius, slope);
}

Primitive torus(double major, double minor) {
    require_positive("torus", "major radius", major);
    require_positive("torus", "minor radius", minor);
    Primitive result = with_radius(Primitive::Kind::kTorus, minor);
    result.major = major;
    return result;
}

Primitive polyhedron(TriangleSurface triangles, double sharp_angle) {
    Primitive result;
    result.kind = Primitive::Kind::kPolyhedron;
    result.triangles = std::make_shared<const TriangleSurface>(std::move(triangles));
    result.sharp_angle = sharp_angle;
    require_polyhedron(result);
    return result;
}

Primitive rounded(RoundedSolid solid) {
    Primitive result;
    result.kind = Primitive::Kind::kRounded;
    result.rounded = std::make_shared<const RoundedSolid>(std::move(solid));
    require_rounded(result);
    return result;
}

}  // namespace mortise
