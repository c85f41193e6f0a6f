// Rounded solids in the form of kernels/shared/rounded.h.
#pragma once

#include <vector>

#include "kernels/shared/surface.h"
#include "mortise/model.hpp"

namespace mortise::tape {

/// Appends the solid's data to the arena. The surface's map is the identity.
Surface write_rounded(const RoundedSolid& solid, std::vector<ExpressionOp>& arena);

}  // namespace mortise::tape
