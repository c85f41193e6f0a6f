// Ear clipping in the polygon's mean plane, then flips of diagonals towards the larger smallest angle
// (Lawson 1977).
#include "host/model/outlines/polygon_triangles.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "host/model/affine.hpp"
#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Twice the area by the square of the longest edge: 0 for flat triangles, 0.87 for equal sides.
double shape(const Vec2& a, const Vec2& b, const Vec2& c) {
    const auto square = [](const Vec2& p, const Vec2& q) {
        return (p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]);
    };
    const double longest = std::max({square(a, b), square(b, c), square(c, a)});
    return longest > 0 ? twice_area(a, b, c) / longest : 0;
}

/// Below this a triangle counts as flat.
constexpr double kFlat = 1e-12;

/// The corners in the plane of the polygon's mean normal (Newell), counter-clockwise; empty: no area.
std::vector<Vec2> in_its_plane(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& corners) {
    const Vec3& origin = points[corners[0]];
    Vec3 normal{};
    double extent = 0;
    const std::size_t n = corners.size();
    for (std::size_t i = 0; i < n; ++i) {
        Vec3 p{};
        Vec3 q{};
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = points[corners[i]][k] - origin[k];
            q[k] = points[corners[(i + 1) % n]][k] - origin[k];
            extent = std::max(extent, std::fabs(p[k]));
        }
        const Vec3 area = cross(p, q);
        for (std::size_t k = 0; k < 3; ++k) normal[k] += area[k];
    }
    if (!(length(normal) > kFlat * extent * extent)) return {};
    const Affine frame = frame_along(normal, origin);
    std::vector<Vec2> plane(n);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double along = points[corners[i]][k] - origin[k];
            plane[i][0] += frame[4 * k] * along;
            plane[i][1] += frame[4 * k + 1] * along;
        }
    }
    return plane;
}

/// Local indices of the triangles of a simple polygon.
class EarClipping {
  public:
    explicit EarClipping(const std::vector<Vec2>& plane)
        : plane_(plane), next_(plane.size()), previous_(plane.size()), reflex_(plane.size()) {
        const std::size_t n = plane.size();
        for (std::size_t i = 0; i < n; ++i) {
            next_[i] = static_cast<std::uint32_t>((i + 1) % n);
            previous_[i] = static_cast<std::uint32_t>((i + n - 1) % n);
        }
        for (std::uint32_t i = 0; i < n; ++i) {
            if (turn(i) < kFlat) reflex_list_.push_back(i);
            reflex_[i] = turn(i) < kFlat ? 1 : 0;
        }
    }

    std::vector<Triangle> run() {
        std::vector<Triangle> triangles;
        std::size_t left = plane_.size();
        std::uint32_t at = 0;
        std::size_t tried = 0;
        while (left > 3) {
            // Without an ear in a whole round the polygon crosses or touches itself: cut there regardless.
            const bool forced = tried >= left;
            if (!forced && !is_ear(at)) {
                at = next_[at];
                ++tried;
                continue;
            }
            triangles.push_back({previous_[at], at, next_[at]});
            const std::uint32_t before = previous_[at];
            const std::uint32_t after = next_[at];
            next_[before] = after;
            previous_[after] = before;
            reflex_[at] = 0;
            update(before);
            update(after);
            --left;
            tried = 0;
            at = next_[after];  // not the same corner again: fans make slivers
        }
        triangles.push_back({previous_[at], at, next_[at]});
        return triangles;
    }

  private:
    double turn(std::uint32_t i) const { return shape(plane_[previous_[i]], plane_[i], plane_[next_[i]]); }

    void update(std::uint32_t i) {
        // Clipping can make a reflex corner convex; where the polygon crosses itself also the reverse.
        const char now = turn(i) < kFlat ? 1 : 0;
        if (now != 0 && reflex_[i] == 0) reflex_list_.push_back(i);
        reflex_[i] = now;
    }

    bool is_ear(std::uint32_t i) {
        const Vec2& a = plane_[previous_[i]];
        const Vec2& b = plane_[i];
        const Vec2& c = plane_[next_[i]];
        if (a == b || b == c || c == a) return true;  // a spike, or a corner twice: goes without a trace
        if (reflex_[i] != 0) return false;
        const Vec2 low = {std::min({a[0], b[0], c[0]}), std::min({a[1], b[1], c[1]})};
        const Vec2 high = {std::max({a[0], b[0], c[0]}), std::max({a[1], b[1], c[1]})};
        std::size_t kept = 0;
        bool empty = true;
        for (const std::uint32_t other : reflex_list_) {
            if (reflex_[other] == 0) continue;  // no longer reflex, or clipped
            reflex_list_[kept++] = other;
            if (!empty || other == previous_[i] || other == next_[i]) continue;
            const Vec2& p = plane_[other];
            if (p[0] < low[0] || p[0] > high[0] || p[1] < low[1] || p[1] > high[1]) continue;
            // The other side of a bridge to a hole: is its outline beside the ear, or does it enter it?
            if (p == a || p == b || p == c) {
                const Vec2& left = p == a ? c : p == b ? a : b;
                const Vec2& right = p == a ? b : p == b ? c : a;
                const auto enters = [&](const Vec2& q) {
                    return twice_area(p, right, q) > 0 && twice_area(p, q, left) > 0;
                };
                empty = !enters(plane_[next_[other]]) && !enters(plane_[previous_[other]]);
                continue;
            }
            empty = !(twice_area(a, b, p) >= 0 && twice_area(b, c, p) >= 0 && twice_area(c, a, p) >= 0);
        }
        reflex_list_.resize(kept);
        return empty;
    }

