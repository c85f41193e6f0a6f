// Where the apexes of cells and faces lie (algorithms.md §2: corner before crease before surface before
// centre).
#include <algorithm>
#include <cmath>

#include "host/cnio/cell.hpp"

namespace mortise::cnio {
namespace {

constexpr double kNear = 0.15;   ///< cells: surfaces farther from the centre leave it where it is
constexpr double kReach = 0.25;  ///< cells: how far an apex may move
constexpr int kSteps = 12;
constexpr double kTangent = 0.1;    ///< sine between gradients below which surfaces do not cross
constexpr double kSettled = 1e-10;  ///< cells: the last step

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

/// Distance from a surface, to first order, in cells; infinite where the gradient vanishes.
double Cell::distance_to(std::size_t surface, const double* x) const {
    SurfaceSample s =
        surface_sample(&model_.surfaces[surfaces_[surface]], model_.expression_ops.data(), x[0], x[1], x[2]);
    const double slope = std::sqrt(dot(s.gradient, s.gradient));
    const double distance = std::fabs(s.value) / (slope * size_);
    return slope > 0 && std::isfinite(distance) ? distance : kMortiseInfinity;
}

/// Newton's method by steps of least length; false if it does not settle within reach.
bool Cell::project(const std::vector<std::size_t>& surfaces, double* x) const {
    const double start[3] = {x[0], x[1], x[2]};
    for (int step = 0; step < kSteps; ++step) {
        double basis[3][3];
        double move[3] = {0, 0, 0};
        for (std::size_t k = 0; k < surfaces.size(); ++k) {
            const SurfaceSample s = surface_sample(&model_.surfaces[surfaces_[surfaces[k]]],
                                                   model_.expression_ops.data(), x[0], x[1], x[2]);
            const double slope = std::sqrt(dot(s.gradient, s.gradient));
            if (!(slope > 0 && slope < kMortiseInfinity)) return false;
            double unit[3];
            for (int j = 0; j < 3; ++j) unit[j] = basis[k][j] = s.gradient[j] / slope;
            for (std::size_t i = 0; i < k; ++i) {
                const double along = dot(unit, basis[i]);
                for (int j = 0; j < 3; ++j) basis[k][j] -= along * basis[i][j];
            }
            const double sine = std::sqrt(dot(basis[k], basis[k]));
            if (!(sine >= kTangent)) return false;
            // Along basis[k] the surface's linearisation must vanish at x + move.
            const double residual = s.value / slope + dot(unit, move);
            for (int j = 0; j < 3; ++j) {
                basis[k][j] /= sine;
                move[j] -= residual / sine * basis[k][j];
            }
        }
        double away = 0;
        for (int j = 0; j < 3; ++j) {
            x[j] += move[j];
            away += (x[j] - start[j]) * (x[j] - start[j]);
        }
        if (!(away <= kReach * kReach * size_ * size_)) return false;
        if (dot(move, move) <= kSettled * kSettled * size_ * size_) return true;
    }
    return false;
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
        std::vector<std::size_t> on;
        for (std::size_t k = 0; k < count; ++k) on.push_back(near[k].second);
        double x[3] = {start[0], start[1], start[2]};
        if (!project(on, x)) continue;
        LatticePoint result = centre();
        for (std::size_t j = 0; j < 3; ++j) {
            result[j] += static_cast<std::int32_t>(std::rint((x[j] - start[j]) / size_ * units_));
        }
        return result;
    }
    return centre();
}

}  // namespace mortise::cnio
