// Repair of triangle surfaces: see surface_repair.hpp.
#include "host/model/triangles/surface_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <utility>

#include "host/common/message_text.hpp"
#include "host/model/affine.hpp"

namespace mortise::model_reader {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr std::uint32_t kNone = 0xffffffffU;

std::uint64_t hash_of(const Vec3& point) {
    std::uint64_t hash = 0;
    for (const double coordinate : point) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &coordinate, sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15U;
        hash ^= hash >> 32;
    }
    return hash;
}

void replace_points(TriangleSurface& surface, const std::vector<std::uint32_t>& instead) {
    for (Triangle& triangle : surface.triangles) {
        for (std::uint32_t& corner : triangle) corner = instead[corner];
    }
}

/// Points with the same coordinates become the first of them (open addressing, linear probing).
void join_equal_points(TriangleSurface& surface) {
    std::size_t slots = 16;
    while (slots < 2 * surface.points.size()) slots *= 2;
    std::vector<std::uint32_t> table(slots, kNone);
    std::vector<std::uint32_t> instead(surface.points.size());
    for (std::uint32_t i = 0; i < surface.points.size(); ++i) {
        Vec3& point = surface.points[i];
        for (double& coordinate : point) coordinate += 0.0;  // -0 becomes 0
        std::size_t slot = hash_of(point) & (slots - 1);
        while (table[slot] != kNone && surface.points[table[slot]] != point) slot = (slot + 1) & (slots - 1);
        if (table[slot] == kNone) table[slot] = i;
        instead[i] = table[slot];
    }
    replace_points(surface, instead);
}

void drop_unused_points(TriangleSurface& surface) {
    std::vector<std::uint32_t> instead(surface.points.size(), kNone);
    std::vector<Vec3> points;
    for (Triangle& triangle : surface.triangles) {
        for (std::uint32_t& corner : triangle) {
            if (instead[corner] == kNone) {
                instead[corner] = static_cast<std::uint32_t>(points.size());
                points.push_back(surface.points[corner]);
            }
            corner = instead[corner];
        }
    }
    surface.points = std::move(points);
}

double diagonal_of(const std::vector<Vec3>& points) {
    Vec3 low = points[0];
    Vec3 high = points[0];
    for (const Vec3& point : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], point[k]);
            high[k] = std::max(high[k], point[k]);
        }
    }
    return length({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
}

/// Points closer than the tolerance become one: a sweep along a direction in which no model is flat. Only
/// points that `may_join` marks, if it is given. Returns how many were replaced.
std::size_t join_close_points(TriangleSurface& surface, double tolerance,
                              const std::vector<char>* may_join = nullptr) {
    constexpr Vec3 kDirection = {0.5381, 0.6197, 0.5712};
    struct Place {
        double along;
        std::uint32_t point;
    };
    std::vector<Place> order;
    for (std::uint32_t i = 0; i < surface.points.size(); ++i) {
        if (may_join == nullptr || (*may_join)[i] != 0)
            order.push_back({dot(surface.points[i], kDirection), i});
    }
    const std::size_t n = order.size();
    std::sort(order.begin(), order.end(), [](const Place& a, const Place& b) {
        return a.along != b.along ? a.along < b.along : a.point < b.point;
    });
    std::vector<std::uint32_t> instead(surface.points.size());
    std::iota(instead.begin(), instead.end(), 0U);
    std::size_t joined = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t first = order[i].point;
        if (instead[first] != first) continue;
        for (std::size_t j = i + 1; j < n && order[j].along - order[i].along <= 1.01 * tolerance; ++j) {
            const std::uint32_t other = order[j].point;
            const Vec3& p = surface.points[first];
            const Vec3& q = surface.points[other];
            if (length({q[0] - p[0], q[1] - p[1], q[2] - p[2]}) > tolerance) continue;
            if (instead[other] != other) continue;
            instead[other] = first;
            ++joined;
        }
    }
    if (joined > 0) replace_points(surface, instead);
    return joined;
}

/// Drops triangles with two equal corners, and those without area if `flat` is set.
std::size_t drop_flat_triangles(TriangleSurface& surface, bool flat) {
    constexpr double kFlat = 1e-12;
    std::size_t kept = 0;
    for (const Triangle& t : surface.triangles) {
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        if (flat) {
            const Vec3& a = surface.points[t[0]];
            const Vec3& b = surface.points[t[1]];
            const Vec3& c = surface.points[t[2]];
            const Vec3 u = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
            const Vec3 v = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
            const double longest = std::max({dot(u, u), dot(v, v), 0.0});
            if (!(length(cross(u, v)) > kFlat * longest)) continue;
        }
        surface.triangles[kept++] = t;
    }
    const std::size_t dropped = surface.triangles.size() - kept;
    surface.triangles.resize(kept);
    return dropped;
}

/// One side of a triangle.
struct Side {
    std::uint64_t edge;      ///< lower point in the upper half
    std::uint32_t triangle;  ///< whose side it is
    bool forward;            ///< from the lower to the higher point
};

