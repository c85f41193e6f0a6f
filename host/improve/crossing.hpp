// When two facets cross.
#pragma once

#include <algorithm>
#include <array>

#include "host/improve/facet_grid.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Facets that touch do not cross: edges of the finest leaves.
inline constexpr double kCrossingDepth = 1e-5;

using Triangle = std::array<Point, 3>;

inline bool is_outer(FaceTag tag) { return tag != 0 && (tag & kTagInterface) == 0; }

/// Whether an edge of `a` passes through the inside of `b`, from one side of it to the other, by more than
/// `depth` on both.
inline bool stabs(const Triangle& a, const Triangle& b, double depth) {
    const auto volume = [](const Point& p, const Point& q, const Point& r, const Point& s) {
        return dot(cross(q - p, r - p), s - p);
    };
    const Point normal = cross(b[1] - b[0], b[2] - b[0]);
    const double least = depth * length(normal);
    double side[3];
    for (std::size_t k = 0; k < 3; ++k) side[k] = dot(normal, a[k] - b[0]);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        if (!(std::min(side[k], side[next]) < -least && std::max(side[k], side[next]) > least)) continue;
        const double u = volume(a[k], a[next], b[0], b[1]);
        const double v = volume(a[k], a[next], b[1], b[2]);
        const double w = volume(a[k], a[next], b[2], b[0]);
        if ((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)) return true;
    }
    return false;
}

inline int common_nodes(const std::array<std::uint32_t, 3>& a, const std::array<std::uint32_t, 3>& b) {
    int count = 0;
    for (const std::uint32_t n : a) count += n == b[0] || n == b[1] || n == b[2] ? 1 : 0;
    return count;
}

inline Bounds bounds(const Triangle& t) {
    Bounds result{};
    for (std::size_t j = 0; j < 3; ++j) {
        result.low[j] = std::min({t[0][j], t[1][j], t[2][j]});
        result.high[j] = std::max({t[0][j], t[1][j], t[2][j]});
    }
    return result;
}

inline std::array<std::uint32_t, 3> face_nodes(const Tetrahedron& t, std::size_t face) {
    return {t.node[kOpposite[face][0]], t.node[kOpposite[face][1]], t.node[kOpposite[face][2]]};
}

}  // namespace mortise::improve
