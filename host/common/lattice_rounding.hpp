// Rounding of positions to their lattice (kernels/shared/lattice.h), of numbers or of lanes of them.
#pragma once

#include "kernels/shared/lattice.h"

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace mortise {

/// To the nearest whole number, as std::rint, without a call: beyond 1.5 × 2^52 numbers have no fractions.
template <class Real>
[[gnu::always_inline]] inline Real round_to_whole(const Real& x) {
    constexpr double kRounder = 6755399441055744.0;
    return (x + kRounder) - kRounder;
}

/// A coordinate in finest cells, to the lattice.
template <class Real>
[[gnu::always_inline]] inline Real round_to_lattice(const Real& cells) {
    return round_to_whole<Real>(cells * kCellUnits) * (1.0 / kCellUnits);
}

}  // namespace mortise
