#include "host/model/solids/plane_cut.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/node_boxes.hpp"
#include "host/model/solids/rounded_facets.hpp"
#include "host/model/solids/section.hpp"

namespace mortise::model_reader {
namespace {

using Kind = Primitive::Kind;
using State = Slice::State;

Vec3 row(const Affine& map, std::size_t k) { return {map[4 * k], map[4 * k + 1], map[4 * k + 2]}; }

/// a + b·x + c·y: a coordinate of the primitive's frame on the plane.
struct Linear {
    double a = 0, b = 0, c = 0;
};

Linear coordinate(const Affine& to_local, std::size_t k) {
    return {to_local[4 * k + 3], to_local[4 * k], to_local[4 * k + 1]};
}

/// xx x² + 2 xy x y + yy y² + 2 x0 x + 2 y0 y + a constant: a sum of squares.
struct Quadratic {
    double xx = 0, xy = 0, yy = 0, x0 = 0, y0 = 0;
    double constant = 0;  ///< beside the terms
    std::vector<std::pair<Linear, double>> terms;

    void add_square(const Linear& l, double factor) {
        terms.emplace_back(l, factor);
        xx += factor * l.b * l.b;
        xy += factor * l.b * l.c;
        yy += factor * l.c * l.c;
        x0 += factor * l.a * l.b;
        y0 += factor * l.a * l.c;
    }
    /// Term by term: far from the origin the expanded form would lose digits.
    double value(const Vec2& p) const {
        double sum = constant;
        for (const auto& [l, factor] : terms) {
            const double distance = l.a + l.b * p[0] + l.c * p[1];
            sum += factor * distance * distance;
        }
        return sum;
    }
    /// The smaller eigenvalue of the quadratic part in units of the larger; 0 if both are.
    double roundness() const {
        const double middle = (xx + yy) / 2;
        const double apart = std::hypot((xx - yy) / 2, xy);
        const double larger = std::max(std::fabs(middle + apart), std::fabs(middle - apart));
        return larger > 0 ? (middle - apart) / larger : 0;
    }
};

/// { q <= 0 } of a positive definite form: an ellipse or nothing; `centre` is set.
Slice ellipse_slice(const Quadratic& q, PlaneCut& cut, Vec2& centre) {
    const double determinant = q.xx * q.yy - q.xy * q.xy;
    centre = {-(q.yy * q.x0 - q.xy * q.y0) / determinant, -(q.xx * q.y0 - q.xy * q.x0) / determinant};
    const double depth = -q.value(centre);
    // Half axes below what six digits can tell: the plane touches.
    const double narrowest = std::sqrt(std::max(depth, 0.0) / std::max(q.xx, q.yy));
    if (!(narrowest > kSameHeight * cut.size)) return {};
    return {State::kNode,
            {},
            add_ellipse(cut.flat, centre, depth * q.yy / determinant, -depth * q.xy / determinant,
                        depth * q.xx / determinant, cut.sides)};
}

Slice convex_slice(const std::vector<Plane>& planes, const Affine& to_local, PlaneCut& cut) {
    Slice slice{State::kPlanes};
    for (const Plane& plane : planes) {
        // The gradient in the model's frame, and the value at its origin.
        double value = -plane.offset;
        Vec3 normal{};
        for (std::size_t k = 0; k < 3; ++k) {
            value += plane.normal[k] * to_local[4 * k + 3];
            for (std::size_t j = 0; j < 3; ++j) normal[j] += plane.normal[k] * to_local[4 * k + j];
        }
        const double size = length(normal);
        const double across = std::hypot(normal[0], normal[1]);
        if (across > kSameHeight * size) {
            slice.planes.push_back({{normal[0] / across, normal[1] / across}, -value / across});
            continue;
        }
        const bool in_plane = std::fabs(value / size) <= kSameHeight * cut.size;
        cut.touched = cut.touched || in_plane;
        // Just above the plane the value has the sign of the normal's z.
        const bool outside = in_plane ? (normal[2] > 0) == cut.above : value > 0;
        if (outside) return {};
    }
    return slice.planes.empty() ? Slice{State::kEverything} : slice;
}

Slice cylinder_slice(double radius, const Affine& to_local, PlaneCut& cut) {
    const Linear x = coordinate(to_local, 0);
    const Linear y = coordinate(to_local, 1);
    Quadratic q;
    q.add_square(x, 1);
    q.add_square(y, 1);
    q.constant = -radius * radius;
    if (q.roundness() > kSameHeight * kSameHeight) {
        Vec2 centre{};
        return ellipse_slice(q, cut, centre);
    }
    // Along the axis: a strip. (b, c) of both coordinates have one direction; t runs along it.
    const Linear& longer = std::hypot(x.b, x.c) > std::hypot(y.b, y.c) ? x : y;
    const double unit = std::hypot(longer.b, longer.c);
    const Vec2 along = {longer.b / unit, longer.c / unit};
    const Vec2 rate = {x.b * along[0] + x.c * along[1], y.b * along[0] + y.c * along[1]};
    const double speed = std::hypot(rate[0], rate[1]);
    const double nearest = -(rate[0] * x.a + rate[1] * y.a) / (speed * speed);
    const double distance = std::fabs(rate[0] * y.a - rate[1] * x.a) / speed;
    if (!(distance < radius)) return {};
    const double half = std::sqrt((radius - distance) * (radius + distance)) / speed;
    if (!(half > kSameHeight * cut.size)) return {};
    return {State::kPlanes, {{along, nearest + half}, {{-along[0], -along[1]}, half - nearest}}};
}

/// A nappe cut along a parabola or a hyperbola: the hull of where its generators meet the plane, as far as
/// the clip box reaches along the axis. Inside the box it is right if the box holds a whole frustum.
std::optional<Slice> open_cone_slice(const Primitive& cone, const Affine& map, const Affine& to_local,
                                     const Box3& clip, PlaneCut& cut) {
    const Box3 local = image_of(to_local, clip);
    if (!std::isfinite(local.min[2]) || !std::isfinite(local.max[2])) return std::nullopt;
    const double reach = (local.max[2] - local.min[2]) / 16;
    const double low = local.min[2] - reach;
    const double high = local.max[2] + reach;
    // The plane in the cone's frame: m · p = q. At the angle t the generator is (R cos t, R sin t, z).
    const Vec3 m = row(map, 2);
    const double q = -map[11];
    std::vector<Vec2> points;
    const auto add = [&](double turn, double z) {
        const double radius = cone.radius + cone.slope * z;
        if (radius < 0) return;
        const Vec3 p = {radius * std::cos(turn), radius * std::sin(turn), z};
        points.push_back({dot(row(map, 0), p) + map[3], dot(row(map, 1), p) + map[7]});
    };
    const double across = std::hypot(m[0], m[1]);
    const double phase = std::atan2(m[1], m[0]);
    // Where the curve meets the ends; every generator between them is met once at most.
    std::vector<double> turns;
    for (const double z : {low, high}) {
        const double radius = cone.radius + cone.slope * z;
        if (!(radius > 0)) continue;
        const double cosine = (q - m[2] * z) / (radius * across);
        if (!(std::fabs(cosine) <= 1)) continue;
        for (const double sign : {-1.0, 1.0}) {
            turns.push_back(phase + sign * std::acos(cosine));
            add(turns.back(), z);
        }
    }
    const int steps = 4 * cut.sides;
    for (int i = 0; i < steps; ++i) turns.push_back(phase + 2 * kPi * i / steps);
    for (const double turn : turns) {
        const double slant = m[0] * std::cos(turn) + m[1] * std::sin(turn);
        const double z = (q - cone.radius * slant) / (m[2] + cone.slope * slant);
        if (std::isfinite(z) && z >= low && z <= high) add(turn, z);
    }
    // The apex, if the plane holds it.
    const double apex = -cone.radius / cone.slope;
    if (apex >= low && apex <= high && std::fabs(m[2] * apex - q) <= kSameHeight * cut.size * length(m)) {
        add(0, apex);
    }
    const Contours hull = convex_hull({points});
    if (hull.empty()) return Slice{};
    return Slice{State::kNode, {}, cut.flat.add_contours(hull)};
}

std::optional<Slice> cone_slice(const Primitive& cone, const Affine& map, const Affine& to_local,
                                const Box3& clip, PlaneCut& cut) {
    const Linear z = coordinate(to_local, 2);
    const Linear radius = {cone.radius + cone.slope * z.a, cone.slope * z.b, cone.slope * z.c};
    Quadratic q;
    q.add_square(coordinate(to_local, 0), 1);
    q.add_square(coordinate(to_local, 1), 1);
    q.add_square(radius, -1);
    constexpr double kEllipse = 1e-4;
    if (q.roundness() < kEllipse) return open_cone_slice(cone, map, to_local, clip, cut);
    Vec2 centre{};
    const Slice slice = ellipse_slice(q, cut, centre);
    // The other nappe is none of ours.
    return radius.a + radius.b * centre[0] + radius.c * centre[1] > 0 ? slice : Slice{};
}

/// The circle of that radius about a point of the plane spanned by u and v in the primitive's frame.
std::uint32_t add_circle(const Affine& map, const Vec3& centre, const Vec3& u, const Vec3& v, double radius,
                         PlaneCut& cut) {
    std::array<Vec2, 3> image{};
    for (std::size_t k = 0; k < 2; ++k) {
        image[0][k] = dot(row(map, k), centre) + map[4 * k + 3];
        image[1][k] = radius * dot(row(map, k), u);
        image[2][k] = radius * dot(row(map, k), v);
    }
    const auto& [c, a, b] = image;
    return add_ellipse(cut.flat, c, a[0] * a[0] + b[0] * b[0], a[0] * a[1] + b[0] * b[1],
                       a[1] * a[1] + b[1] * b[1], cut.sides);
}

std::optional<Slice> torus_slice(const Primitive& torus, const Affine& map, PlaneCut& cut) {
    // The plane in the frame of the torus: m · p = q.
    const Vec3 given = row(map, 2);
    const double size = length(given);
    const Vec3 m = {given[0] / size, given[1] / size, given[2] / size};
    const double q = -map[11] / size;
    const Vec3 x = {1, 0, 0};
    const Vec3 y = {0, 1, 0};
    const Vec3 z = {0, 0, 1};
    const double across = std::hypot(m[0], m[1]);
    if (across <= kSameHeight) {
        const double height = q / m[2];
        if (!(std::fabs(height) < torus.radius)) return Slice{};
        const double half = std::sqrt((torus.radius - height) * (torus.radius + height));
        if (!(half > kSameHeight * torus.major)) return Slice{};
        const Vec3 centre = {0, 0, height};
        const std::uint32_t outer = add_circle(map, centre, x, y, torus.major + half, cut);
        if (!(torus.major > half)) return Slice{State::kNode, {}, outer};
        const std::uint32_t inner = add_circle(map, centre, x, y, torus.major - half, cut);
        return Slice{State::kNode, {}, cut.flat.add_operation(FlatNode::Op::kDifference, {outer, inner})};
    }
    if (std::fabs(m[2]) > kSameHeight || std::fabs(q) > kSameHeight * torus.major) return std::nullopt;
    const Vec3 out = {-m[1] / across, m[0] / across, 0};
    std::vector<std::uint32_t> circles;
    for (const double side : {-torus.major, torus.major}) {
        circles.push_back(add_circle(map, {side * out[0], side * out[1], 0}, out, z, torus.radius, cut));
    }
    return Slice{State::kNode, {}, cut.flat.add_operation(FlatNode::Op::kUnion, std::move(circles))};
}

Slice polyhedron_slice(const TriangleSurface& surface, const Affine& map, PlaneCut& cut) {
    std::vector<Vec3> points;
    points.reserve(surface.points.size());
    for (const Vec3& p : surface.points) {
        Vec3 image{};
        for (std::size_t k = 0; k < 3; ++k) image[k] = dot(row(map, k), p) + map[4 * k + 3];
        if (std::fabs(image[2]) <= kSameHeight * cut.size) image[2] = 0;
        points.push_back(image);
    }
    const auto is_above = [&](std::uint32_t i) {
        return points[i][2] > 0 || (points[i][2] == 0 && !cut.above);
    };
    // Where a triangle's edge goes down through the plane a piece of the outline begins, where it goes up it
    // ends: the solid is on its left. Pieces are linked by the edges of the surface.
    struct Crossing {
        std::uint64_t from, to;
        Vec2 point;  ///< at `from`
        bool used = false;
    };
    std::vector<Crossing> crossings;
    std::unordered_multimap<std::uint64_t, std::size_t> beginning;
    for (const auto& triangle : surface.triangles) {
        bool in_plane = true;
        for (const std::uint32_t corner : triangle) in_plane = in_plane && points[corner][2] == 0;
        cut.touched = cut.touched || in_plane;
        Crossing crossing{};
        int found = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t i = triangle[k];
            const std::uint32_t j = triangle[(k + 1) % 3];
            if (is_above(i) == is_above(j)) continue;
            ++found;
            const std::uint64_t edge = std::uint64_t{std::min(i, j)} << 32 | std::max(i, j);
            if (!is_above(i)) {
                crossing.to = edge;
                continue;
            }
            crossing.from = edge;
            // From the lower number: both triangles of the edge find the same point.
            const Vec3& p = points[std::min(i, j)];
            const Vec3& q = points[std::max(i, j)];
            const double t = p[2] / (p[2] - q[2]);
            crossing.point = {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])};
        }
        if (found != 2) continue;
        beginning.emplace(crossing.from, crossings.size());
        crossings.push_back(crossing);
    }
    Contours loops;
    for (std::size_t start = 0; start < crossings.size(); ++start) {
        std::vector<Vec2> loop;
        // A loop that does not close, at an open edge, is closed by a straight line.
        for (std::size_t at = start; at < crossings.size() && !crossings[at].used;) {
            crossings[at].used = true;
            loop.push_back(crossings[at].point);
            const auto [first, last] = beginning.equal_range(crossings[at].to);
            at = crossings.size();
            for (auto next = first; next != last; ++next) {
                if (!crossings[next->second].used) at = next->second;
            }
        }
        loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
        // To six digits: faces are divided into triangles.
        drop_straight(loop, kSameHeight * cut.size);
        if (relative_determinant(map) < 0) std::reverse(loop.begin(), loop.end());
        if (loop.size() > 2) loops.push_back(std::move(loop));
    }
    const std::uint32_t node = cut.flat.add_contours(wound(loops));
    if (cut.flat.nodes[node].contours.empty()) return {};
    return {State::kNode, {}, node};
}

