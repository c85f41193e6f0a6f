// See rod_unions.hpp.
#include "host/model/solids/rod_unions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"
#include "host/model/solids/rounded_solids.hpp"
#include "host/model/solids/union_parts.hpp"

namespace mortise::model_reader {
namespace {

/// OpenSCAD writes six figures: of radii and axes, and of coordinates, which may be much larger.
constexpr double kSameRod = 2e-5;
constexpr double kSamePlace = 1e-5;
/// Of the radius: farther apart, ball and end of a rod are two things, however large their coordinates.
constexpr double kFarthestEnd = 1e-3;
/// Balls are sorted along a direction in which rods of lattices are not level.
constexpr Vec3 kAcross = {0.5257, 0.7433, 0.4136};

struct PlacedBall {
    Ball ball;
    double along;
    std::vector<std::uint32_t> nodes;  ///< all that are this ball
    bool used = false;
};

struct Rod {
    Ball end[2];
    std::uint32_t node;
};

/// Edge of the cube that a unit cube becomes, if it does.
std::optional<double> similar_scale(const Affine& map) {
    Vec3 axis[3];
    for (std::size_t j = 0; j < 3; ++j) axis[j] = {map[j], map[4 + j], map[8 + j]};
    const double scale = length(axis[0]);
    for (std::size_t j = 0; j < 3; ++j) {
        if (!(std::fabs(length(axis[j]) - scale) <= kSameRod * scale)) return {};
        if (!(std::fabs(dot(axis[j], axis[(j + 1) % 3])) <= kSameRod * scale * scale)) return {};
    }
    return scale;
}

std::optional<PlacedBall> ball_of(const CsgNode& node, const UnionPart& part) {
    if (node.op != CsgNode::Op::kPrimitive || node.primitive.kind != Primitive::Kind::kSphere) return {};
    const std::optional<double> scale = similar_scale(part.map);
    if (!scale) return {};
    const Vec3 center = image(part.map, {});
    return PlacedBall{{center, *scale * node.primitive.radius}, dot(kAcross, center), {part.node}};
}

/// The cylinder between two planes, if the node has the form that add_csg_cylinder() gives it.
std::optional<Rod> rod_of(const Model& model, const UnionPart& part) {
    const CsgNode& node = model.nodes[part.node];
    if (node.op != CsgNode::Op::kIntersection || node.children.size() != 2) return {};
    const Primitive& side = model.nodes[node.children[0]].primitive;
    const Primitive& caps = model.nodes[node.children[1]].primitive;
    for (const std::uint32_t child : node.children) {
        if (model.nodes[child].op != CsgNode::Op::kPrimitive) return {};
    }
    if (side.kind != Primitive::Kind::kCylinder || caps.kind != Primitive::Kind::kConvex) return {};
    if (caps.planes.size() != 2 || caps.planes[0].normal != Vec3{0, 0, -1} ||
        caps.planes[1].normal != Vec3{0, 0, 1})
        return {};
    const std::optional<double> scale = similar_scale(part.map);
    if (!scale) return {};
    const double radius = *scale * side.radius;
    return Rod{{{image(part.map, {0, 0, -caps.planes[0].offset}), radius},
                {image(part.map, {0, 0, caps.planes[1].offset}), radius}},
               part.node};
}

/// A plane of a convex part, in the frame of the union.
struct PlacedPlane {
    Vec3 normal;  ///< of length 1
    double offset;
};

void add_planes(const CsgNode& node, const UnionPart& part, std::vector<PlacedPlane>& planes) {
    if (node.op != CsgNode::Op::kPrimitive || node.primitive.kind != Primitive::Kind::kConvex) return;
    const Affine back = inverse_of(part.map);
    for (const Plane& plane : node.primitive.planes) {
        const Vec3& n = plane.normal;
        Vec3 normal;
        for (std::size_t j = 0; j < 3; ++j)
            normal[j] = back[j] * n[0] + back[4 + j] * n[1] + back[8 + j] * n[2];
        const double shift = back[3] * n[0] + back[7] * n[1] + back[11] * n[2];
        const double norm = length(normal);
        for (double& x : normal) x /= norm;
        planes.push_back({normal, (plane.offset - shift) / norm});
    }
}

/// Whether a plane touches the rod along a line, from either side.
bool touches(const PlacedPlane& plane, const Rod& rod) {
    const double reach = kFarthestEnd * rod.end[0].radius;
    return std::all_of(rod.end, rod.end + 2, [&](const Ball& end) {
        const double away = std::fabs(dot(plane.normal, end.center) - plane.offset);
        return std::fabs(away - end.radius) <= reach;
    });
}

/// The ball at the end of a rod, or null. `balls` are sorted.
PlacedBall* ball_at(const Ball& end, std::vector<PlacedBall>& balls) {
    const Vec3& e = end.center;
    const double largest = std::max({std::fabs(e[0]), std::fabs(e[1]), std::fabs(e[2])});
    const double reach = std::min(kSameRod * end.radius + kSamePlace * largest, kFarthestEnd * end.radius);
    const double along = dot(kAcross, end.center);
    auto at = std::lower_bound(balls.begin(), balls.end(), along - reach,
                               [](const PlacedBall& ball, double low) { return ball.along < low; });
    for (; at != balls.end() && at->along <= along + reach; ++at) {
        const Vec3& c = at->ball.center;
        const Vec3 apart = {c[0] - e[0], c[1] - e[1], c[2] - e[2]};
        if (length(apart) <= reach && std::fabs(at->ball.radius - end.radius) <= kSameRod * end.radius)
            return &*at;
    }
    return nullptr;
}

/// Sorted, and equal ones as one: people put a ball at each end of each rod.
std::vector<PlacedBall> distinct(std::vector<PlacedBall> balls) {
    std::sort(balls.begin(), balls.end(), [](const PlacedBall& a, const PlacedBall& b) {
        return a.along != b.along ? a.along < b.along : a.nodes < b.nodes;
    });
    std::vector<PlacedBall> result;
    for (PlacedBall& ball : balls) {
        if (PlacedBall* same = ball_at(ball.ball, result)) {
            same->nodes.push_back(ball.nodes[0]);
        } else {
            result.push_back(std::move(ball));
        }
    }
    return result;
}

}  // namespace

void join_rods(Model& model) {
    std::map<std::uint32_t, std::vector<PartMaker>> added;
    std::vector<char> gone(model.nodes.size());
    for (const auto& [root, parts] : union_parts(model)) {
        std::vector<PlacedBall> balls;
        std::vector<Rod> rods;
        std::vector<PlacedPlane> planes;
        for (const UnionPart& part : parts) {
            add_planes(model.nodes[part.node], part, planes);
            if (const auto ball = ball_of(model.nodes[part.node], part)) balls.push_back(*ball);
            if (const auto rod = rod_of(model, part)) rods.push_back(*rod);
        }
        balls = distinct(std::move(balls));
        // Parts come with the last node first; names are given in the order of the file.
        for (auto rod = rods.rbegin(); rod != rods.rend(); ++rod) {
            if (std::any_of(planes.begin(), planes.end(),
                            [&](const auto& plane) { return touches(plane, *rod); }))
                continue;
            PlacedBall* low = ball_at(rod->end[0], balls);
            PlacedBall* high = ball_at(rod->end[1], balls);
            if (low == nullptr || high == nullptr || low == high) continue;
            const CsgNode& node = model.nodes[rod->node];
            gone[rod->node] = 1;
            for (const std::uint32_t child : node.children) gone[child] = 1;
            low->used = true;
            high->used = true;
            RoundedSolid solid;
            solid.balls = {low->ball, high->ball};
            added[root].push_back([solid, name = node.name](Model& result) {
                return add_rounded(result, solid, kIdentity, name);
            });
        }
        for (const PlacedBall& ball : balls) {
            for (const std::uint32_t node : ball.nodes) gone[node] = ball.used ? 1 : 0;
        }
    }
    if (!added.empty()) replace_parts(model, gone, added);
}

}  // namespace mortise::model_reader
