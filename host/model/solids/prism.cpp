#include "host/model/solids/prism.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/model/outlines/polygon_triangles.hpp"
#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostNamedSides = 24;
constexpr std::size_t kFewEdges = 8;
constexpr double kDegree = 3.14159265358979323846 / 180;

using Loop = std::vector<Vec2>;

const Vec2& at(const Loop& loop, std::size_t i) { return loop[i % loop.size()]; }

double cross(const Vec2& o, const Vec2& a, const Vec2& b) {
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

/// Whether the outline turns by no more than that many degrees where edge i ends.
bool is_smooth_after(const Loop& loop, std::size_t i, double degrees) {
    const Vec2& a = at(loop, i);
    const Vec2& b = at(loop, i + 1);
    const Vec2& c = at(loop, i + 2);
    const Vec2 u = {b[0] - a[0], b[1] - a[1]};
    const Vec2 v = {c[0] - b[0], c[1] - b[1]};
    const double turn = std::fabs(std::atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]));
    return turn <= (degrees + 1e-6) * kDegree;
}

bool is_curved(const Loop& loop, double degrees) {
    if (loop.size() <= kMostSharpEdges) return false;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        if (is_smooth_after(loop, i, degrees)) return true;
    }
    return false;
}

/// Each turn to the left, or each to the right.
bool is_convex(const Loop& loop) {
    const bool left = signed_area(loop) > 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const double turn = cross(at(loop, i), at(loop, i + 1), at(loop, i + 2));
        if (left ? turn < 0 : turn > 0) return false;
    }
    return true;
}

/// Per edge the number of the side that it is part of, from 0.
std::vector<std::uint32_t> sides_of(const Loop& loop, double sharp_angle) {
    const std::size_t n = loop.size();
    std::vector<std::uint32_t> side(n, 0);
    const bool curved = sharp_angle > 0 && is_curved(loop, sharp_angle);
    // From a corner on, so that no side is cut where the loop happens to begin.
    std::size_t first = 0;
    while (curved && first < n && is_smooth_after(loop, first + n - 1, sharp_angle)) ++first;
    if (first == n) return side;
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        side[(first + i) % n] = count;
        if (!curved || !is_smooth_after(loop, first + i, sharp_angle)) ++count;
    }
    return side;
}

/// The outline as polygons of point numbers. Their holes are joined to the outer loop by bridges, from the
/// hole's rightmost corner: it sees the outer loop or a hole that is joined already (Eberly, Triangulation by
/// ear clipping).
class Bridges {
  public:
    explicit Bridges(const Contours& loops) {
        for (const Loop& loop : loops) points_.insert(points_.end(), loop.begin(), loop.end());
        std::uint32_t first = 0;
        for (std::size_t i = 0; i < loops.size();) {
            Polygon polygon = numbers(loops[i], first);
            std::vector<Polygon> holes;
            for (++i; i < loops.size() && signed_area(loops[i]) < 0; ++i) {
                Polygon hole = numbers(loops[i], first);
                const auto rightmost = std::max_element(
                    hole.begin(), hole.end(),
                    [this](std::uint32_t a, std::uint32_t b) { return points_[a] < points_[b]; });
                std::rotate(hole.begin(), rightmost, hole.end());
                holes.push_back(std::move(hole));
            }
            std::stable_sort(holes.begin(), holes.end(), [this](const Polygon& a, const Polygon& b) {
                return points_[a[0]] > points_[b[0]];
            });
            for (const Polygon& hole : holes) join(polygon, hole);
            polygons_.push_back(std::move(polygon));
        }
    }

    using Polygon = std::vector<std::uint32_t>;
    const std::vector<Polygon>& polygons() const { return polygons_; }

  private:
    static Polygon numbers(const Loop& loop, std::uint32_t& first) {
        Polygon result(loop.size());
        for (std::uint32_t& number : result) number = first++;
        return result;
    }