/// Of a column the part in the clip box; nothing if that has no end.
std::optional<Slice> rounded_slice(RoundedSolid solid, const Affine& map, const Affine& to_local,
                                   const Box3& clip, PlaneCut& cut) {
    if (solid.shape == RoundedSolid::Shape::kColumn) {
        const Box3 local = image_of(to_local, clip);
        const double margin = local.max[2] - local.min[2];
        if (!std::isfinite(margin)) return std::nullopt;
        solid.low = local.min[2] - margin;
        solid.high = local.max[2] + margin;
    }
    return polyhedron_slice(facets_of(solid), map, cut);
}

}  // namespace

std::optional<Slice> slice_of(const Primitive& primitive, const Affine& map, const Box3& clip,
                              PlaneCut& cut) {
    const Affine to_local = inverse_of(map);
    switch (primitive.kind) {
        case Kind::kConvex: return convex_slice(primitive.planes, to_local, cut);
        case Kind::kSphere: {
            Quadratic q;
            for (std::size_t k = 0; k < 3; ++k) q.add_square(coordinate(to_local, k), 1);
            q.constant = -primitive.radius * primitive.radius;
            Vec2 centre{};
            return ellipse_slice(q, cut, centre);
        }
        case Kind::kCylinder: return cylinder_slice(primitive.radius, to_local, cut);
        case Kind::kCone: return cone_slice(primitive, map, to_local, clip, cut);
        case Kind::kTorus: return torus_slice(primitive, map, cut);
        case Kind::kPolyhedron: return polyhedron_slice(*primitive.triangles, map, cut);
        case Kind::kRounded: return rounded_slice(*primitive.rounded, map, to_local, clip, cut);
        case Kind::kDoubleCone:
        case Kind::kExpression: break;
    }
    return std::nullopt;
}

