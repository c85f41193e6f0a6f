#include "host/tape/sine_lanes.hpp"

#include <cstring>
#include <limits>

#include "host/common/wide.hpp"
#include "kernels/shared/elementary.h"

// Said of every function that takes lanes, though all are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace mortise::tape {
namespace {

MORTISE_REDUCED_SINE_AND_COSINE(template <class Real> [[gnu::always_inline]] inline, Real, sine_series,
                                cosine_series)

/// expression_sin in its order of operations. The nearest integer to a number y below 2^51 is y + kRound -
/// kRound, and its last bits are those of y + kRound; a zero keeps the sign of y, as rint's does.
template <std::size_t kWidth>
[[gnu::always_inline]] inline void find_sines_in(const double* x, std::size_t n, std::int32_t quarter,
                                                 double* out) {
    using Lanes = lanes::Doubles<kWidth>;
    typedef std::int64_t Bits __attribute__((vector_size(kWidth * sizeof(std::int64_t))));
    constexpr double kRound = 6755399441055744.0;
    constexpr std::int64_t kSign = std::numeric_limits<std::int64_t>::min();
    for (std::size_t i = 0; i < n; i += kWidth) {
        Lanes v;
        std::memcpy(&v, x + i, sizeof v);
        const Lanes y = v * 0.63661977236758134308;
        const Lanes shifted = y + kRound;
        const Lanes k = (Lanes)((Bits)(shifted - kRound) | ((Bits)y & kSign));
        Lanes r = v - k * 1.5707963267341256142;
        r = r - k * 6.0771005063039659765e-11;
        r = r - k * 2.0222662487959505e-21;
        const Bits q = (Bits)shifted + quarter;
        const Lanes s = sine_series(r);
        const Lanes c = cosine_series(r);
        Lanes result = (q & 1) != 0 ? c : s;
        result = (q & 2) != 0 ? -result : result;
        const Lanes size = (Lanes)((Bits)v & ~kSign);
        result = size < 1e9 ? result : Lanes{} + kMortiseNan;
        std::memcpy(out + i, &result, sizeof result);
    }
}

MORTISE_BY_WIDTH(void, find_sines, (const double* x, std::size_t n, std::int32_t quarter, double* out),
                 (x, n, quarter, out))

}  // namespace

void sine_lanes(const double* x, std::size_t n, std::int32_t quarter, double* out) {
    find_sines(x, n, quarter, out);
}

}  // namespace mortise::tape
