#include "host/tape/patch_bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/common/vec3.hpp"
#include "kernels/shared/surface.h"

namespace mortise::tape {
namespace {

/// A cell in a patch's frame, whose map turns nothing.
struct PatchBox {
    Vec3 centre{};
    Vec3 half{};

    PatchBox(const Surface& s, const Cell& cell) {
        surface_frame(&s, cell.centre[0], cell.centre[1], cell.centre[2], centre.data());
        for (std::size_t i = 0; i < 3; ++i) {
            half[i] = cell.half *
                      (std::fabs(s.map[4 * i]) + std::fabs(s.map[4 * i + 1]) + std::fabs(s.map[4 * i + 2]));
        }
    }

    bool meets_node(const patch_number* node) const {
        for (std::size_t j = 0; j < 3; ++j) {
            if (node[j] > centre[j] + half[j] || node[3 + j] < centre[j] - half[j]) return false;
        }
        return true;
    }

    /// By separating axes (Akenine-Möller 2001).
    bool meets_triangle(const patch_number* t) const {
        std::array<Vec3, 3> corner{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t j = 0; j < 3; ++j) corner[k][j] = t[3 * k + j] - centre[j];
        }
        const auto separates = [&](const Vec3& axis) {
            const double reach =
                half[0] * std::fabs(axis[0]) + half[1] * std::fabs(axis[1]) + half[2] * std::fabs(axis[2]);
            const double a = dot(axis, corner[0]), b = dot(axis, corner[1]), c = dot(axis, corner[2]);
            return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
        };
        if (separates({t[10], t[11], t[12]})) return false;
        for (std::size_t j = 0; j < 3; ++j) {
            Vec3 axis{};
            axis[j] = 1;
            if (separates(axis)) return false;
            for (std::size_t k = 0; k < 3; ++k) {
                if (separates(cross(axis, difference(corner[(k + 1) % 3], corner[k])))) return false;
            }
        }
        return true;
    }
};

}  // namespace

int classify_patch(const BoundModel& model, std::uint32_t surface, const Cell& cell) {
    const Surface& s = model.surfaces[surface];
    const PatchBox box(s, cell);
    double gradient[3];
    const double value = surface_patch(&s, model.expression_ops.data(), box.centre.data(), gradient);
    if (std::fabs(value) <= length(box.half)) return 0;
    return value < 0 ? -1 : 1;
}

PatchState patch_in(const BoundModel& model, std::uint32_t surface, const Cell& cell) {
    constexpr double kCone = 0.7;  // cosine
    const Surface& s = model.surfaces[surface];
    const auto* const nodes = reinterpret_cast<const patch_number*>(model.expression_ops.data() + s.first_op);
    const patch_number* const triangles = nodes + static_cast<std::size_t>(s.form[0]);
    const PatchBox place(s, cell);
    std::vector<Vec3> normals;
    Vec3 low = {1, 1, 1}, high = {-1, -1, -1};
    std::size_t open[kPatchStack];
    int top = 0;
    open[0] = 0;
    while (top >= 0) {
        const std::size_t index = open[top--];
        const patch_number* const node = nodes + kPatchNode * index;
        if (!place.meets_node(node)) continue;
        if (node[7] < 0) {
            open[++top] = static_cast<std::size_t>(node[6]);
            open[++top] = index + 1;
            continue;
        }
        const auto begin = static_cast<std::size_t>(node[6]);
        for (std::size_t i = begin; i < begin + static_cast<std::size_t>(node[7]); ++i) {
            const patch_number* const triangle = triangles + kPatchTriangle * i;
            if (!place.meets_triangle(triangle)) continue;
            normals.push_back({triangle[10], triangle[11], triangle[12]});
            for (std::size_t j = 0; j < 3; ++j) {
                low[j] = std::min(low[j], normals.back()[j]);
                high[j] = std::max(high[j], normals.back()[j]);
            }
        }
    }
    if (normals.empty()) return PatchState::kAbsent;
    const Vec3 middle = scaled(sum(low, high), 0.5);
    const double least = kCone * length(middle);
    const bool is_steady = std::all_of(normals.begin(), normals.end(),
                                       [&](const Vec3& normal) { return dot(normal, middle) > least; });
    return is_steady ? PatchState::kSteady : PatchState::kTurning;
}

}  // namespace mortise::tape
