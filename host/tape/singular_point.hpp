// Points where a surface passes and has no normal: the apex of a cone.
#pragma once

#include "kernels/shared/surface.h"

namespace mortise::tape {

/// The one point, in box-local coordinates, where the surface passes and its gradient vanishes or jumps.
/// False: there is none.
bool singular_point(const Surface& surface, double* point);

}  // namespace mortise::tape
