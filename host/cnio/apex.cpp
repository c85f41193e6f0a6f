// Where the apexes of cells and of faces that are fans lie (algorithms.md §2: corner before crease before
// surface before centre).
#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/cnio/cell.hpp"
#include "host/tape/projection.hpp"

namespace mortise::cnio {
namespace {

// Per edge of the cell or patch.
constexpr double kNear = 0.6;       ///< surfaces farther from the middle are not looked at
constexpr double kMargin = 0.35;    ///< the apex may move this far along each axis; with 0.45 slivers stay
constexpr double kReach = 0.7;      ///< in all
constexpr double kTangent = 0.1;    ///< sine between gradients below which surfaces do not cross
constexpr double kSettled = 1e-10;  ///< the last step

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

/// Distance from a surface, to first order, box-local; infinite where the gradient vanishes.
double Cell::distance_to(std::size_t surface, const double* x) const {
    const SurfaceSample s =
        surface_sample(&model_.surfaces[surfaces_[surface]], model_.expression_ops.data(), x[0], x[1], x[2]);
    const double distance = std::fabs(s.value) / std::sqrt(dot(s.gradient, s.gradient));
    return std::isfinite(distance) ? distance : kMortiseInfinity;
}

/// The middle, or the point next to it on up to three surfaces that pass close to it.
LatticePoint Cell::apex_near(const ApexSearch& search) const {
    double start[3];
    position(search.middle, start);
    std::vector<std::pair<double, std::size_t>> near;
    for (const std::size_t s : search.surfaces) {
        const double distance = distance_to(s, start);
        if (distance < kNear * search.scale.size) near.push_back({distance, s});
    }
    std::sort(near.begin(), near.end());
    const tape::ProjectionLimits limits = {kReach * search.scale.size, kTangent, kSettled * search.scale.size,
                                           search.fixed_axis};
    const double unit = size_ / units_ * search.scale.step;
    for (std::size_t count = std::min<std::size_t>(near.size(), 3); count > 0; --count) {
        std::vector<std::uint32_t> on;
        for (std::size_t k = 0; k < count; ++k) on.push_back(surfaces_[near[k].second]);
        double x[3] = {start[0], start[1], start[2]};
        if (!tape::project(model_, on.data(), count, limits, x)) continue;
        const double most = kMargin * search.scale.size;
        const bool is_inside = std::fabs(x[0] - start[0]) <= most && std::fabs(x[1] - start[1]) <= most &&
                               std::fabs(x[2] - start[2]) <= most;
        if (!is_inside) continue;
        LatticePoint result = search.middle;
        for (std::size_t j = 0; j < 3; ++j) {
            result[j] += search.scale.step * static_cast<std::int32_t>(std::rint((x[j] - start[j]) / unit));
        }
        return result;
    }
    return search.middle;
}

LatticePoint Cell::apex() const {
    std::vector<std::size_t> all(surfaces_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return apex_near({centre(), all, 3, {1, size_}});
}

/// Of a face that becomes a fan: its middle, or a point on the face's surfaces. The middle where it alone
/// tells that a surface passes.
LatticePoint Cell::fan_centre(const std::vector<LocalNode>& loop, const Patch& patch) const {
    const std::uint8_t* active = row(patch.row);
    std::vector<std::size_t> on_face;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        if (active[s] == 0) continue;
        on_face.push_back(s);
        const int middle = pure_sign(s, patch.middle, patch.scale.size);
        const bool alone = middle != 0 && std::all_of(loop.begin(), loop.end(), [&](LocalNode node) {
                               return sign(node, s) == -middle;
                           });
        if (alone) return patch.middle;
    }
    return apex_near({patch.middle, on_face, patch.face / 2, patch.scale});
}

}  // namespace mortise::cnio
