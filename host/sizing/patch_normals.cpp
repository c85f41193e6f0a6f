#include "host/sizing/patch_normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace mortise::sizing {
namespace {

using Numbers = const patch_number*;

struct Cube {
    std::array<double, 3> centre;
    std::array<double, 3> half;
};

/// Whether the triangle's projection onto an axis through the cube's centre misses the cube's.
bool separates(const Cube& cube, Numbers triangle, const std::array<double, 3>& axis) {
    double low = kMortiseInfinity;
    double high = -kMortiseInfinity;
    double reach = 0;
    for (std::size_t j = 0; j < 3; ++j) reach += std::fabs(axis[j]) * cube.half[j];
    for (std::size_t corner = 0; corner < 3; ++corner) {
        double at = 0;
        for (std::size_t j = 0; j < 3; ++j) at += axis[j] * (triangle[3 * corner + j] - cube.centre[j]);
        low = std::min(low, at);
        high = std::max(high, at);
    }
    return low > reach || high < -reach;
}

/// Separating axes: the cube's, the triangle's normal, and their edges' products.
bool overlaps(const Cube& cube, Numbers triangle) {
    for (std::size_t j = 0; j < 3; ++j) {
        std::array<double, 3> axis{};
        axis[j] = 1;
        if (separates(cube, triangle, axis)) return false;
    }
    if (separates(cube, triangle, {triangle[10], triangle[11], triangle[12]})) return false;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        std::array<double, 3> edge{};
        for (std::size_t j = 0; j < 3; ++j)
            edge[j] = triangle[3 * ((corner + 1) % 3) + j] - triangle[3 * corner + j];
        if (separates(cube, triangle, {0, edge[2], -edge[1]}) ||
            separates(cube, triangle, {-edge[2], 0, edge[0]}) ||
            separates(cube, triangle, {edge[1], -edge[0], 0}))
            return false;
    }
    return true;
}

}  // namespace

PatchState patch_in(const tape::BoundModel& model, std::uint32_t surface, const tape::Cell& cell) {
    constexpr double kCone = 0.7;  // cosine
    const Surface& s = model.surfaces[surface];
    const auto nodes = reinterpret_cast<Numbers>(model.expression_ops.data() + s.first_op);
    const Numbers triangles = nodes + static_cast<std::uint32_t>(s.form[0]);
    Cube cube{};
    surface_frame(&s, cell.centre[0], cell.centre[1], cell.centre[2], cube.centre.data());
    for (std::size_t i = 0; i < 3; ++i) {
        cube.half[i] =
            cell.half * (std::fabs(s.map[4 * i]) + std::fabs(s.map[4 * i + 1]) + std::fabs(s.map[4 * i + 2]));
    }
    std::vector<std::array<double, 3>> normals;
    std::array<double, 3> low = {1, 1, 1};
    std::array<double, 3> high = {-1, -1, -1};
    std::uint32_t open[kPatchStack];
    int top = 0;
    open[0] = 0;
    while (top >= 0) {
        const std::uint32_t index = open[top--];
        const Numbers node = nodes + kPatchNode * index;
        bool apart = false;
        for (std::size_t j = 0; j < 3; ++j) {
            apart = apart || node[j] > cube.centre[j] + cube.half[j] ||
                    node[3 + j] < cube.centre[j] - cube.half[j];
        }
        if (apart) continue;
        if (node[7] < 0) {
            open[++top] = static_cast<std::uint32_t>(node[6]);
            open[++top] = index + 1;
            continue;
        }
        const auto first = static_cast<std::uint32_t>(node[6]);
        for (std::uint32_t t = first; t < first + static_cast<std::uint32_t>(node[7]); ++t) {
            const Numbers triangle = triangles + kPatchTriangle * t;
            if (!overlaps(cube, triangle)) continue;
            normals.push_back({triangle[10], triangle[11], triangle[12]});
            for (std::size_t j = 0; j < 3; ++j) {
                low[j] = std::min(low[j], triangle[10 + j]);
                high[j] = std::max(high[j], triangle[10 + j]);
            }
        }
    }
    if (normals.empty()) return PatchState::kAbsent;
    std::array<double, 3> middle{};
    for (std::size_t j = 0; j < 3; ++j) middle[j] = 0.5 * (low[j] + high[j]);
    const double length = std::hypot(middle[0], middle[1], middle[2]);
    const bool steady = std::all_of(normals.begin(), normals.end(), [&](const std::array<double, 3>& n) {
        return n[0] * middle[0] + n[1] * middle[1] + n[2] * middle[2] > kCone * length;
    });
    return steady ? PatchState::kSteady : PatchState::kTurning;
}

}  // namespace mortise::sizing
