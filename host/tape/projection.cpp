#include "host/tape/projection.hpp"

#include <cmath>

namespace mortise::tape {
namespace {

constexpr int kProjectionSteps = 12;

double inner_product(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

bool project(const BoundModel& model, const std::uint32_t* surfaces, std::size_t count,
             const ProjectionLimits& limits, double* x) {
    if (count == 0 || count > 3) return false;
    double p[3] = {x[0], x[1], x[2]};
    for (int step = 0; step < kProjectionSteps; ++step) {
        // In the span of the unit gradients, orthogonalised one after the other.
        double basis[3][3];
        double move[3] = {0, 0, 0};
        for (std::size_t k = 0; k < count; ++k) {
            const SurfaceSample s =
                surface_sample(&model.surfaces[surfaces[k]], model.expression_ops.data(), p[0], p[1], p[2]);
            const double slope = std::sqrt(inner_product(s.gradient, s.gradient));
            if (!(slope > 0 && slope < kMortiseInfinity && std::isfinite(s.value))) return false;
            double unit[3];
            for (int j = 0; j < 3; ++j) {
                unit[j] = basis[k][j] = j == limits.fixed_axis ? 0 : 1 / slope * s.gradient[j];
            }
            for (std::size_t i = 0; i < k; ++i) {
                const double along = inner_product(unit, basis[i]);
                for (int j = 0; j < 3; ++j) basis[k][j] -= along * basis[i][j];
            }
            const double sine = std::sqrt(inner_product(basis[k], basis[k]));
            if (!(sine >= limits.tangent)) return false;
            // Along basis[k] the surface's linearisation must vanish at p + move.
            const double residual = s.value / slope + inner_product(unit, move);
            for (int j = 0; j < 3; ++j) {
                basis[k][j] *= 1 / sine;
                move[j] -= residual / sine * basis[k][j];
            }
        }
        double away[3];
        for (int j = 0; j < 3; ++j) {
            p[j] += move[j];
            away[j] = p[j] - x[j];
        }
        if (!(inner_product(away, away) <= limits.reach * limits.reach)) return false;
        if (inner_product(move, move) < limits.settled * limits.settled) {
            for (int j = 0; j < 3; ++j) x[j] = p[j];
            return true;
        }
    }
    return false;
}

}  // namespace mortise::tape
