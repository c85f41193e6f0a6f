// Interval arithmetic for general expressions, in float with outward rounding.
//
// Every result holds all values of expression_value over the argument intervals: each operation widens its
// result by a relative 2^-22 (multiplying by 1 ± 2^-24 is not conservative, opencl.md). Where a value may not
// be a number, such as the root of a negative interval, the ends are not numbers, and stay so through every
// later operation: a cell is never decided by them.
#ifndef MORTISE_SHARED_EXPRESSION_BOUNDS_H
#define MORTISE_SHARED_EXPRESSION_BOUNDS_H

#include "expression.h"

typedef struct Interval {
    float low;
    float high;
} Interval;

#define kWiden 2.384185791015625e-7f  // 2^-22
#define kFloatHuge 3.0e38f

MORTISE_FUNCTION Interval make_interval(float low, float high) {
    Interval result;
    // Written so that NaN ends as unbounded.
    result.low = low > -kFloatHuge ? low - (mortise_fabs(low) * kWiden + 1e-37f) : -kFloatHuge * 2;
    result.high = high < kFloatHuge ? high + (mortise_fabs(high) * kWiden + 1e-37f) : kFloatHuge * 2;
    return result;
}

// Bounds of what may not be a number: ends that are not numbers either, so that nothing is decided by them.
MORTISE_FUNCTION Interval undefined_interval(void) {
    Interval result;
    result.low = (float)kMortiseNan;
    result.high = (float)kMortiseNan;
    return result;
}

MORTISE_FUNCTION float smaller(float a, float b) { return a < b ? a : b; }
MORTISE_FUNCTION float larger(float a, float b) { return a > b ? a : b; }

MORTISE_FUNCTION Interval interval_multiply(Interval a, Interval b) {
    const float p = a.low * b.low;
    const float q = a.low * b.high;
    const float r = a.high * b.low;
    const float s = a.high * b.high;
    if (p != p || q != q || r != r || s != s) return undefined_interval();
    return make_interval(smaller(smaller(p, q), smaller(r, s)), larger(larger(p, q), larger(r, s)));
}

// sin over [low, high] + quarter·π/2, from whether a maximum or a minimum lies inside.
MORTISE_FUNCTION Interval interval_sin(Interval a, i32 quarter) {
    const double half_pi = 1.57079632679489661923;
    if (!(a.high - a.low < 6.2f) || !(mortise_fabs(a.low) < 1e6f) || !(mortise_fabs(a.high) < 1e6f)) {
        return make_interval(-1, 1);
    }
    {
        const double low = (double)a.low + quarter * half_pi;
        const double high = (double)a.high + quarter * half_pi;
        const double slack = 1e-7;
        // Maxima at π/2 + 2πn, minima at 3π/2 + 2πn.
        const double top = mortise_floor((high + slack - half_pi) / (4 * half_pi)) * (4 * half_pi) + half_pi;
        const double bottom =
            mortise_floor((high + slack - 3 * half_pi) / (4 * half_pi)) * (4 * half_pi) + 3 * half_pi;
        const double at_low = expression_sin((double)a.low, quarter);
        const double at_high = expression_sin((double)a.high, quarter);
        const float least = (float)(at_low < at_high ? at_low : at_high);
        const float most = (float)(at_low > at_high ? at_low : at_high);
        return make_interval(bottom >= low - slack ? -1.0f : least, top >= low - slack ? 1.0f : most);
    }
}

MORTISE_FUNCTION Interval interval_apply(i32 operation, Interval a, Interval b) {
    const float huge = kFloatHuge * 2;
    // Ends that are not numbers stand for "may not be a number", which every later operation keeps.
    if (a.low != a.low || (operation >= kExprAdd && operation <= kExprMax && b.low != b.low)) {
        return undefined_interval();
    }
    switch (operation) {
        case kExprNegate: return make_interval(-a.high, -a.low);
        case kExprAbs:
            if (a.low >= 0) return a;
            if (a.high <= 0) return make_interval(-a.high, -a.low);
            return make_interval(0, larger(-a.low, a.high));
        case kExprSqrt:
            if (!(a.low >= 0)) return undefined_interval();
            return make_interval((float)mortise_sqrt((double)a.low), (float)mortise_sqrt((double)a.high));
        case kExprSquare: {
            const float p = a.low * a.low;
            const float q = a.high * a.high;
            if (a.low <= 0 && a.high >= 0) return make_interval(0, larger(p, q));
            return make_interval(smaller(p, q), larger(p, q));
        }
        case kExprAdd: return make_interval(a.low + b.low, a.high + b.high);
        case kExprSubtract: return make_interval(a.low - b.high, a.high - b.low);
        case kExprMultiply: return interval_multiply(a, b);
        case kExprDivide: {
            Interval inverse;
            if (!(b.low > 0 || b.high < 0)) return undefined_interval();
            inverse = make_interval((float)(1.0 / (double)b.high), (float)(1.0 / (double)b.low));
            return interval_multiply(a, inverse);
        }
        case kExprMin: return make_interval(smaller(a.low, b.low), smaller(a.high, b.high));
        case kExprMax: return make_interval(larger(a.low, b.low), larger(a.high, b.high));
        case kExprSin: return interval_sin(a, 0);
        case kExprCos: return interval_sin(a, 1);
        case kExprExp:
            return make_interval((float)expression_exp((double)a.low),
                                 a.high < 88.0f ? (float)expression_exp((double)a.high) : huge);
        default:
            if (!(a.low > 0)) return undefined_interval();
            return make_interval((float)expression_log((double)a.low), (float)expression_log((double)a.high));
    }
}

MORTISE_FUNCTION Interval expression_bounds(MORTISE_GLOBAL ExpressionOp* ops, u32 count, Interval x,
                                            Interval y, Interval z) {
    Interval r[kExpressionRegisters];
    r[0] = make_interval(0, 0);
    for (u32 i = 0; i < count; ++i) {
        const i32 operation = ops[i].operation;
        if (operation == kExprConstant) {
            r[ops[i].out] = make_interval((float)ops[i].literal, (float)ops[i].literal);
        } else if (operation <= kExprZ) {
            r[ops[i].out] = operation == kExprX ? x : operation == kExprY ? y : z;
        } else {
            r[ops[i].out] = interval_apply(operation, r[ops[i].a], r[ops[i].b]);
        }
    }
    return r[0];
}

#endif
