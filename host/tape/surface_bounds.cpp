#include "host/tape/surface_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace mortise::tape {
Box3 half_bounds(const Surface& s, bool negated) {
    Box3 box = kEverything;
    if (s.kind == kSurfacePlane) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (std::fabs(s.map[j]) != 1) continue;  // unit normal along an axis
            const double at = -s.map[3] / s.map[j];
            ((s.map[j] > 0) != negated ? box.max : box.min)[j] = at;
        }
        return box;
    }
    if (negated || (s.kind != kSurfaceQuadric && s.kind != kSurfaceTorus)) return box;
    glm::dmat3 map;
    glm::dvec3 offset;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) map[j][i] = s.map[4 * i + j];
        offset[i] = s.map[4 * i + 3];
    }
    const glm::dmat3 inverse = glm::inverse(map);
    const glm::dvec3 centre = -(inverse * offset);
    for (int j = 0; j < 3; ++j) {
        const double a = inverse[0][j];
        const double b = inverse[1][j];
        const double c = inverse[2][j];
        double extent = kUnbounded;
        if (s.kind == kSurfaceTorus) {
            extent = s.form[0] * std::hypot(a, b) + std::sqrt(-s.form[3]) * std::sqrt(a * a + b * b + c * c);
        } else if (s.form[2] == 1) {
            extent = std::sqrt(a * a + b * b + c * c);
        } else if (s.form[2] == 0 && std::fabs(c) <= 1e-12 * std::hypot(a, b)) {
            extent = std::hypot(a, b);
        }
        box.min[static_cast<std::size_t>(j)] = centre[j] - extent;
        box.max[static_cast<std::size_t>(j)] = centre[j] + extent;
    }
    return box;
}

double reach(const Surface& s) {
    if (s.kind == kSurfacePlane) return std::fabs(s.map[3]);
    double result = 0;
    for (int i = 0; i < 3; ++i) {
        const double row = std::sqrt(s.map[4 * i] * s.map[4 * i] + s.map[4 * i + 1] * s.map[4 * i + 1] +
                                     s.map[4 * i + 2] * s.map[4 * i + 2]);
        const double extent = s.kind == kSurfaceTorus     ? s.form[0] + std::sqrt(-s.form[3])
                              : s.kind == kSurfaceRounded ? s.form[3]
                                                          : 1;
        if (row > 0) result = std::max(result, (std::fabs(s.map[4 * i + 3]) + extent) / row);
    }
    return result;
}

Box3 map_box(const Box3& box, const Affine& map) {
    Box3 result;
    for (std::size_t i = 0; i < 3; ++i) {
        double low = map[4 * i + 3];
        double high = low;
        for (std::size_t j = 0; j < 3; ++j) {
            const double factor = map[4 * i + j];
            if (factor == 0) continue;  // keeps 0 · ∞ out
            low += std::min(factor * box.min[j], factor * box.max[j]);
            high += std::max(factor * box.min[j], factor * box.max[j]);
        }
        result.min[i] = low;
        result.max[i] = high;
    }
    return result;
}

void shrink(Box3& box, const Box3& by) {
    for (std::size_t j = 0; j < 3; ++j) {
        box.min[j] = std::max(box.min[j], by.min[j]);
        box.max[j] = std::min(box.max[j], by.max[j]);
    }
}

void grow(Box3& box, const Box3& by) {
    for (std::size_t j = 0; j < 3; ++j) {
        box.min[j] = std::min(box.min[j], by.min[j]);
        box.max[j] = std::max(box.max[j], by.max[j]);
    }
}

}  // namespace mortise::tape