std::uint32_t add_ellipse(FlatTree& flat, const Vec2& centre, double xx, double xy, double yy, int sides) {
    const double mean = (xx + yy) / 2;
    if (std::fabs(xx - yy) <= 4 * kSameHeight * mean && std::fabs(xy) <= 2 * kSameHeight * mean) {
        const std::uint32_t circle = flat.add_circle(std::sqrt(mean), sides);
        if (centre == Vec2{0, 0}) return circle;
        return flat.add_transform({1, 0, centre[0], 0, 1, centre[1]}, circle);
    }
    // Cholesky's factor.
    const double a = std::sqrt(xx);
    const double b = xy / a;
    const double c = std::sqrt(yy - b * b);
    return flat.add_transform({a, 0, centre[0], b, c, centre[1]}, flat.add_circle(1, sides));
}

void drop_straight(std::vector<Vec2>& loop, double tolerance) {
    if (loop.size() < 4) return;
    // Begins at a corner: the point farthest from the loop's first one.
    const auto farther = [&loop](const Vec2& a, const Vec2& b) {
        const Vec2& o = loop[0];
        return std::hypot(a[0] - o[0], a[1] - o[1]) < std::hypot(b[0] - o[0], b[1] - o[1]);
    };
    std::rotate(loop.begin(), std::max_element(loop.begin(), loop.end(), farther), loop.end());
    std::vector<Vec2> kept = {loop[0]};
    constexpr std::size_t kMostDropped = 64;  // so that the time is linear
    std::size_t first = 1;                    // of those not decided yet
    for (std::size_t i = 1; i < loop.size(); ++i) {
        const Vec2& a = kept.back();
        const Vec2& b = loop[(i + 1) % loop.size()];
        const double span = std::hypot(b[0] - a[0], b[1] - a[1]);
        bool straight = span > tolerance && i - first < kMostDropped;
        for (std::size_t j = first; j <= i && straight; ++j) {
            const Vec2 d = {loop[j][0] - a[0], loop[j][1] - a[1]};
            const double off = ((b[0] - a[0]) * d[1] - (b[1] - a[1]) * d[0]) / span;
            const double along = ((b[0] - a[0]) * d[0] + (b[1] - a[1]) * d[1]) / span;
            straight = std::fabs(off) <= tolerance && along >= -tolerance && along <= span + tolerance;
        }
        if (straight) continue;
        kept.push_back(loop[i]);
        first = i + 1;
    }
    loop = std::move(kept);
}

Contours cut_rectangle(const std::vector<HalfPlane>& planes, const Box3& clip) {
    const double margin =
        std::max({clip.max[0] - clip.min[0], clip.max[1] - clip.min[1], 1e-6 * std::fabs(clip.max[0])}) / 16;
    const Vec2 low = {clip.min[0] - margin, clip.min[1] - margin};
    const Vec2 high = {clip.max[0] + margin, clip.max[1] + margin};
    std::vector<Vec2> polygon = {low, {high[0], low[1]}, high, {low[0], high[1]}};
    for (const HalfPlane& plane : planes) {
        const auto value = [&](const Vec2& p) {
            return plane.normal[0] * p[0] + plane.normal[1] * p[1] - plane.offset;
        };
        std::vector<Vec2> kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2& p = polygon[i];
            const Vec2& q = polygon[(i + 1) % polygon.size()];
            const double at_p = value(p);
            const double at_q = value(q);
            if (at_p <= 0) kept.push_back(p);
            if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0)) {
                const double t = at_p / (at_p - at_q);
                kept.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
            }
        }
        polygon = std::move(kept);
    }
    return {polygon};
}

}  // namespace mortise::model_reader
