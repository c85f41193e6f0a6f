// Derivatives of a formula's operations in interval arithmetic.
#pragma once

#include <cstdint>

#include "kernels/shared/expression_bounds.h"

namespace mortise::tape {

/// A factor that may be anything times a derivative that is 0.
Interval chain(Interval by, Interval d);

/// expression_slopes in interval arithmetic, but for min and max. Where a function may jump: not numbers.
void interval_slopes(std::int32_t operation, Interval a, Interval b, Interval f, Interval* by_a,
                     Interval* by_b);

/// Derivative of min or max, da and db being those of its arguments.
Interval slope_of_extremum(std::int32_t operation, Interval a, Interval b, Interval da, Interval db);

}  // namespace mortise::tape
