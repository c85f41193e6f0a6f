#include "host/tape/lanes.hpp"

#include "host/tape/interval_slopes.hpp"
#include "host/tape/sine_lanes.hpp"

namespace mortise::tape {
namespace {

using Bounds = BoundsLanes::Block;

/// make_interval for ends that are not huge.
float widened_low(float low) { return low - (mortise_fabs(low) * kWiden + 1e-37f); }
float widened_high(float high) { return high + (mortise_fabs(high) * kWiden + 1e-37f); }
float lifted(float low, bool is_nonnegative) { return is_nonnegative && low < 0 ? 0.0f : low; }

float nearest_to_zero(float low, float high) { return low > 0 ? low : (high < 0 ? -high : 0.0f); }

/// expression_hypot of finite numbers that are not negative.
double hypot_of_sizes(double p, double q) {
    const double most = p > q ? p : q;
    const double ratio = (p > q ? q : p) / (most > 0 ? most : 1);
    return most * mortise_sqrt(1 + ratio * ratio);
}

/// interval_apply for tame blocks; false: not an operation of these.
bool apply_tame(std::int32_t operation, const Bounds& a, const Bounds& b, Bounds& out, std::size_t n) {
    switch (operation) {
        case kExprNegate:
            for (std::size_t k = 0; k < n; ++k) {
                out.low[k] = -a.high[k];
                out.high[k] = -a.low[k];
            }
            return true;
        case kExprSquare:
            for (std::size_t k = 0; k < n; ++k) {
                const float p = a.low[k] * a.low[k];
                const float q = a.high[k] * a.high[k];
                const bool zero = a.low[k] <= 0 && a.high[k] >= 0;
                out.low[k] = lifted(widened_low(zero ? 0.0f : smaller(p, q)), true);
                out.high[k] = widened_high(larger(p, q));
            }
            return true;
        case kExprAdd:
            for (std::size_t k = 0; k < n; ++k) {
                const bool positive = (a.low[k] >= 0) & (b.low[k] >= 0);
                out.low[k] = lifted(widened_low(a.low[k] + b.low[k]), positive);
                out.high[k] = widened_high(a.high[k] + b.high[k]);
            }
            return true;
        case kExprSubtract:
            for (std::size_t k = 0; k < n; ++k) {
                const bool positive = (a.low[k] >= 0) & (-b.high[k] >= 0);
                out.low[k] = lifted(widened_low(a.low[k] + -b.high[k]), positive);
                out.high[k] = widened_high(a.high[k] + -b.low[k]);
            }
            return true;
        case kExprMultiply:
            for (std::size_t k = 0; k < n; ++k) {
                const float p = a.low[k] * b.low[k];
                const float q = a.low[k] * b.high[k];
                const float r = a.high[k] * b.low[k];
                const float s = a.high[k] * b.high[k];
                const bool positive = (a.low[k] >= 0) & (b.low[k] >= 0);
                out.low[k] = lifted(widened_low(smaller(smaller(p, q), smaller(r, s))), positive);
                out.high[k] = widened_high(larger(larger(p, q), larger(r, s)));
            }
            return true;
        case kExprMin:
            for (std::size_t k = 0; k < n; ++k) {
                out.low[k] = smaller(a.low[k], b.low[k]);
                out.high[k] = smaller(a.high[k], b.high[k]);
            }
            return true;
        case kExprMax:
            for (std::size_t k = 0; k < n; ++k) {
                out.low[k] = larger(a.low[k], b.low[k]);
                out.high[k] = larger(a.high[k], b.high[k]);
            }
            return true;
        case kExprHypot:
            for (std::size_t k = 0; k < n; ++k) {
                const double p = nearest_to_zero(a.low[k], a.high[k]);
                const double q = nearest_to_zero(b.low[k], b.high[k]);
                out.low[k] = lifted(widened_low(static_cast<float>(hypot_of_sizes(p, q))), true);
            }
            for (std::size_t k = 0; k < n; ++k) {
                const double p = mortise_fabs(double{larger(-a.low[k], a.high[k])});
                const double q = mortise_fabs(double{larger(-b.low[k], b.high[k])});
                out.high[k] = widened_high(static_cast<float>(hypot_of_sizes(p, q)));
            }
            return true;
        default: return false;
    }
}

}  // namespace

void BoundsLanes::finish(Block& block, std::size_t n) {
    constexpr float kTame = 1e18f;
    std::int32_t wild = 0;  // of the width of a lane, for vector instructions
    for (std::size_t k = 0; k < n; ++k) {
        wild |= block.low[k] > -kTame ? 0 : 1;
        wild |= block.high[k] < kTame ? 0 : 1;
        wild |= block.low[k] <= block.high[k] ? 0 : 1;
        wild |= block.partial[k];
    }
    block.is_tame = wild == 0;
}

void BoundsLanes::apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n) {
    const bool tame = a.is_tame && (b.is_tame || expression_is_binary(operation) == 0);
    if (tame && apply_tame(operation, a, b, out, n)) {
        for (std::size_t k = 0; k < n; ++k) out.partial[k] = 0;
    } else {
        for (std::size_t k = 0; k < n; ++k) set(out, k, interval_apply(operation, get(a, k), get(b, k)));
    }
    finish(out, n);
}

