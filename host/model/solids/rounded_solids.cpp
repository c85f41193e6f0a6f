// See rounded_solids.hpp.
#include "host/model/solids/rounded_solids.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "host/common/rounded_parts.hpp"
#include "host/model/affine.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/convex_pieces.hpp"
#include "host/model/solids/rounded_facets.hpp"
#include "host/model/solids/swept_outline.hpp"

namespace mortise::model_reader {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr double kSame = 1e-6;

Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

std::uint32_t add_half_spaces(Model& model, std::vector<Plane> planes, const std::string& name) {
    Primitive primitive;
    primitive.planes = std::move(planes);
    return model.add_primitive(std::move(primitive), name);
}

void number_planes(std::vector<Plane>& planes) {
    std::size_t number = 0;
    for (Plane& plane : planes) {
        if (plane.name.empty()) plane.name = "side" + std::to_string(++number);
    }
}

std::uint32_t add_ball(Model& model, const Vec3& center, double radius, const std::string& name) {
    const std::uint32_t ball = model.add_primitive(sphere(radius), name);
    return center == Vec3{} ? ball : model.add_transform(translation(center), ball);
}

/// The box of points, wider by `margin` and by what rounding may need.
Box3 box_of(const std::vector<Vec3>& points, double margin) {
    Box3 box{points[0], points[0]};
    for (const Vec3& point : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::min(box.min[k], point[k]);
            box.max[k] = std::max(box.max[k], point[k]);
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const double rounding = 1e-9 * (margin + std::max(std::fabs(box.min[k]), std::fabs(box.max[k])));
        box.min[k] -= margin + rounding;
        box.max[k] += margin + rounding;
    }
    return box;
}

constexpr double kFacetAngle = kTurn / kFacets;

/// The hull's outline, with arcs in pieces of one facet's angle at most; tangents meet them exactly.
std::vector<Vec2> outline_of(const std::vector<Disc>& hull, const std::vector<Vec2>& normals) {
    const std::size_t n = hull.size();
    std::vector<Vec2> outline;
    for (std::size_t i = 0; i < n; ++i) {
        const Disc& disc = hull[i];
        const Vec2& before = normals[(i + n - 1) % n];
        const Vec2& after = normals[i];
        double arc = std::atan2(after[1], after[0]) - std::atan2(before[1], before[0]);
        arc -= kTurn * std::floor(arc / kTurn);
        if (!(disc.radius > 0)) {
            outline.push_back(disc.center);
            continue;
        }
        if (arc > kTurn - 1e-7) arc = 0;
        const int steps = std::max(1, static_cast<int>(std::ceil(arc / kFacetAngle - 1e-6)));
        const double start = std::atan2(before[1], before[0]);
        for (int k = 0; k <= steps; ++k) {
            if (k == steps && arc < 1e-7) break;
            const double turn = start + arc * k / steps;
            const Vec2 normal = k == 0 ? before : k == steps ? after : Vec2{std::cos(turn), std::sin(turn)};
            outline.push_back(
                {disc.center[0] + disc.radius * normal[0], disc.center[1] + disc.radius * normal[1]});
        }
    }
    return outline;
}

}  // namespace

