#include "host/sizing/hints.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/tape/projection.hpp"

namespace mortise::sizing {
namespace {

constexpr double kNearCentre = 1.25;  ///< half edges: a meeting point so far from the centre counts
constexpr double kTangent = 0.02;     ///< sine: flatter surfaces do not meet in a line that could be followed
constexpr double kSettled = 1e-9;     ///< edges
constexpr double kDiagonal = 1.7321;
constexpr double kParallel = 1e-9;
/// Combinations of surfaces that are tried in a cell, at most: edges of solids with many surfaces.
constexpr int kMostCombinations = 64;

double distance(const Vec3& p, const Vec3& q) {
    const double d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/// The point of a surface close to x; false if none is found within reach.
bool foot(const tape::BoundModel& model, std::uint32_t surface, double reach, double edge, Vec3& x) {
    return tape::project(model, &surface, 1, {reach, kTangent, kSettled * edge}, x.data());
}

}  // namespace

bool holds_one(const std::vector<std::uint32_t>& list, const std::vector<std::uint32_t>& some) {
    return std::any_of(some.begin(), some.end(),
                       [&](std::uint32_t s) { return std::binary_search(list.begin(), list.end(), s); });
}

bool meet_in(const tape::BoundModel& model, const SizeField::Meeting& meeting,
             const std::vector<std::uint32_t>& here, const tape::Cell& cell) {
    const std::size_t count = meeting.groups.size();
    if (count < 2 || count > 3) return false;
    std::array<std::vector<std::uint32_t>, 3> found;
    for (std::size_t g = 0; g < count; ++g) {
        for (const std::uint32_t s : meeting.groups[g]) {
            if (std::binary_search(here.begin(), here.end(), s)) found[g].push_back(s);
        }
        if (found[g].empty()) return false;
    }
    std::array<std::size_t, 3> at{};
    for (int tries = 0; tries < kMostCombinations; ++tries) {
        std::array<std::uint32_t, 3> surfaces{};
        bool distinct = true;
        for (std::size_t g = 0; g < count; ++g) {
            surfaces[g] = found[g][at[g]];
            for (std::size_t k = 0; k < g; ++k) distinct = distinct && surfaces[k] != surfaces[g];
        }
        Vec3 x = {cell.centre[0], cell.centre[1], cell.centre[2]};
        const tape::ProjectionLimits limits = {2 * kDiagonal * cell.half, kTangent, kSettled * cell.half};
        if (distinct && tape::project(model, surfaces.data(), count, limits, x.data())) {
            bool inside = true;
            for (std::size_t j = 0; j < 3; ++j)
                inside = inside && std::fabs(x[j] - cell.centre[j]) <= kNearCentre * cell.half;
            if (inside) return true;
        }
        std::size_t g = 0;
        while (g < count && ++at[g] == found[g].size()) at[g++] = 0;
        if (g == count) break;
    }
    return false;
}

double gap_size(const tape::BoundModel& model, const SizeField::Gap& gap, const tape::Cell& cell) {
    const double edge = 2 * cell.half;
    // Wider gaps ask for nothing that this cell does not give.
    const double widest = 2 * edge;
    const double reach = widest + kDiagonal * cell.half;
    const Vec3 centre = {cell.centre[0], cell.centre[1], cell.centre[2]};
    double size = kInfinity;
    for (const std::uint32_t a : gap.a) {
        Vec3 p = centre;
        if (!foot(model, a, reach, edge, p)) continue;
        for (const std::uint32_t b : gap.b) {
            Vec3 q = p;
            if (a == b || !foot(model, b, widest, edge, q)) continue;
            const double wide = distance(p, q);
            const double near = wide + kDiagonal * cell.half;
            if (wide < gap.least || distance(centre, p) > near || distance(centre, q) > near) continue;
            size = std::min(size, std::max(gap.least, 0.5 * wide));
        }
    }
    return size;
}

double distance_of_planes(const tape::BoundModel& model, std::uint32_t a, std::uint32_t b) {
    const Surface& p = model.surfaces[a];
    const Surface& q = model.surfaces[b];
    if (p.kind != kSurfacePlane || q.kind != kSurfacePlane) return 0;
    const double cosine = p.map[0] * q.map[0] + p.map[1] * q.map[1] + p.map[2] * q.map[2];
    if (std::fabs(cosine) < 1 - kParallel) return 0;
    return std::fabs(p.map[3] - (cosine > 0 ? 1 : -1) * q.map[3]);
}

}  // namespace mortise::sizing
