#include "host/model/solids/rounded_facets.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/rounded_parts.hpp"
#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/convex_pieces.hpp"

namespace mortise::model_reader {
namespace {

using Shape = RoundedSolid::Shape;

constexpr double kFacetAngle = kTurn / kFacets;

/// Directions of an arc from end to end, in steps of kFacetAngle at most.
std::vector<Vec3> directions_of(const RoundedParts::Arc& arc) {
    Vec3 x = arc.middle;
    const bool whole = x == Vec3{};
    if (whole) {
        const Affine frame = frame_along(arc.axis, {});
        x = {frame[0], frame[4], frame[8]};
    }
    const Vec3 y = cross(arc.axis, x);
    const double half = whole ? kTurn / 2 : std::acos(std::clamp(arc.cosine, -1.0, 1.0));
    const int steps = std::max(1, static_cast<int>(std::ceil(2 * half / kFacetAngle - 1e-6)));
    std::vector<Vec3> result;
    for (int i = 0; i < steps + (whole ? 0 : 1); ++i) {
        const double turn = half * (2.0 * i / steps - 1);
        const Vec3 across = sum(scaled(x, std::cos(turn)), scaled(y, std::sin(turn)));
        result.push_back(sum(scaled(arc.axis, arc.along), scaled(across, arc.across)));
    }
    return result;
}

/// Directions by latitude and longitude.
std::vector<Vec3> sphere_directions() {
    std::vector<Vec3> result;
    for (int ring = 0; ring <= kFacets / 2; ++ring) {
        const bool pole = ring == 0 || ring == kFacets / 2;
        const double polar = kFacetAngle * ring;
        for (int i = 0; i < (pole ? 1 : kFacets); ++i) {
            const double turn = kFacetAngle * i;
            result.push_back(
                {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
        }
    }
    return result;
}

std::vector<Vec3> hull_points(const RoundedParts& parts) {
    std::vector<Vec3> points;
    const auto add = [&](std::size_t i, const Vec3& direction) {
        points.push_back(sum(parts.balls[i].center, scaled(direction, parts.balls[i].radius)));
    };
    for (const auto& arc : parts.arcs) {
        for (const Vec3& direction : directions_of(arc)) {
            add(arc.ball, direction);
            if (arc.other != arc.ball) add(arc.other, direction);
        }
    }
    // Not close to an arc, where its own points are: triangles between would be slivers.
    const double apart = std::sin(0.5 * kFacetAngle);
    const std::vector<Vec3> directions = sphere_directions();
    for (const auto& cap : parts.caps) {
        for (const Vec3& direction : directions) {
            bool inside = true;
            for (std::size_t k = 0; k < cap.axes.size(); ++k)
                inside = inside && dot(direction, cap.axes[k]) <= cap.along[k] - apart;
            if (inside) add(cap.ball, direction);
        }
    }
    return points;
}

/// The outline of discs, counter-clockwise, with the direction at each point.
struct Rim {
    Vec2 point;
    Vec2 normal;
};
std::vector<Rim> rim_of(const RoundedSolid& solid) {
    RoundedParts parts = rounded_parts(solid);
    const auto angle = [](const RoundedParts::Arc& arc) { return std::atan2(arc.middle[1], arc.middle[0]); };
    std::sort(parts.arcs.begin(), parts.arcs.end(),
              [&](const auto& a, const auto& b) { return angle(a) < angle(b); });
    std::vector<Rim> rim;
    for (const auto& arc : parts.arcs) {
        const Ball& ball = parts.balls[arc.ball];
        for (const Vec3& d : directions_of(arc)) {
            const Vec2 point = {ball.center[0] + ball.radius * d[0], ball.center[1] + ball.radius * d[1]};
            rim.push_back({point, {d[0], d[1]}});
        }
    }
    return rim;
}

std::vector<Vec3> plate_points(const RoundedSolid& solid) {
    std::vector<Vec3> points;
    const double q = solid.rounding;
    const int steps = q > 0 ? kFacets / 4 : 0;
    for (const Rim& rim : rim_of(solid)) {
        for (int k = 0; k <= steps; ++k) {
            const double turn = kFacetAngle * k;
            const double out = q * std::cos(turn);
            const Vec2 at = {rim.point[0] + out * rim.normal[0], rim.point[1] + out * rim.normal[1]};
            points.push_back({at[0], at[1], solid.high + q * std::sin(turn)});
            points.push_back({at[0], at[1], solid.low - q * std::sin(turn)});
        }
    }
    return points;
}

std::vector<Vec3> turned_points(const RoundedSolid& solid) {
    std::vector<Vec3> points;
    for (const Rim& rim : rim_of(solid)) {
        if (rim.point[0] < 0) continue;
        for (int i = 0; i < kFacets; ++i) {
            const double turn = kFacetAngle * i;
            points.push_back({rim.point[0] * std::cos(turn), rim.point[0] * std::sin(turn), rim.point[1]});
        }
    }
    return points;
}

}  // namespace

std::vector<Vec3> points_of(const RoundedSolid& solid) {
    switch (solid.shape) {
        case Shape::kHull: return hull_points(rounded_parts(solid));
        case Shape::kRevolution:
        case Shape::kRing: return turned_points(solid);
        case Shape::kColumn:
        case Shape::kPlate: break;
    }
    return plate_points(solid);
}

namespace {

/// Two triangles between each two points of the outline and of the turn.
TriangleSurface ring_facets(const RoundedSolid& solid) {
    TriangleSurface surface;
    surface.points = turned_points(solid);
    const auto count = static_cast<std::uint32_t>(surface.points.size() / kFacets);
    const auto at = [count](std::uint32_t k, int i) {
        return (k % count) * kFacets + static_cast<std::uint32_t>(i % kFacets);
    };
    for (std::uint32_t k = 0; k < count; ++k) {
        for (int i = 0; i < kFacets; ++i) {
            surface.triangles.push_back({at(k, i), at(k, i + 1), at(k + 1, i)});
            surface.triangles.push_back({at(k + 1, i), at(k, i + 1), at(k + 1, i + 1)});
        }
    }
    return surface;
}

}  // namespace

TriangleSurface facets_of(const RoundedSolid& solid) {
    if (solid.shape == Shape::kRing) return ring_facets(solid);
    const std::optional<Polytope> hull = convex_hull(points_of(solid));
    return hull ? triangles_of(*hull) : TriangleSurface{};
}

std::vector<Vec2> outline_of(const RoundedSolid& solid) {
    std::vector<Vec2> outline;
    for (const Rim& rim : rim_of(solid)) outline.push_back(rim.point);
    outline.erase(std::unique(outline.begin(), outline.end()), outline.end());
    return outline;
}

Box3 box_of(const RoundedSolid& solid) {
    Box3 box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (const Ball& ball : solid.balls) {
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::min(box.min[k], ball.center[k] - ball.radius);
            box.max[k] = std::max(box.max[k], ball.center[k] + ball.radius);
        }
    }
    if (solid.shape == Shape::kColumn) {
        box.min[2] = -kInfinity;
        box.max[2] = kInfinity;
    } else if (solid.shape == Shape::kPlate) {
        box.min[2] = solid.low;
        box.max[2] = solid.high;
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] -= solid.rounding;
            box.max[k] += solid.rounding;
        }
    } else if (solid.shape == Shape::kRevolution || solid.shape == Shape::kRing) {
        const double reach = std::max(std::fabs(box.min[0]), std::fabs(box.max[0]));
        box = {{-reach, -reach, box.min[1]}, {reach, reach, box.max[1]}};
    }
    return box;
}

}  // namespace mortise::model_reader
