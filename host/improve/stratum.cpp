#include "host/improve/stratum.hpp"

#include <cmath>

#include "kernels/shared/surface.h"

namespace mortise::improve {
namespace {

constexpr int kIterations = 12;
constexpr double kConverged = 1e-11;  ///< of a cell: the last step of Newton's method
constexpr double kTangent = 0.05;     ///< sine between gradients below which surfaces count as tangent

}  // namespace

Surfaces::Surfaces(const tape::BoundModel& model, int level)
    : model_(model), cell_(std::ldexp(1.0, -level)) {}

Surfaces::Sample Surfaces::sample(std::uint32_t surface, const Point& x) const {
    const SurfaceSample s = surface_sample(&model_.surfaces[surface], model_.expression_ops.data(),
                                           x[0] * cell_, x[1] * cell_, x[2] * cell_);
    Sample result{};
    result.value = s.value;
    result.gradient = {s.gradient[0] * cell_, s.gradient[1] * cell_, s.gradient[2] * cell_};
    const double squared = squared_length(result.gradient);
    result.valid = squared > 0 && squared < kMortiseInfinity && result.value - result.value == 0;
    return result;
}

bool Surfaces::is_plane(std::uint32_t surface) const {
    return model_.surfaces[surface].kind == kSurfacePlane;
}

bool Surfaces::project(const std::uint32_t* surfaces, std::size_t count, double reach, Point* x) const {
    if (count == 0 || count > 3) return false;
    const Point start = *x;
    Point p = start;
    for (int i = 0; i < kIterations; ++i) {
        // Steps of minimum norm: in the span of the unit gradients, orthogonalised one after the other.
        Point step = {0, 0, 0};
        Point basis[3];
        for (std::size_t k = 0; k < count; ++k) {
            const Sample s = sample(surfaces[k], p);
            if (!s.valid) return false;
            const double norm = length(s.gradient);
            const Point unit = (1 / norm) * s.gradient;
            Point direction = unit;
            for (std::size_t j = 0; j < k; ++j) direction = direction - dot(unit, basis[j]) * basis[j];
            const double sine = length(direction);
            if (sine < kTangent) return false;
            basis[k] = (1 / sine) * direction;
            // Along basis[k] the surface's linearisation must vanish at p + step.
            const double residual = s.value / norm + dot(unit, step);
            step = step - (residual / sine) * basis[k];
        }
        p = p + step;
        if (squared_length(p - start) > reach * reach) return false;
        if (squared_length(step) < kConverged * kConverged) {
            *x = p;
            return true;
        }
    }
    return false;
}

}  // namespace mortise::improve