/// Ordered by edge, then by triangle: a bucket for each lower point, each of which is short.
std::vector<Side> sides_of(const TriangleSurface& surface) {
    std::vector<std::uint32_t> end(surface.points.size() + 1, 0);
    const auto each_side = [&](auto&& visit) {
        for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = surface.triangles[t][k];
                const std::uint32_t to = surface.triangles[t][(k + 1) % 3];
                visit(t, std::min(from, to), std::max(from, to), from < to);
            }
        }
    };
    each_side([&](std::uint32_t, std::uint32_t low, std::uint32_t, bool) { ++end[low + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    std::vector<Side> sides(3 * surface.triangles.size());
    // Filling moves each bucket's start to its end.
    each_side([&](std::uint32_t t, std::uint32_t low, std::uint32_t high, bool forward) {
        sides[end[low]++] = {std::uint64_t{low} << 32 | high, t, forward};
    });
    std::size_t first = 0;
    for (std::size_t point = 0; point < surface.points.size(); ++point) {
        std::sort(sides.begin() + static_cast<std::ptrdiff_t>(first),
                  sides.begin() + static_cast<std::ptrdiff_t>(end[point]), [](const Side& a, const Side& b) {
                      return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
                  });
        first = end[point];
    }
    return sides;
}

/// Counts open and crowded edges; returns the pairs of triangles that share an edge with no third one.
std::vector<std::array<Side, 2>> pair_sides(const TriangleSurface& surface, SurfaceFindings& findings) {
    const std::vector<Side> sides = sides_of(surface);
    std::vector<std::array<Side, 2>> pairs;
    pairs.reserve(sides.size() / 2);
    for (std::size_t first = 0; first < sides.size();) {
        std::size_t last = first + 1;
        while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
        if (last - first == 1) ++findings.open_edges;
        if (last - first == 2) pairs.push_back({sides[first], sides[first + 1]});
        if (last - first > 2) ++findings.crowded_edges;
        first = last;
    }
    return pairs;
}

/// Drops triangles of the same three points in the same order of turning, but for the first.
std::size_t drop_repeated_triangles(TriangleSurface& surface) {
    const auto turned_to_lowest = [](Triangle t) {
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        return t;
    };
    std::vector<std::pair<Triangle, std::size_t>> order;
    for (std::size_t i = 0; i < surface.triangles.size(); ++i)
        order.push_back({turned_to_lowest(surface.triangles[i]), i});
    std::sort(order.begin(), order.end());
    std::vector<char> repeats(order.size(), 0);
    for (std::size_t i = 1; i < order.size(); ++i)
        repeats[order[i].second] = order[i].first == order[i - 1].first ? 1 : 0;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (repeats[i] == 0) surface.triangles[kept++] = surface.triangles[i];
    }
    surface.triangles.resize(kept);
    return order.size() - kept;
}

/// Per point: whether it is an end of an edge with one triangle.
std::vector<char> open_points(const TriangleSurface& surface) {
    std::vector<char> open(surface.points.size(), 0);
    const std::vector<Side> sides = sides_of(surface);
    for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
        while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
        if (last - first != 1) continue;
        open[sides[first].edge >> 32] = 1;
        open[sides[first].edge & 0xffffffffU] = 1;
    }
    return open;
}

/// Coordinates that differ by no more than the noise become one: faces along the axes are plane again.
void align_coordinates(TriangleSurface& surface, double noise) {
    constexpr double kWidest = 4;  // times the noise: no chain of close points becomes a plane
    std::vector<std::uint32_t> order(surface.points.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = [&](std::size_t i) -> double& { return surface.points[order[i]][axis]; };
        std::iota(order.begin(), order.end(), 0U);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return surface.points[a][axis] < surface.points[b][axis];
        });
        for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
            last = first + 1;
            while (last < order.size() && at(last) - at(last - 1) <= noise) ++last;
            if (at(last - 1) - at(first) > kWidest * noise) continue;
            double sum = 0;
            for (std::size_t i = first; i < last; ++i) sum += at(i) - at(first);
            const double mean = at(first) + sum / static_cast<double>(last - first);
            for (std::size_t i = first; i < last; ++i) at(i) = mean;
        }
    }
}

/// Joins points at open edges, the closest first, as long as that closes edges.
void close_cracks(TriangleSurface& surface, SurfaceFindings& findings) {
    const double diagonal = diagonal_of(surface.points);
    for (const double tolerance : {1e-7, 1e-6, 1e-5, 1e-4}) {
        const std::vector<char> open = open_points(surface);
        TriangleSurface closed = surface;
        const std::size_t joined = join_close_points(closed, tolerance * diagonal, &open);
        if (joined == 0) continue;
        drop_flat_triangles(closed, false);
        SurfaceFindings now;
        pair_sides(closed, now);
        if (now.open_edges >= findings.open_edges) continue;
        surface = std::move(closed);
        findings.joined += joined;
        findings.crack = tolerance * diagonal;
        findings.open_edges = now.open_edges;
        findings.crowded_edges = now.crowded_edges;
        if (findings.open_edges == 0) return;
    }
}

