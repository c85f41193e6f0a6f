// Where the apex of a cell lies (algorithms.md §2: corner before crease before surface before centre).
#include <algorithm>
#include <cmath>

#include "host/cnio/cell.hpp"
#include "host/tape/projection.hpp"

namespace mortise::cnio {
namespace {

constexpr double kNear = 0.15;      ///< cells: surfaces farther from the centre leave it where it is
constexpr double kReach = 0.25;     ///< cells: how far an apex may move
constexpr double kTangent = 0.1;    ///< sine between gradients below which surfaces do not cross
constexpr double kSettled = 1e-10;  ///< cells: the last step

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

/// Distance from a surface, to first order, in cells; infinite where the gradient vanishes.
double Cell::distance_to(std::size_t surface, const double* x) const {
    const SurfaceSample s =
        surface_sample(&model_.surfaces[surfaces_[surface]], model_.expression_ops.data(), x[0], x[1], x[2]);
    const double slope = std::sqrt(dot(s.gradient, s.gradient));
    const double distance = std::fabs(s.value) / (slope * size_);
    return slope > 0 && std::isfinite(distance) ? distance : kMortiseInfinity;
}

LatticePoint Cell::apex() const {
    double start[3];
    position(centre(), start);
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        const double distance = distance_to(s, start);
        if (distance < kNear) near.push_back({distance, s});
    }
    std::sort(near.begin(), near.end());
    for (std::size_t count = std::min<std::size_t>(near.size(), 3); count > 0; --count) {
        std::vector<std::uint32_t> on;
        for (std::size_t k = 0; k < count; ++k) on.push_back(surfaces_[near[k].second]);
        double x[3] = {start[0], start[1], start[2]};
        if (!tape::project(model_, on.data(), count, {kReach * size_, kTangent, kSettled * size_}, x))
            continue;
        LatticePoint result = centre();
        for (std::size_t j = 0; j < 3; ++j) {
            result[j] += static_cast<std::int32_t>(std::rint((x[j] - start[j]) / size_ * units_));
        }
        return result;
    }
    return centre();
}

}  // namespace mortise::cnio