void ValueLanes::apply(std::int32_t operation, const Block& p, const Block& q, Block& out, std::size_t n) {
    const double* a = p.value;
    const double* b = q.value;
    double* f = out.value;
    switch (operation) {
        case kExprNegate:
            for (std::size_t k = 0; k < n; ++k) f[k] = -a[k];
            break;
        case kExprSquare:
            for (std::size_t k = 0; k < n; ++k) f[k] = a[k] * a[k];
            break;
        case kExprAdd:
            for (std::size_t k = 0; k < n; ++k) f[k] = a[k] + b[k];
            break;
        case kExprSubtract:
            for (std::size_t k = 0; k < n; ++k) f[k] = a[k] - b[k];
            break;
        case kExprMultiply:
            for (std::size_t k = 0; k < n; ++k) f[k] = a[k] * b[k];
            break;
        case kExprDivide:
            for (std::size_t k = 0; k < n; ++k) f[k] = a[k] / b[k];
            break;
        case kExprSin: sine_lanes(a, n, 0, f); break;
        case kExprCos: sine_lanes(a, n, 1, f); break;
        default:
            for (std::size_t k = 0; k < n; ++k) f[k] = expression_apply(operation, a[k], b[k]);
            break;
    }
}

void SampleLanes::apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n) {
    double by_a[kLanes];
    double by_b[kLanes];
    ValueLanes::apply(operation, a.f, b.f, out.f, n);
    switch (operation) {
        case kExprAdd:
        case kExprSubtract:
            for (std::size_t k = 0; k < n; ++k) {
                by_a[k] = 1;
                by_b[k] = operation == kExprAdd ? 1 : -1;
            }
            break;
        case kExprMultiply:
            for (std::size_t k = 0; k < n; ++k) {
                by_a[k] = b.f.value[k];
                by_b[k] = a.f.value[k];
            }
            break;
        case kExprSquare:
            for (std::size_t k = 0; k < n; ++k) {
                by_a[k] = 2 * a.f.value[k];
                by_b[k] = 0;
            }
            break;
        case kExprSin:
        case kExprCos:
            sine_lanes(a.f.value, n, operation == kExprSin ? 1 : 0, by_a);
            for (std::size_t k = 0; k < n; ++k) {
                if (operation == kExprCos) by_a[k] = -by_a[k];
                by_b[k] = 0;
            }
            break;
        default:
            for (std::size_t k = 0; k < n; ++k) {
                expression_slopes(operation, a.f.value[k], b.f.value[k], out.f.value[k], &by_a[k], &by_b[k]);
            }
            break;
    }
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < n; ++k) {
            const double da = a.slope[j][k];
            const double db = b.slope[j][k];
            // Bits that are cleared where a product does not count, as in expression_sample.
            const double first = by_a[k] * da;
            const double second = by_b[k] * db;
            out.slope[j][k] =
                ((by_a[k] != 0) & (da != 0) ? first : 0) + ((by_b[k] != 0) & (db != 0) ? second : 0);
        }
    }
}

void GradientLanes::apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n) {
    BoundsLanes::apply(operation, a.f, b.f, out.f, n);
    const bool binary = expression_is_binary(operation) != 0;
    const bool is_sum = operation == kExprAdd || operation == kExprSubtract || operation == kExprNegate;
    bool tame = a.f.is_tame && (!binary || b.f.is_tame);
    for (std::size_t j = 0; j < 3; ++j) tame = tame && a.slope[j].is_tame && (!binary || b.slope[j].is_tame);
    if (is_sum || (tame && (operation == kExprSquare || operation == kExprMultiply))) {
        BoundsLanes::Block first;
        BoundsLanes::Block second;
        for (std::size_t j = 0; j < 3; ++j) {
            if (is_sum) {
                BoundsLanes::apply(operation, a.slope[j], b.slope[j], out.slope[j], n);
                continue;
            }
            BoundsLanes::apply(kExprMultiply, b.f, a.slope[j], first, n);
            if (binary) BoundsLanes::apply(kExprMultiply, a.f, b.slope[j], second, n);
            BoundsLanes::apply(kExprAdd, first, binary ? second : first, out.slope[j], n);
        }
        return;
    }
    for (std::size_t k = 0; k < n; ++k) {
        const Interval p = BoundsLanes::get(a.f, k);
        const Interval q = BoundsLanes::get(b.f, k);
        Interval by_a;
        Interval by_b;
        interval_slopes(operation, p, q, BoundsLanes::get(out.f, k), &by_a, &by_b);
        for (std::size_t j = 0; j < 3; ++j) {
            const Interval da = BoundsLanes::get(a.slope[j], k);
            const Interval db = BoundsLanes::get(b.slope[j], k);
            Interval slope;
            if (operation == kExprMin || operation == kExprMax)
                slope = slope_of_extremum(operation, p, q, da, db);
            else if (!binary)
                slope = chain(by_a, da);
            else
                slope = interval_apply(kExprAdd, chain(by_a, da), chain(by_b, db));
            BoundsLanes::set(out.slope[j], k, slope);
        }
    }
    for (BoundsLanes::Block& slope : out.slope) BoundsLanes::finish(slope, n);
}

}  // namespace mortise::tape