/// Turns triangles over until neighbours agree; in each connected piece the fewer ones.
std::size_t agree(TriangleSurface& surface, const std::vector<std::array<Side, 2>>& pairs) {
    const auto disagrees = [](const std::array<Side, 2>& pair) { return pair[0].forward == pair[1].forward; };
    if (std::none_of(pairs.begin(), pairs.end(), disagrees)) return 0;
    const std::size_t n = surface.triangles.size();
    // Neighbours of each triangle: at most three, the lowest bit tells that they disagree.
    std::vector<std::array<std::uint64_t, 3>> neighbours(n);
    std::vector<std::uint8_t> count(n, 0);
    for (const auto& pair : pairs) {
        const std::uint64_t flag = disagrees(pair) ? 1 : 0;
        const std::uint32_t a = pair[0].triangle;
        const std::uint32_t b = pair[1].triangle;
        neighbours[a][count[a]++] = std::uint64_t{b} << 1 | flag;
        neighbours[b][count[b]++] = std::uint64_t{a} << 1 | flag;
    }
    std::size_t turned = 0;
    std::vector<char> seen(n, 0);
    std::vector<char> turn(n, 0);
    std::vector<std::uint32_t> piece;
    for (std::uint32_t seed = 0; seed < n; ++seed) {
        if (seen[seed] != 0) continue;
        piece.assign(1, seed);
        seen[seed] = 1;
        std::size_t turns = 0;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            const std::uint32_t t = piece[i];
            turns += turn[t] != 0 ? 1 : 0;
            for (std::size_t k = 0; k < count[t]; ++k) {
                const auto other = static_cast<std::uint32_t>(neighbours[t][k] >> 1);
                if (seen[other] != 0) continue;
                seen[other] = 1;
                turn[other] = static_cast<char>((turn[t] != 0) != ((neighbours[t][k] & 1U) != 0));
                piece.push_back(other);
            }
        }
        const bool majority = 2 * turns > piece.size();
        for (const std::uint32_t t : piece) {
            if ((turn[t] != 0) == majority) continue;
            std::swap(surface.triangles[t][1], surface.triangles[t][2]);
            ++turned;
        }
    }
    return turned;
}

}  // namespace

double six_volumes(const TriangleSurface& surface) {
    if (surface.points.empty()) return 0;
    const Vec3& origin = surface.points[0];
    double sum = 0;
    for (const Triangle& triangle : surface.triangles) {
        std::array<Vec3, 3> corner{};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) corner[i][k] = surface.points[triangle[i]][k] - origin[k];
        }
        sum += dot(corner[0], cross(corner[1], corner[2]));
    }
    return sum;
}

SurfaceFindings repair_surface(TriangleSurface& surface) {
    SurfaceFindings findings;
    if (surface.triangles.empty()) return findings;
    join_equal_points(surface);
    drop_unused_points(surface);
    constexpr double kTolerance = 1e-9;
    join_close_points(surface, kTolerance * diagonal_of(surface.points));
    findings.flat_triangles = drop_flat_triangles(surface, false);
    // Flat triangles fill cracks between edges divided differently: they count for the edges, then they go.
    auto pairs = pair_sides(surface, findings);
    if (findings.crowded_edges > 0) findings.repeated = drop_repeated_triangles(surface);
    if (findings.open_edges > 0) close_cracks(surface, findings);
    if (findings.repeated + findings.joined > 0) {
        findings.open_edges = 0;
        findings.crowded_edges = 0;
        pairs = pair_sides(surface, findings);
    }
    findings.turned = agree(surface, pairs);
    if (findings.joined > 0) align_coordinates(surface, findings.crack);
    findings.flat_triangles += drop_flat_triangles(surface, true);
    drop_unused_points(surface);
    if (six_volumes(surface) < 0) {
        findings.inverted = true;
        for (Triangle& triangle : surface.triangles) std::swap(triangle[1], triangle[2]);
    }
    return findings;
}

std::vector<std::string> surface_warnings(const SurfaceFindings& findings, const std::string& source) {
    std::vector<std::string> warnings;
    if (findings.open_edges != 0) {
        warnings.push_back(
            source + ": " + counted(findings.open_edges, "edge has", "edges have") +
            " only one triangle: the surface is not closed there; what is inside is decided by "
            "the winding number");
    }
    if (findings.joined != 0) {
        const std::string crack = rounded_text(findings.crack, 3);
        warnings.push_back(source + ": " + counted(findings.joined, "point was", "points were") +
                           " joined with others up to " + crack + " away, which closes edges between them");
    }
    if (findings.repeated != 0) {
        warnings.push_back(source + ": " + counted(findings.repeated, "triangle was", "triangles were") +
                           " given more than once");
    }
    if (findings.turned != 0) {
        warnings.push_back(source + ": " + counted(findings.turned, "triangle was", "triangles were") +
                           " turned over to agree with the triangles around");
    }
    return warnings;
}

}  // namespace mortise::model_reader
