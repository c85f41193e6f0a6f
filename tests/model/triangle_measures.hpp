// Measures of surfaces of triangles, by their points alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "mortise/model.hpp"

namespace mortise::test {

/// By the divergence theorem.
inline double volume(const TriangleSurface& surface) {
    double six = 0;
    for (const auto& triangle : surface.triangles) {
        const Vec3& a = surface.points[triangle[0]];
        const Vec3& b = surface.points[triangle[1]];
        const Vec3& c = surface.points[triangle[2]];
        six += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return six / 6;
}

/// Each directed edge as often as its reverse.
inline bool is_closed(const TriangleSurface& surface) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& triangle : surface.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = triangle[k];
            const std::uint32_t b = triangle[(k + 1) % 3];
            sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

}  // namespace mortise::test
