#include "host/pipeline/thin_solids.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host/common/constants.hpp"
#include "host/common/rounded_parts.hpp"
#include "host/common/vec3.hpp"

namespace mortise::pipeline {
namespace {

using Shape = RoundedSolid::Shape;

constexpr double kPlateLike = 2;  ///< widths across to thickness, at least
constexpr double kFar = 4;        ///< extents by which the sides go on
constexpr double kTilt = 0.06;    ///< radians: less than what makes a crease
constexpr double kClear = 0.02;   ///< sine between facets and a direction that they are not parallel to
constexpr int kDirectionsAcross = 36;
constexpr double kNoDirection = 1e-9;  ///< of the extent: differences of centres

/// The greatest u·x in the solid; infinite where it has no end.
double support(const RoundedSolid& solid, const Vec3& u) {
    double most = -std::numeric_limits<double>::infinity();
    const double in_plane = std::hypot(u[0], u[1]);
    for (const Ball& ball : solid.balls) {
        const Vec3& c = ball.center;
        switch (solid.shape) {
            case Shape::kHull: most = std::max(most, dot(u, c) + ball.radius); break;
            case Shape::kColumn:
            case Shape::kPlate:
                most = std::max(most, u[0] * c[0] + u[1] * c[1] + ball.radius * in_plane);
                break;
            case Shape::kRevolution:
            case Shape::kRing: most = std::max(most, in_plane * c[0] + u[2] * c[1] + ball.radius); break;
        }
    }
    if (solid.shape == Shape::kColumn && u[2] != 0) return std::numeric_limits<double>::infinity();
    if (solid.shape == Shape::kPlate) most += std::max(u[2] * solid.low, u[2] * solid.high) + solid.rounding;
    return most;
}

/// For a direction of length 1.
double width(const RoundedSolid& solid, const Vec3& u) {
    return support(solid, u) + support(solid, {-u[0], -u[1], -u[2]});
}

/// Normals of what could be the large faces of a plate.
std::vector<Vec3> candidates(const RoundedSolid& solid) {
    std::vector<Vec3> found = {{0, 0, 1}};
    if (solid.shape == Shape::kRevolution) return found;
    found.push_back({1, 0, 0});
    found.push_back({0, 1, 0});
    const auto add = [&](const Vec3& normal, double extent) {
        const double size = length(normal);
        if (size > kNoDirection * extent) found.push_back(scaled(normal, 1 / size));
    };
    const std::vector<Ball>& balls = solid.balls;
    const double extent = std::max(width(solid, {1, 0, 0}), width(solid, {0, 1, 0}));
    for (std::size_t i = 1; i < balls.size(); ++i) {
        const Vec3 a = difference(balls[i].center, balls[0].center);
        for (std::size_t j = 0; j < i; ++j) {
            if (solid.shape == Shape::kHull) {
                add(cross(a, difference(balls[j].center, balls[0].center)), extent * extent);
            } else {
                const Vec3 b = difference(balls[i].center, balls[j].center);
                add({-b[1], b[0], 0}, extent);
            }
        }
    }
    return found;
}

/// The thin direction of a solid that is like a plate, if it is thinner than `thickness`.
std::optional<Vec3> thin_direction(const RoundedSolid& solid, double thickness) {
    if (solid.shape == Shape::kRing) return std::nullopt;
    // What holds a ball is no thinner than it.
    double radius = solid.rounding;
    for (const Ball& ball : solid.balls) {
        if (solid.shape != Shape::kPlate) radius = std::max(radius, ball.radius);
    }
    if (2 * radius >= thickness) return std::nullopt;
    Vec3 thin{};
    double least = thickness;
    for (const Vec3& u : candidates(solid)) {
        const double across = width(solid, u);
        if (!(across < least)) continue;
        least = across;
        thin = u;
    }
    if (least == thickness) return std::nullopt;
    Vec3 v = cross(thin, std::fabs(thin[0]) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
    v = scaled(v, 1 / length(v));
    const Vec3 w = cross(thin, v);
    for (int k = 0; k < kDirectionsAcross; ++k) {
        const double angle = kPi * k / kDirectionsAcross;
        const Vec3 u = sum(scaled(v, std::cos(angle)), scaled(w, std::sin(angle)));
        if (width(solid, u) < kPlateLike * least) return std::nullopt;
    }
    return thin;
}

/// How far the solid's facets are from being parallel to a direction, at least: |sine|.
double clearance(const std::vector<Vec3>& normals, const Vec3& u) {
    double least = 1;
    for (const Vec3& normal : normals) least = std::min(least, std::fabs(dot(normal, u)));
    return least;
}

/// The direction, or one close to it that no facet is parallel to: those would be facets of both sides.
std::optional<Vec3> clear_direction(const RoundedSolid& solid, const Vec3& thin) {
    std::vector<Vec3> normals;
    for (const auto& facet : rounded_parts(solid).facets) normals.push_back(facet.normal);
    if (solid.shape == Shape::kRevolution) {  // in the plane (distance from the axis, z)
        for (Vec3& normal : normals) normal = {0, 0, normal[1]};
    }
    if (clearance(normals, thin) >= kClear) return thin;
    if (solid.shape == Shape::kRevolution) return std::nullopt;
    Vec3 v = cross(thin, {0, 0, 1});  // of a column the only one
    if (solid.shape != Shape::kColumn && length(v) < kTilt) v = cross(thin, {1, 0, 0});
    v = unit(v);
    const Vec3 w = solid.shape == Shape::kColumn ? v : cross(thin, v);
    Vec3 best = thin;
    for (int k = 0; k < 2 * kDirectionsAcross; ++k) {
        const double angle = kPi * k / kDirectionsAcross;
        const Vec3 aside = unit(sum(scaled(v, std::cos(angle)), scaled(w, std::sin(angle))));
        const Vec3 tilted = unit(sum(thin, scaled(aside, kTilt)));
        if (clearance(normals, tilted) > clearance(normals, best)) best = tilted;
    }
    if (clearance(normals, best) < kClear) return std::nullopt;
    return best;
}

/// A plate whose outline has no radii is the hull of balls; other plates are none.
std::optional<RoundedSolid> without_heights(const RoundedSolid& solid) {
    if (solid.shape != Shape::kPlate) return solid;
    RoundedSolid hull;
    for (const Ball& ball : solid.balls) {
        if (ball.radius != 0) return std::nullopt;
        for (const double z : {solid.low, solid.high})
            hull.balls.push_back({{ball.center[0], ball.center[1], z}, solid.rounding});
    }
    return hull;
}

/// The solid swept along its thin direction, or the other way.
RoundedSolid swept(const RoundedSolid& solid, const Vec3& thin, bool is_forward) {
    double extent = 0;
    for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        const double along = width(solid, axis);
        if (std::isfinite(along)) extent = std::max(extent, along);
    }
    const double by = (is_forward ? kFar : -kFar) * extent;
    RoundedSolid result = solid;
    for (const Ball& ball : solid.balls) {
        Ball moved = ball;
        if (solid.shape == Shape::kRevolution) {
            moved.center[1] += by;
        } else {
            moved.center = sum(ball.center, scaled(thin, by));
        }
        result.balls.push_back(moved);
    }
    return result;
}

/// Per node the least factor by which maps above it stretch, infinite if no region uses it.
std::vector<double> least_stretch(const Model& model) {
    std::vector<double> stretch(model.nodes.size(), std::numeric_limits<double>::infinity());
    for (const Region& region : model.regions) stretch[region.root] = 1;
    for (std::size_t i = model.nodes.size(); i-- > 0;) {
        const CsgNode& node = model.nodes[i];
        double factor = stretch[i];
        if (node.op == CsgNode::Op::kTransform) {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t j = 0; j < 3; ++j)
                least = std::min(least, std::hypot(node.map[j], node.map[4 + j], node.map[8 + j]));
            factor *= least;
        }
        for (const std::uint32_t child : node.children) stretch[child] = std::min(stretch[child], factor);
    }
    return stretch;
}

}  // namespace