    void join(Polygon& polygon, const Polygon& hole) const {
        const Vec2& from = points_[hole[0]];
        std::vector<std::pair<double, std::size_t>> nearest;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2& p = points_[polygon[i]];
            if (p[0] >= from[0]) nearest.emplace_back(std::hypot(p[0] - from[0], p[1] - from[1]), i);
        }
        std::sort(nearest.begin(), nearest.end());
        std::size_t seen = nearest.empty() ? 0 : nearest[0].second;
        for (const auto& [distance, i] : nearest) {
            if (!sees(polygon, i, hole)) continue;
            seen = i;
            break;
        }
        Polygon insertion = hole;
        insertion.push_back(hole[0]);
        insertion.push_back(polygon[seen]);
        polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(seen) + 1, insertion.begin(),
                       insertion.end());
    }

    /// Whether the way from the hole's first corner to the polygon's corner i stays inside and crosses no
    /// edge.
    bool sees(const Polygon& polygon, std::size_t i, const Polygon& hole) const {
        const Vec2& from = points_[hole[0]];
        const Vec2& to = points_[polygon[i]];
        const std::size_t n = polygon.size();
        const Vec2& toward = from == to ? points_[hole[1]] : from;
        if (!faces(points_[polygon[(i + n - 1) % n]], to, points_[polygon[(i + 1) % n]], toward))
            return false;
        if (from == to) return true;
        for (std::size_t k = 0; k < n; ++k) {
            const Vec2& a = points_[polygon[k]];
            const Vec2& b = points_[polygon[(k + 1) % n]];
            if (a == to || b == to) continue;
            const double along_a = cross(from, to, a);
            const double along_b = cross(from, to, b);
            if (((along_a >= 0 && along_b <= 0) || (along_a <= 0 && along_b >= 0)) &&
                cross(a, b, from) * cross(a, b, to) <= 0) {
                return false;
            }
        }
        return true;
    }

    /// Whether the angle of a polygon's corner holds the direction to a point.
    static bool faces(const Vec2& before, const Vec2& corner, const Vec2& after, const Vec2& to) {
        const bool left_of_in = cross(before, corner, to) > 0;
        const bool left_of_out = cross(corner, after, to) > 0;
        return cross(before, corner, after) >= 0 ? left_of_in && left_of_out : left_of_in || left_of_out;
    }

    std::vector<Vec2> points_;
    std::vector<Polygon> polygons_;
};

}  // namespace

double outline_sharp_angle(const Contours& loops, bool smooth) {
    const bool curved = smooth && std::any_of(loops.begin(), loops.end(),
                                              [](const Loop& loop) { return is_curved(loop, kSmoothTurn); });
    return curved ? kSmoothTurn : 0;
}

bool wants_prism(const Contours& loops, bool smooth) {
    if (outline_sharp_angle(loops, smooth) > 0) return true;
    return std::any_of(loops.begin(), loops.end(),
                       [](const Loop& loop) { return loop.size() > kFewEdges && !is_convex(loop); });
}

Primitive prism(const Contours& loops, const PrismSpan& span, double sharp_angle,
                const std::function<std::string()>& next_side) {
    TriangleSurface surface;
    surface.group_names = {"bottom", "top"};
    const auto add = [&surface](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::size_t group) {
        surface.triangles.push_back({a, b, c});
        surface.group.push_back(static_cast<std::uint32_t>(group));
    };
    std::uint32_t count = 0;
    for (const Loop& loop : loops) count += static_cast<std::uint32_t>(loop.size());
    // At an end of scale 0 all points are one.
    const bool has_bottom = span.low_scale > 0;
    const bool has_top = span.high_scale > 0;
    const auto add_level = [&](double z, double scale) {
        if (!(scale > 0)) {
            surface.points.push_back({0, 0, z});
            return;
        }
        for (const Loop& loop : loops) {
            for (const Vec2& p : loop) surface.points.push_back({p[0] * scale, p[1] * scale, z});
        }
    };
    add_level(span.low, span.low_scale);
    const auto above = static_cast<std::uint32_t>(surface.points.size());
    add_level(span.high, span.high_scale);

    std::uint32_t first = 0;
    for (const Loop& loop : loops) {
        const std::vector<std::uint32_t> sides = sides_of(loop, sharp_angle);
        const std::uint32_t side_count = 1 + *std::max_element(sides.begin(), sides.end());
        const bool named = side_count <= kMostNamedSides;
        const std::size_t group = surface.group_names.size();
        for (std::uint32_t k = 0; k < (named ? side_count : 1); ++k)
            surface.group_names.push_back(next_side());
        const auto n = static_cast<std::uint32_t>(loop.size());
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t a = first + i;
            const std::uint32_t b = first + (i + 1) % n;
            const std::size_t side = group + (named ? sides[i] : 0);
            if (has_bottom) add(a, b, has_top ? above + b : above, side);
            if (has_top) add(has_bottom ? a : 0, above + b, above + a, side);
        }
        first += n;
    }

    std::vector<Vec3> flat(count);
    std::size_t next = 0;
    for (const Loop& loop : loops) {
        for (const Vec2& p : loop) flat[next++] = {p[0], p[1], 0};
    }
    std::vector<std::array<std::uint32_t, 3>> caps;
    const Bridges joined(loops);
    for (const auto& polygon : joined.polygons()) triangulate_polygon(flat, polygon, caps);
    for (const auto& [a, b, c] : caps) {
        if (has_bottom) add(a, c, b, 0);
        if (has_top) add(above + a, above + b, above + c, 1);
    }
    return polyhedron(std::move(surface), sharp_angle);
}

}  // namespace mortise::model_reader