std::optional<std::uint32_t> add_prism(Model& model, const std::vector<Disc>& discs, double low, double high,
                                       const Affine& frame, const std::string& name) {
    if (discs.empty() || !(low < high)) return std::nullopt;
    const std::vector<Disc> hull = hull_of_discs(discs);
    const std::size_t n = hull.size();
    if (n == 1 && !(hull[0].radius > 0)) return std::nullopt;
    if (n == 2 && hull[0].radius == 0 && hull[1].radius == 0) return std::nullopt;
    std::vector<Plane> planes;
    std::vector<Vec2> normals;  // of the tangent from disc i to disc i + 1
    for (std::size_t i = 0; i < n && n > 1; ++i) {
        const Disc& from = hull[i];
        const Disc& to = hull[(i + 1) % n];
        const Vec2 d = {to.center[0] - from.center[0], to.center[1] - from.center[1]};
        const double apart = std::hypot(d[0], d[1]);
        const double cosine = std::clamp((from.radius - to.radius) / apart, -1.0, 1.0);
        const double sine = std::sqrt((1 - cosine) * (1 + cosine));
        // The direction to the next disc turned clockwise by the angle of that cosine.
        const Vec2 normal = {(d[0] * cosine + d[1] * sine) / apart, (d[1] * cosine - d[0] * sine) / apart};
        normals.push_back(normal);
        const Vec3 plane_normal = {normal[0], normal[1], 0};
        planes.push_back(
            {plane_normal, normal[0] * from.center[0] + normal[1] * from.center[1] + from.radius, {}});
    }
    number_planes(planes);
    std::vector<Vec3> corners;
    double reach = high - low;
    for (const Disc& disc : hull) {
        for (const double sign : {-1.0, 1.0}) {
            const double r = sign * disc.radius;
            corners.push_back({disc.center[0] + r, disc.center[1] + r, low});
            corners.push_back({disc.center[0] + r, disc.center[1] + r, high});
        }
    }
    const Box3 bounds = box_of(corners, 0);
    for (std::size_t k = 0; k < 2; ++k) reach = std::max(reach, bounds.max[k] - bounds.min[k]);
    const auto is_round = [](const Disc& disc) { return disc.radius > 0; };
    const bool round = std::any_of(hull.begin(), hull.end(), is_round);
    const bool rounded_all = n > 1 && n <= kMostBalls && std::all_of(hull.begin(), hull.end(), is_round);
    std::vector<std::uint32_t> parts;
    if (n == 1) {
        const Vec3 center = {hull[0].center[0], hull[0].center[1], 0};
        std::uint32_t tube = model.add_primitive(infinite_cylinder(hull[0].radius), name + "_round");
        if (center != Vec3{}) tube = model.add_transform(translation(center), tube);
        parts.push_back(tube);
    } else if (rounded_all) {
        RoundedSolid column;
        column.shape = RoundedSolid::Shape::kColumn;
        for (const Disc& disc : hull)
            column.balls.push_back({{disc.center[0], disc.center[1], 0}, disc.radius});
        parts.push_back(model.add_primitive(rounded(std::move(column)), name + "_round"));
        planes.clear();
    } else if (round) {
        // Tangent-continuous sides are one smooth surface, cut by the planes at its ends.
        const Contours loops = normalised({outline_of(hull, normals)});
        if (loops.empty()) return std::nullopt;
        const PrismSpan span = {low - reach / 16, high + reach / 16, 1, 1};
        int sides = 0;
        parts.push_back(model.add_primitive(
            prism(loops, span, kSmoothTurn, [&sides] { return "side" + std::to_string(++sides); }), name));
        planes.clear();
    }
    planes.push_back({{0, 0, -1}, -low, "zmin"});
    planes.push_back({{0, 0, 1}, high, "zmax"});
    parts.push_back(add_half_spaces(model, std::move(planes), {}));
    const std::uint32_t node = model.add_operation(CsgNode::Op::kIntersection, std::move(parts), name);
    model.nodes[node].bounds = bounds;
    return frame == kIdentity ? node : model.add_transform(frame, node);
}

std::uint32_t add_rounded(Model& model, RoundedSolid solid, const Affine& frame, const std::string& name) {
    Box3 bounds = box_of(solid);
    for (std::size_t k = 0; k < 3; ++k) {
        const double rounding = kSame * (bounds.max[k] - bounds.min[k]);
        bounds.min[k] -= rounding;
        bounds.max[k] += rounding;
    }
    const std::uint32_t node = model.add_primitive(rounded(std::move(solid)), name);
    model.nodes[node].bounds = bounds;
    return frame == kIdentity ? node : model.add_transform(frame, node);
}

std::optional<std::uint32_t> add_hull_of_spheres(Model& model, std::vector<Ball> balls,
                                                 const std::string& name) {
    RoundedSolid solid;
    solid.balls = std::move(balls);
    const RoundedParts parts = rounded_parts(solid);
    // Those with a part of their own; of balls in a line the ends.
    solid.balls.clear();
    for (const auto& cap : parts.caps) solid.balls.push_back(parts.balls[cap.ball]);
    if (solid.balls.size() == 1) return add_ball(model, solid.balls[0].center, solid.balls[0].radius, name);
    if (solid.balls.size() == 2) {
        const auto& [a, b] = std::pair{solid.balls[0], solid.balls[1]};
        return add_hull_of_two_spheres(model, a.center, a.radius, b.center, b.radius, name);
    }
    if (solid.balls.size() > kMostBalls) return std::nullopt;
    return add_rounded(model, std::move(solid), kIdentity, name);
}

std::optional<std::uint32_t> add_hull_of_two_spheres(Model& model, const Vec3& a, double ra, const Vec3& b,
                                                     double rb, const std::string& name) {
    if (ra < rb) return add_hull_of_two_spheres(model, b, rb, a, ra, name);
    // The cone touches both: its normal makes an angle of this cosine with the axis.
    const Vec3 axis = difference(b, a);
    const double apart = length(axis);
    const double cosine = (ra - rb) / apart;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const Primitive side = ra == rb ? infinite_cylinder(ra) : cone(ra / sine, -cosine / sine);
    const std::uint32_t tube = model.add_operation(
        CsgNode::Op::kIntersection,
        {model.add_primitive(side, name + "_side"),
         add_half_spaces(
             model, {{{0, 0, -1}, -ra * cosine, "start"}, {{0, 0, 1}, apart + rb * cosine, "end"}}, name)});
    return model.add_operation(
        CsgNode::Op::kUnion,
        {add_ball(model, a, ra, name + "_ball1"), add_ball(model, b, rb, name + "_ball2"),
         model.add_transform(frame_along(axis, a), tube)},
        name);
}

}  // namespace mortise::model_reader
