// Bounded solids, affine maps and a printer: see solids.hpp.
#include "tests/mesher/solids.hpp"

#include <cmath>
#include <cstdio>

namespace mortise::test {
namespace {

std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

std::string describe_primitive(const Primitive& primitive) {
    switch (primitive.kind) {
        case Primitive::Kind::kConvex: {
            std::string text = "planes";
            for (const Plane& plane : primitive.planes) {
                text += " [" + number(plane.normal[0]) + ", " + number(plane.normal[1]) + ", " +
                        number(plane.normal[2]) + " <= " + number(plane.offset) + "]";
            }
            return text;
        }
        case Primitive::Kind::kSphere: return "sphere r=" + number(primitive.radius);
        case Primitive::Kind::kCylinder: return "cylinder r=" + number(primitive.radius);
        case Primitive::Kind::kCone:
            return "cone r=" + number(primitive.radius) + " slope=" + number(primitive.slope);
        case Primitive::Kind::kDoubleCone:
            return "double cone r=" + number(primitive.radius) + " slope=" + number(primitive.slope);
        case Primitive::Kind::kTorus:
            return "torus major=" + number(primitive.major) + " minor=" + number(primitive.radius);
        case Primitive::Kind::kExpression: return "expression " + primitive.expression;
        case Primitive::Kind::kRounded: {
            const RoundedSolid& solid = *primitive.rounded;
            std::string text = "rounded, shape " + std::to_string(static_cast<int>(solid.shape)) + " from " +
                               number(solid.low) + " to " + number(solid.high) +
                               " rounding=" + number(solid.rounding);
            for (const Ball& ball : solid.balls) {
                text += ", (" + number(ball.center[0]) + " " + number(ball.center[1]) + " " +
                        number(ball.center[2]) + ") r=" + number(ball.radius);
            }
            return text;
        }
        case Primitive::Kind::kPolyhedron:
            return "polyhedron of " + std::to_string(primitive.triangles->triangles.size()) + " triangles";
    }
    return "unknown primitive";
}

const char* operation_name(CsgNode::Op op) {
    switch (op) {
        case CsgNode::Op::kPrimitive: return "primitive";
        case CsgNode::Op::kUnion: return "union";
        case CsgNode::Op::kIntersection: return "intersection";
        case CsgNode::Op::kDifference: return "difference";
        case CsgNode::Op::kComplement: return "complement";
        case CsgNode::Op::kTransform: return "map";
    }
    return "unknown operation";
}

}  // namespace

NodeIndex add_box(Model& model, const Vec3& min, const Vec3& max) {
    return model.add_primitive(box(min, max));
}

NodeIndex add_ball(Model& model, const Vec3& centre, double radius) {
    const NodeIndex ball = model.add_primitive(sphere(radius));
    if (centre == Vec3{0, 0, 0}) return ball;
    return model.add_transform(translation(centre), ball);
}

NodeIndex add_cylinder(Model& model, double radius, double low, double high) {
    const NodeIndex side = model.add_primitive(infinite_cylinder(radius));
    const NodeIndex bottom = model.add_primitive(half_space({0, 0, low}, {0, 0, -1}));
    const NodeIndex top = model.add_primitive(half_space({0, 0, high}, {0, 0, 1}));
    return intersect(model, {side, bottom, top});
}

NodeIndex add_frustum(Model& model, double bottom, double top, double low, double high) {
    Primitive side;
    side.kind = Primitive::Kind::kCone;
    side.slope = (top - bottom) / (high - low);
    side.radius = bottom - side.slope * low;
    const NodeIndex cone = model.add_primitive(side);
    const NodeIndex floor = model.add_primitive(half_space({0, 0, low}, {0, 0, -1}));
    const NodeIndex roof = model.add_primitive(half_space({0, 0, high}, {0, 0, 1}));
    return intersect(model, {cone, floor, roof});
}

NodeIndex add_torus(Model& model, double major, double minor) {
    return model.add_primitive(torus(major, minor));
}

NodeIndex unite(Model& model, std::vector<NodeIndex> parts) {
    return model.add_operation(CsgNode::Op::kUnion, std::move(parts));
}
NodeIndex intersect(Model& model, std::vector<NodeIndex> parts) {
    return model.add_operation(CsgNode::Op::kIntersection, std::move(parts));
}
NodeIndex subtract(Model& model, std::vector<NodeIndex> parts) {
    return model.add_operation(CsgNode::Op::kDifference, std::move(parts));
}

Affine translation(const Vec3& by) { return {1, 0, 0, by[0], 0, 1, 0, by[1], 0, 0, 1, by[2]}; }

Affine scaling(const Vec3& factors) {
    return {factors[0], 0, 0, 0, 0, factors[1], 0, 0, 0, 0, factors[2], 0};
}

Affine rotation(const Vec3& axis, double radians) {
    const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    const double x = axis[0] / length, y = axis[1] / length, z = axis[2] / length;
    const double c = std::cos(radians), s = std::sin(radians), d = 1 - c;
    return {c + d * x * x,     d * x * y - s * z, d * x * z + s * y, 0,  //
            d * x * y + s * z, c + d * y * y,     d * y * z - s * x, 0,  //
            d * x * z - s * y, d * y * z + s * x, c + d * z * z,     0};
}

Affine compose(const Affine& first, const Affine& second) {
    Affine result{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            double sum = j == 3 ? first[4 * i + 3] : 0;
            for (std::size_t k = 0; k < 3; ++k) sum += first[4 * i + k] * second[4 * k + j];
            result[4 * i + j] = sum;
        }
    }
    return result;
}

double determinant(const Affine& m) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

Vec3 apply(const Affine& m, const Vec3& p) {
    Vec3 result{};
    for (std::size_t i = 0; i < 3; ++i) {
        result[i] = m[4 * i] * p[0] + m[4 * i + 1] * p[1] + m[4 * i + 2] * p[2] + m[4 * i + 3];
    }
    return result;
}

Model transformed(Model model, const Affine& map) {
    for (Region& region : model.regions) region.root = model.add_transform(map, region.root);
    return model;
}

Model& add_region(Model& model, NodeIndex root, const std::string& name) {
    Region region;
    region.name = name;
    region.root = root;
    model.regions.push_back(region);
    return model;
}

std::string describe(const Model& model) {
    std::string text;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        const CsgNode& node = model.nodes[i];
        text += "  " + std::to_string(i) + ": ";
        if (node.op == CsgNode::Op::kPrimitive) {
            text += describe_primitive(node.primitive);
        } else {
            text += operation_name(node.op);
            for (const NodeIndex child : node.children) text += " " + std::to_string(child);
        }
        if (node.op == CsgNode::Op::kTransform) {
            text += " by {";
            for (std::size_t j = 0; j < 12; ++j) text += (j == 0 ? "" : ", ") + number(node.map[j]);
            text += "}";
        }
        text += "\n";
    }
    for (const Region& region : model.regions) text += "  region " + std::to_string(region.root) + "\n";
    return text;
}

}  // namespace mortise::test
