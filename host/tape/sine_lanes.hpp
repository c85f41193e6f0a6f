// Sines of many numbers in vector instructions, for lanes.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace mortise::tape {

/// out[k] = expression_sin(x[k], quarter), the same bits, for k < n. Arrays of a multiple of eight numbers:
/// what is behind n there is read and written, too.
void sine_lanes(const double* x, std::size_t n, std::int32_t quarter, double* out);

}  // namespace mortise::tape
