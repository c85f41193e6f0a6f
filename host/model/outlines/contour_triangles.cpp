#include "host/model/outlines/contour_triangles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/outlines/polygon_triangles.hpp"
#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

/// Twice the area of o, a, b: positive if they turn left.
double twice_area_of(const Vec2& o, const Vec2& a, const Vec2& b) {
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

/// The outline as polygons of point numbers. Their holes are joined to the outer loop by bridges, from the
/// hole's rightmost corner: it sees the outer loop or a hole that is joined already (Eberly, Triangulation by
/// ear clipping).
class Bridges {
  public:
    explicit Bridges(const Contours& loops) {
        for (const std::vector<Vec2>& loop : loops) points_.insert(points_.end(), loop.begin(), loop.end());
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
    static Polygon numbers(const std::vector<Vec2>& loop, std::uint32_t& first) {
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
            const double along_a = twice_area_of(from, to, a);
            const double along_b = twice_area_of(from, to, b);
            if (((along_a >= 0 && along_b <= 0) || (along_a <= 0 && along_b >= 0)) &&
                twice_area_of(a, b, from) * twice_area_of(a, b, to) <= 0) {
                return false;
            }
        }
        return true;
    }

    /// Whether the angle of a polygon's corner holds the direction to a point.
    static bool faces(const Vec2& before, const Vec2& corner, const Vec2& after, const Vec2& to) {
        const bool left_of_in = twice_area_of(before, corner, to) > 0;
        const bool left_of_out = twice_area_of(corner, after, to) > 0;
        return twice_area_of(before, corner, after) >= 0 ? left_of_in && left_of_out
                                                         : left_of_in || left_of_out;
    }

    std::vector<Vec2> points_;
    std::vector<Polygon> polygons_;
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate(const Contours& loops) {
    std::vector<Vec3> points;
    for (const auto& loop : loops) {
        for (const Vec2& p : loop) points.push_back({p[0], p[1], 0});
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const Bridges joined(loops);
    for (const auto& polygon : joined.polygons()) triangulate_polygon(points, polygon, triangles);
    return triangles;
}

}  // namespace mortise::model_reader