std::optional<Model> part_thin_solids(const Model& model, double thickness) {
    const auto is_rounded = [](const CsgNode& node) {
        return node.op == CsgNode::Op::kPrimitive && node.primitive.kind == Primitive::Kind::kRounded;
    };
    if (std::none_of(model.nodes.begin(), model.nodes.end(), is_rounded)) return std::nullopt;
    const std::vector<double> stretch = least_stretch(model);
    Model result = model;
    result.nodes.clear();
    std::vector<std::uint32_t> place(model.nodes.size());  // in the result
    std::vector<std::vector<std::uint32_t>> sides(model.nodes.size());
    bool any = false;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        CsgNode node = model.nodes[i];
        for (std::uint32_t& child : node.children) child = place[child];
        std::optional<Vec3> thin;
        std::optional<RoundedSolid> solid;
        if (is_rounded(node)) solid = without_heights(*node.primitive.rounded);
        if (solid) thin = thin_direction(*solid, thickness / stretch[i]);
        if (thin) thin = clear_direction(*solid, *thin);
        if (thin) {
            any = true;
            for (const bool is_forward : {false, true})
                sides[i].push_back(
                    result.add_primitive(rounded(swept(*solid, *thin, is_forward)), {}, node.where));
            node.op = CsgNode::Op::kIntersection;
            node.children = sides[i];
            node.primitive = {};
        }
        place[i] = result.add(std::move(node));
        if (!thin) sides[i] = {place[i]};
    }
    if (!any) return std::nullopt;
    const auto replace = [&](std::vector<std::uint32_t>& primitives) {
        std::vector<std::uint32_t> all;
        for (const std::uint32_t primitive : primitives)
            all.insert(all.end(), sides[primitive].begin(), sides[primitive].end());
        primitives = std::move(all);
    };
    for (Region& region : result.regions) region.root = place[region.root];
    for (SizeHint& hint : result.hints) {
        for (std::vector<std::uint32_t>& group : hint.groups) replace(group);
    }
    for (PeriodicPair& pair : result.periodic) {
        replace(pair.first);
        replace(pair.second);
    }
    return result;
}

}  // namespace mortise::pipeline
