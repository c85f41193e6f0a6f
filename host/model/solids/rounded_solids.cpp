// See rounded_solids.hpp.
#include "host/model/solids/rounded_solids.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/rounded_parts.hpp"
#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/rounded_facets.hpp"
#include "host/model/solids/swept_outline.hpp"

namespace mortise::model_reader {
namespace {

std::uint32_t add_half_spaces(Model& model, std::vector<Plane> planes, const std::string& name) {
    Primitive primitive;
    primitive.planes = std::move(planes);
    return model.add_primitive(std::move(primitive), name);
}

std::uint32_t add_ball(Model& model, const Vec3& center, double radius, const std::string& name) {
    const std::uint32_t ball = model.add_primitive(sphere(radius), name);
    return center == Vec3{} ? ball : model.add_transform(translation(center), ball);
}

/// Wider by what rounding may need, and no more: the grid follows from it, and faces that lie on its planes
/// shall not leave them.
Box3 widened(Box3 box) {
    for (std::size_t k = 0; k < 3; ++k) {
        const double rounding = 1e-9 * std::max(std::fabs(box.min[k]), std::fabs(box.max[k]));
        box.min[k] -= rounding;
        box.max[k] += rounding;
    }
    return box;
}

RoundedSolid column_over(const std::vector<Disc>& discs) {
    RoundedSolid column;
    column.shape = RoundedSolid::Shape::kColumn;
    for (const Disc& disc : discs) column.balls.push_back({{disc.center[0], disc.center[1], 0}, disc.radius});
    return column;
}

/// The planes through the sides of a convex polygon.
std::vector<Plane> side_planes(const std::vector<Vec2>& outline) {
    std::vector<Plane> planes;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vec2& from = outline[i];
        const Vec2& to = outline[(i + 1) % outline.size()];
        const double apart = std::hypot(to[0] - from[0], to[1] - from[1]);
        const Vec3 normal = {(to[1] - from[1]) / apart, (from[0] - to[0]) / apart, 0};
        planes.push_back({normal, normal[0] * from[0] + normal[1] * from[1], "side" + std::to_string(i + 1)});
    }
    return planes;
}

}  // namespace

std::optional<std::uint32_t> add_prism(Model& model, const std::vector<Disc>& discs, double low, double high,
                                       const Affine& frame, const std::string& name) {
    if (discs.empty() || !(low < high)) return std::nullopt;
    const std::vector<Disc> hull = hull_of_discs(discs);
    const std::size_t n = hull.size();
    if (n == 1 && !(hull[0].radius > 0)) return std::nullopt;
    if (n == 2 && hull[0].radius == 0 && hull[1].radius == 0) return std::nullopt;
    const RoundedSolid column = column_over(hull);
    Box3 bounds = box_of(column);
    bounds.min[2] = low;
    bounds.max[2] = high;
    const auto is_round = [](const Disc& disc) { return disc.radius > 0; };
    std::vector<Plane> planes;
    std::vector<std::uint32_t> parts;
    if (n == 1) {
        const Vec3 center = {hull[0].center[0], hull[0].center[1], 0};
        std::uint32_t tube = model.add_primitive(infinite_cylinder(hull[0].radius), name + "_round");
        if (center != Vec3{}) tube = model.add_transform(translation(center), tube);
        parts.push_back(tube);
    } else if (n <= kMostBalls && std::all_of(hull.begin(), hull.end(), is_round)) {
        parts.push_back(model.add_primitive(rounded(column), name + "_round"));
    } else if (std::any_of(hull.begin(), hull.end(), is_round)) {
        // Tangent-continuous sides are one smooth surface, cut by the planes at its ends.
        const Contours loops = normalised({outline_of(column)});
        if (loops.empty()) return std::nullopt;
        double reach = 0;
        for (std::size_t k = 0; k < 3; ++k) reach = std::max(reach, bounds.max[k] - bounds.min[k]);
        const PrismSpan span = {low - reach / 16, high + reach / 16, 1, 1};
        int sides = 0;
        parts.push_back(model.add_primitive(
            prism(loops, span, kSmoothTurn, [&sides] { return "side" + std::to_string(++sides); }), name));
    } else {
        planes = side_planes(outline_of(column));
    }
    planes.push_back({{0, 0, -1}, -low, "zmin"});
    planes.push_back({{0, 0, 1}, high, "zmax"});
    parts.push_back(add_half_spaces(model, std::move(planes), {}));
    const std::uint32_t node = model.add_operation(CsgNode::Op::kIntersection, std::move(parts), name);
    model.nodes[node].bounds = widened(bounds);
    return frame == kIdentity ? node : model.add_transform(frame, node);
}

std::uint32_t add_rounded(Model& model, RoundedSolid solid, const Affine& frame, const std::string& name) {
    const Box3 bounds = widened(box_of(solid));
    const std::uint32_t node = model.add_primitive(rounded(std::move(solid)), name);
    model.nodes[node].bounds = bounds;
    return frame == kIdentity ? node : model.add_transform(frame, node);
}

std::optional<std::uint32_t> add_hull_of_spheres(Model& model, std::vector<Ball> balls,
                                                 const std::string& name) {
    // All pairs are looked at, with all others: of many equal ones only the corners of the centres' hull.
    constexpr std::size_t kMostPairs = 300;
    if (balls.size() > kMostBalls) {
        std::vector<Vec3> centers;
        for (const Ball& ball : balls) centers.push_back(ball.center);
        const bool alike = std::all_of(balls.begin(), balls.end(), [&](const Ball& ball) {
            return std::fabs(ball.radius - balls[0].radius) <= kSame * balls[0].radius;
        });
        const std::optional<Polytope> hull = alike ? convex_hull(centers) : std::nullopt;
        const double radius = balls[0].radius;
        if (hull) balls.clear();
        for (std::size_t i = 0; hull && i < hull->vertices.size(); ++i)
            balls.push_back({hull->vertices[i], radius});
    }
    if (balls.size() > kMostPairs) return std::nullopt;
    RoundedSolid solid;
    solid.balls = std::move(balls);
    const RoundedParts parts = rounded_parts(solid);
    // Those with a part of their own; of balls in a line the ends.
    solid.balls.clear();
    for (const auto& cap : parts.caps) solid.balls.push_back(parts.balls[cap.ball]);
    if (solid.balls.size() == 1) return add_ball(model, solid.balls[0].center, solid.balls[0].radius, name);
    if (solid.balls.size() > kMostBalls) return std::nullopt;
    return add_rounded(model, std::move(solid), kIdentity, name);
}

}  // namespace mortise::model_reader
