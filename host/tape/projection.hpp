// Newton's method onto up to three surfaces at once: feet of points on faces, creases and corners of the
// model.
#pragma once

#include <cstdint>

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Lengths are box-local.
struct ProjectionLimits {
    double reach;        ///< the point may move this far
    double tangent;      ///< sine between gradients below which surfaces do not cross
    double settled;      ///< length of the last step
    int fixed_axis = 3;  ///< the coordinate that stays as it is; 3: none
};

/// Moves x onto the surfaces by steps of least length. False, and x as it was, if a gradient vanishes,
/// surfaces are tangent, or it does not settle within reach.
bool project(const BoundModel& model, const std::uint32_t* surfaces, std::size_t count,
             const ProjectionLimits& limits, double* x);

}  // namespace mortise::tape