    const std::vector<Vec2>& plane_;
    std::vector<std::uint32_t> next_;
    std::vector<std::uint32_t> previous_;
    std::vector<char> reflex_;
    std::vector<std::uint32_t> reflex_list_;
};

/// Directed sides of triangles and whose they are, ordered by their ends; of equal ones the last triangle's.
class Sides {
  public:
    struct Side {
        std::uint32_t from;
        std::uint32_t to;
        std::uint32_t triangle;
    };

    void collect(const std::vector<Triangle>& triangles, std::size_t points) {
        start_.assign(points + 1, 0);
        for (const Triangle& triangle : triangles) {
            for (const std::uint32_t corner : triangle) ++start_[corner + 1];
        }
        std::partial_sum(start_.begin(), start_.end(), start_.begin());
        sides_.resize(3 * triangles.size());
        end_.assign(start_.begin(), start_.end() - 1);
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = triangles[t][k];
                sides_[end_[from]++] = {from, triangles[t][(k + 1) % 3], t};
            }
        }
        for (std::size_t point = 0; point < points; ++point) {
            const auto first = sides_.begin() + start_[point];
            const auto last = sides_.begin() + end_[point];
            std::sort(first, last, [](const Side& a, const Side& b) {
                return a.to != b.to ? a.to < b.to : a.triangle > b.triangle;
            });
            const auto same = [](const Side& a, const Side& b) { return a.to == b.to; };
            end_[point] = static_cast<std::uint32_t>(std::unique(first, last, same) - sides_.begin());
        }
    }

    /// nullptr if there is none.
    const Side* find(std::uint32_t from, std::uint32_t to) const {
        const Side* last = sides_.data() + end_[from];
        const Side* found = std::lower_bound(sides_.data() + start_[from], last, to,
                                             [](const Side& a, std::uint32_t b) { return a.to < b; });
        return found != last && found->to == to ? found : nullptr;
    }

    template <typename Visit>
    void each(Visit&& visit) const {
        for (std::size_t point = 0; point < end_.size(); ++point) {
            for (std::uint32_t i = start_[point]; i < end_[point]; ++i) visit(sides_[i]);
        }
    }

  private:
    std::vector<Side> sides_;
    std::vector<std::uint32_t> start_;  ///< of each point's sides
    std::vector<std::uint32_t> end_;
};

/// Flips diagonals while that makes the worse of the two triangles better.
void flip_diagonals(const std::vector<Vec2>& plane, std::vector<Triangle>& triangles) {
    constexpr int kMostRounds = 20;
    Sides sides;
    for (int round = 0; round < kMostRounds; ++round) {
        bool any = false;
        sides.collect(triangles, plane.size());
        std::vector<char> changed(triangles.size(), 0);
        sides.each([&](const Sides::Side& side) {
            const std::uint32_t a = side.from;
            const std::uint32_t b = side.to;
            if (a > b) return;
            const Sides::Side* opposite = sides.find(b, a);
            if (opposite == nullptr) return;
            const std::uint32_t first = side.triangle;
            const std::uint32_t second = opposite->triangle;
            if (first == second || changed[first] != 0 || changed[second] != 0) return;
            const auto apex = [](const Triangle& t, std::uint32_t p, std::uint32_t q) {
                for (const std::uint32_t corner : t) {
                    if (corner != p && corner != q) return corner;
                }
                return p;
            };
            const std::uint32_t c = apex(triangles[first], a, b);
            const std::uint32_t d = apex(triangles[second], a, b);
            if (sides.find(c, d) != nullptr || sides.find(d, c) != nullptr) return;
            const auto worse = [&](const Triangle& s, const Triangle& t) {
                return std::min(shape(plane[s[0]], plane[s[1]], plane[s[2]]),
                                shape(plane[t[0]], plane[t[1]], plane[t[2]]));
            };
            const Triangle left = {a, d, c};
            const Triangle right = {d, b, c};
            if (worse(left, right) <= worse(triangles[first], triangles[second]) + 1e-9) return;
            triangles[first] = left;
            triangles[second] = right;
            changed[first] = changed[second] = 1;
            any = true;
        });
        if (!any) return;
    }
}

}  // namespace

void triangulate_polygon(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& corners,
                         std::vector<Triangle>& triangles) {
    if (corners.size() < 3) return;
    // Ear clipping takes quadratic time. A fan's triangles overlap with both orientations where it leaves the
    // polygon; its winding numbers are the polygon's all the same.
    constexpr std::size_t kMostClipped = 20000;
    if (corners.size() > kMostClipped) {
        for (std::size_t i = 2; i < corners.size(); ++i) {
            triangles.push_back({corners[0], corners[i - 1], corners[i]});
        }
        return;
    }
    if (corners.size() == 3) {
        triangles.push_back({corners[0], corners[1], corners[2]});
        return;
    }
    const std::vector<Vec2> plane = in_its_plane(points, corners);
    if (plane.empty()) return;
    std::vector<Triangle> local;
    if (corners.size() == 4) {
        // The better diagonal; at a reflex corner the other one has a triangle of negative area.
        const auto worse = [&](std::size_t apex) {
            const auto at = [&](std::size_t k) { return plane[(apex + k) % 4]; };
            return std::min(shape(at(0), at(1), at(2)), shape(at(0), at(2), at(3)));
        };
        const std::uint32_t apex = worse(1) > worse(0) ? 1 : 0;
        local = {{apex, apex + 1, apex + 2}, {apex, apex + 2, (apex + 3) % 4}};
    } else {
        local = EarClipping(plane).run();
        flip_diagonals(plane, local);
    }
    for (const Triangle& t : local) triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
}

}  // namespace mortise::model_reader
