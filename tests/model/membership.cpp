// Point membership from the definitions: see membership.hpp.
#include "tests/model/membership.hpp"

#include <algorithm>
#include <cmath>

#include "tests/model/rounded_distance.hpp"

namespace mortise::test {
namespace {

/// Sum of the signed solid angles under which the triangles are seen (Van Oosterom & Strackee 1983), in
/// turns.
double winding_number(const TriangleSurface& surface, const Vec3& p) {
    double sum = 0;
    for (const auto& triangle : surface.triangles) {
        Vec3 v[3];
        double length[3];
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t j = 0; j < 3; ++j) v[k][j] = surface.points[triangle[k]][j] - p[j];
            length[k] = std::sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
        }
        const auto dot = [](const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
        const double volume = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                              v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                              v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        sum += 2 * std::atan2(volume, length[0] * length[1] * length[2] + dot(v[0], v[1]) * length[2] +
                                          dot(v[1], v[2]) * length[0] + dot(v[2], v[0]) * length[1]);
    }
    return sum / (4 * std::acos(-1.0));
}

bool primitive_holds(const Primitive& primitive, const Vec3& p) {
    const double rho = std::sqrt(p[0] * p[0] + p[1] * p[1]);
    const double level = primitive.radius + primitive.slope * p[2];
    switch (primitive.kind) {
        case Primitive::Kind::kConvex:
            return std::all_of(primitive.planes.begin(), primitive.planes.end(), [&](const Plane& plane) {
                return plane.normal[0] * p[0] + plane.normal[1] * p[1] + plane.normal[2] * p[2] <=
                       plane.offset;
            });
        case Primitive::Kind::kSphere: return rho * rho + p[2] * p[2] <= primitive.radius * primitive.radius;
        case Primitive::Kind::kCylinder: return rho <= primitive.radius;
        case Primitive::Kind::kCone: return rho <= level;
        case Primitive::Kind::kDoubleCone: return rho <= std::fabs(level);
        case Primitive::Kind::kTorus: return std::hypot(rho - primitive.major, p[2]) <= primitive.radius;
        case Primitive::Kind::kPolyhedron: return winding_number(*primitive.triangles, p) > 0.5;
        case Primitive::Kind::kRounded: return rounded_holds(*primitive.rounded, p);
        case Primitive::Kind::kExpression: break;
    }
    throw std::logic_error("no membership for this primitive");
}

/// Solves M x + t = p by Cramer's rule.
Vec3 to_local(const Affine& m, const Vec3& p) {
    const auto determinant = [](const Vec3& a, const Vec3& b, const Vec3& c) {
        return a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) +
               c[0] * (a[1] * b[2] - a[2] * b[1]);
    };
    const Vec3 a = {m[0], m[4], m[8]};
    const Vec3 b = {m[1], m[5], m[9]};
    const Vec3 c = {m[2], m[6], m[10]};
    const Vec3 q = {p[0] - m[3], p[1] - m[7], p[2] - m[11]};
    const double all = determinant(a, b, c);
    return {determinant(q, b, c) / all, determinant(a, q, c) / all, determinant(a, b, q) / all};
}

}  // namespace

bool holds(const Model& model, std::uint32_t index, const Vec3& p) {
    const CsgNode& node = model.nodes[index];
    const auto child_holds = [&](std::uint32_t child) { return holds(model, child, p); };
    const auto& children = node.children;
    switch (node.op) {
        case CsgNode::Op::kPrimitive: return primitive_holds(node.primitive, p);
        case CsgNode::Op::kUnion: return std::any_of(children.begin(), children.end(), child_holds);
        case CsgNode::Op::kIntersection: return std::all_of(children.begin(), children.end(), child_holds);
        case CsgNode::Op::kDifference:
            return !children.empty() && child_holds(children[0]) &&
                   std::none_of(children.begin() + 1, children.end(), child_holds);
        case CsgNode::Op::kComplement: return !child_holds(children[0]);
        case CsgNode::Op::kTransform: return holds(model, children[0], to_local(node.map, p));
    }
    throw std::logic_error("unknown operation");
}

std::size_t region_at(const Model& model, const Vec3& point) {
    for (std::size_t r = 0; r < model.regions.size(); ++r) {
        if (holds(model, model.regions[r].root, point)) return r + 1;
    }
    return 0;
}

std::string refusal(const std::string& text, const std::string& format) {
    try {
        parse_model(text, format, "m." + format);
    } catch (const Error& error) {
        return std::to_string(static_cast<int>(error.code())) + " " + error.what();
    }
    return {};
}

}  // namespace mortise::test
