// Interval arithmetic for general expressions, in float with outward rounding.
//
// Every result holds all values of expression_value over the argument intervals: each operation widens its
// result by a relative 2^-22 (multiplying by 1 ± 2^-24 is not conservative), except those whose
// results are exact. Infinite ends mean any size. `partial` tells that some value may not be a number, such
// as a root of [-1, 1]; the ends hold the others then, and there may be none (low > high). What is not a
// number is outside: it keeps a cell from being inside, not from being outside.
#ifndef MORTISE_SHARED_EXPRESSION_BOUNDS_H
#define MORTISE_SHARED_EXPRESSION_BOUNDS_H

#include "expression.h"

typedef struct Interval {
    float low;
    float high;
    i32 partial MORTISE_DEFAULT(0);
} Interval;

#define kWiden 2.384185791015625e-7f  // 2^-22
#define kFloatHuge 3.0e38f

MORTISE_FUNCTION Interval make_interval(float low, float high) {
    Interval result;
    result.partial = 0;
    // Written so that NaN ends as unbounded. What overflows is larger than any float.
    result.low = low > -kFloatHuge
                     ? (low < kFloatHuge ? low - (mortise_fabs(low) * kWiden + 1e-37f) : kFloatHuge)
                     : -kFloatHuge * 2;
    result.high = high < kFloatHuge
                      ? (high > -kFloatHuge ? high + (mortise_fabs(high) * kWiden + 1e-37f) : -kFloatHuge)
                      : kFloatHuge * 2;
    return result;
}

MORTISE_FUNCTION Interval exact_interval(float low, float high) {
    Interval result;
    result.low = low;
    result.high = high;
    result.partial = 0;
    return result;
}

// The numbers of an operation that may also give what is none.
MORTISE_FUNCTION Interval partly(Interval numbers) {
    numbers.partial = 1;
    return numbers;
}

MORTISE_FUNCTION Interval any_number(void) {
    return exact_interval(-(float)kMortiseInfinity, (float)kMortiseInfinity);
}

// Bounds of what is not a number anywhere.
MORTISE_FUNCTION Interval empty_interval(void) {
    return partly(exact_interval((float)kMortiseInfinity, -(float)kMortiseInfinity));
}

// Bounds of what may be anything.
MORTISE_FUNCTION Interval undefined_interval(void) { return partly(any_number()); }

MORTISE_FUNCTION int is_empty_interval(Interval a) { return a.low > a.high; }
// -1: inside, 1: outside (or not a number), 0: undecided.
MORTISE_FUNCTION int interval_sign(Interval a) {
    if (a.low > 0) return 1;
    return a.high < 0 && !a.partial ? -1 : 0;
}
MORTISE_FUNCTION int holds_zero(Interval a) { return a.low <= 0 && a.high >= 0; }
MORTISE_FUNCTION int is_unbounded(Interval a) { return !(a.low > -kFloatHuge) || !(a.high < kFloatHuge); }

MORTISE_FUNCTION float smaller(float a, float b) { return a < b ? a : b; }
MORTISE_FUNCTION float larger(float a, float b) { return a > b ? a : b; }

MORTISE_FUNCTION Interval interval_hull(Interval a, Interval b) {
    return exact_interval(smaller(a.low, b.low), larger(a.high, b.high));
}

// Undoes the widening below zero of what cannot be negative: a root may follow.
MORTISE_FUNCTION Interval nonnegative(Interval a) {
    if (a.low < 0) a.low = 0;
    return a;
}

MORTISE_FUNCTION Interval interval_add(Interval a, Interval b) {
    // ∞ - ∞
    if ((!(a.high < kFloatHuge) && !(b.low > -kFloatHuge)) ||
        (!(b.high < kFloatHuge) && !(a.low > -kFloatHuge))) {
        return undefined_interval();
    }
    const Interval sum = make_interval(a.low + b.low, a.high + b.high);
    return a.low >= 0 && b.low >= 0 ? nonnegative(sum) : sum;
}

MORTISE_FUNCTION Interval interval_multiply(Interval a, Interval b) {
    // 0 · ∞
    if ((is_unbounded(a) && holds_zero(b)) || (is_unbounded(b) && holds_zero(a))) return undefined_interval();
    const float p = a.low * b.low;
    const float q = a.low * b.high;
    const float r = a.high * b.low;
    const float s = a.high * b.high;
    const Interval product =
        make_interval(smaller(smaller(p, q), smaller(r, s)), larger(larger(p, q), larger(r, s)));
    if (p != p || q != q || r != r || s != s) return undefined_interval();
    return a.low >= 0 && b.low >= 0 ? nonnegative(product) : product;
}

MORTISE_FUNCTION Interval interval_divide(Interval a, Interval b) {
    if (holds_zero(b)) {
        // The sign of a zero is not known, so nor is that of the quotient.
        return holds_zero(a) ? undefined_interval() : any_number();
    }
    const Interval inverse = make_interval((float)(1.0 / (double)b.high), (float)(1.0 / (double)b.low));
    return interval_multiply(a, b.low > 0 ? nonnegative(inverse) : inverse);
}

// sin over [low, high] + quarter·π/2, from whether a maximum or a minimum lies inside.
MORTISE_FUNCTION Interval interval_sin(Interval a, i32 quarter) {
    const double half_pi = 1.57079632679489661923;
    if (!(mortise_fabs(a.low) < 9e8f) || !(mortise_fabs(a.high) < 9e8f)) return partly(make_interval(-1, 1));
    if (!(a.high - a.low < 6.2f) || !(mortise_fabs(a.low) < 1e6f) || !(mortise_fabs(a.high) < 1e6f)) {
        return make_interval(-1, 1);
    }
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

// Monotone between two poles; anything where one may lie between the ends.
MORTISE_FUNCTION Interval interval_tan(Interval a) {
    const double pi = 3.14159265358979323846;
    if (!(mortise_fabs(a.low) < 9e8f) || !(mortise_fabs(a.high) < 9e8f)) return undefined_interval();
    if (!(mortise_fabs(a.low) < 1e6f) || !(mortise_fabs(a.high) < 1e6f) ||
        mortise_rint((double)a.low / pi - 1e-7) != mortise_rint((double)a.high / pi + 1e-7)) {
        return any_number();
    }
    return make_interval((float)expression_tan((double)a.low), (float)expression_tan((double)a.high));
}

// Seen from the origin, the ends of a box's angle are at its corners, unless it meets the cut.
MORTISE_FUNCTION Interval interval_atan2(Interval y, Interval x) {
    const float pi = 3.1415927f;
    double least;
    double most;
    if (y.low < 0 && y.high >= 0 && x.low <= 0) return make_interval(-pi, pi);
    least = most = expression_atan2((double)y.low, (double)x.low);
    for (int i = 1; i < 4; ++i) {
        const double angle =
            expression_atan2((double)((i & 1) ? y.high : y.low), (double)((i & 2) ? x.high : x.low));
        least = angle < least ? angle : least;
        most = angle > most ? angle : most;
    }
    return make_interval((float)least, (float)most);
}

MORTISE_FUNCTION Interval interval_mod(Interval a, Interval b) {
    double least;
    double most;
    double whole;
    double slack;
    const float modulus = larger(-b.low, b.high);
    if (holds_zero(b) || is_unbounded(a) || is_unbounded(b))
        return partly(nonnegative(make_interval(0, modulus)));
    if (b.high < 0) b = exact_interval(-b.high, -b.low);
    least = (double)a.low / (double)(a.low < 0 ? b.low : b.high);
    most = (double)a.high / (double)(a.high < 0 ? b.high : b.low);
    if (!(least > -9e14) || !(most < 9e14)) return partly(nonnegative(make_interval(0, b.high)));
    slack = 1e-12 * (1 + mortise_fabs(least) + mortise_fabs(most));
    whole = mortise_floor(least - slack);
    if (whole != mortise_floor(most + slack)) return nonnegative(make_interval(0, b.high));
    // One branch: a - whole · b, but not below 0 and not above b.
    slack =
        1e-12 * (mortise_fabs((double)a.low) + mortise_fabs((double)a.high) + mortise_fabs(whole) * b.high);
    least = (double)a.low - whole * (double)(whole < 0 ? b.low : b.high) - slack;
    most = (double)a.high - whole * (double)(whole < 0 ? b.high : b.low) + slack;
    return nonnegative(make_interval((float)least, (float)(most < (double)b.high ? most : (double)b.high)));
}

MORTISE_FUNCTION Interval interval_compare(Interval a, Interval b) {
    return exact_interval(a.low < b.high ? -1.0f : (a.low > b.high ? 1.0f : 0.0f),
                          a.high > b.low ? 1.0f : (a.high < b.low ? -1.0f : 0.0f));
}

MORTISE_FUNCTION Interval interval_hypot(Interval a, Interval b) {
    const float p = a.low > 0 ? a.low : (a.high < 0 ? -a.high : 0.0f);
    const float q = b.low > 0 ? b.low : (b.high < 0 ? -b.high : 0.0f);
    return nonnegative(make_interval(
        (float)expression_hypot((double)p, (double)q),
        (float)expression_hypot((double)larger(-a.low, a.high), (double)larger(-b.low, b.high))));
}

// a^b is monotone in each argument where a is positive, so its ends are at corners.
MORTISE_FUNCTION Interval interval_power_of_positive(Interval a, Interval b) {
    double least;
    double most;
    least = most = expression_power((double)a.low, (double)b.low);
    for (int i = 1; i < 4; ++i) {
        const double value =
            expression_power((double)((i & 1) ? a.high : a.low), (double)((i & 2) ? b.high : b.low));
        least = value < least ? value : least;
        most = value > most ? value : most;
    }
    if (a.low == 0 && holds_zero(b)) {  // 0^0 = 1 beside 0^b = 0
        least = 0;
        most = most > 1 ? most : 1;
    }
    return nonnegative(make_interval((float)least, (float)most));
}

MORTISE_FUNCTION Interval interval_power(Interval a, Interval b) {
    const int one_exponent = b.low == b.high;
    double least;
    double most;
    const int broken = mortise_floor(b.high) < b.low;  // no exponent is whole
    if (a.high < 0 && broken) return empty_interval();
    if (a.low < 0 && broken) return partly(interval_power_of_positive(exact_interval(0, a.high), b));
    if (a.low < 0) {
        const double n = (double)b.low;
        if (!one_exponent || mortise_rint(n) != n || is_unbounded(a)) return undefined_interval();
        if (n <= 0 && a.high >= 0) {
            return n == 0 ? exact_interval(1, 1) : any_number();
        }
        least = expression_power((double)a.low, n);
        most = expression_power((double)a.high, n);
        if (least > most) {
            const double first = least;
            least = most;
            most = first;
        }
        if (a.high > 0 && mortise_rint(n * 0.5) == n * 0.5) least = 0;
        return make_interval((float)least, (float)most);
    }
    return interval_power_of_positive(a, b);
}

MORTISE_FUNCTION Interval interval_inverse(i32 operation, Interval a) {
    if (operation == kExprAsin) {
        return make_interval((float)expression_asin((double)a.low), (float)expression_asin((double)a.high));
    }
    return nonnegative(
        make_interval((float)expression_acos((double)a.high), (float)expression_acos((double)a.low)));
}

// Numbers only: of arguments that are not empty, whatever their `partial`.
MORTISE_FUNCTION Interval interval_of_numbers(i32 operation, Interval a, Interval b) {
    switch (operation) {
        case kExprNegate: return exact_interval(-a.high, -a.low);
        case kExprAbs:
            if (a.low >= 0) return a;
            if (a.high <= 0) return exact_interval(-a.high, -a.low);
            return exact_interval(0, larger(-a.low, a.high));
        case kExprSqrt:
            if (a.high < 0) return empty_interval();
            if (!(a.low >= 0))
                return partly(exact_interval(0, make_interval(0, (float)mortise_sqrt((double)a.high)).high));
            return nonnegative(
                make_interval((float)mortise_sqrt((double)a.low), (float)mortise_sqrt((double)a.high)));
        case kExprSquare: {
            const float p = a.low * a.low;
            const float q = a.high * a.high;
            return nonnegative(make_interval(holds_zero(a) ? 0.0f : smaller(p, q), larger(p, q)));
        }
        case kExprAdd: return interval_add(a, b);
        case kExprSubtract: return interval_add(a, exact_interval(-b.high, -b.low));
        case kExprMultiply: return interval_multiply(a, b);
        case kExprDivide: return interval_divide(a, b);
        case kExprMin: return exact_interval(smaller(a.low, b.low), smaller(a.high, b.high));
        case kExprMax: return exact_interval(larger(a.low, b.low), larger(a.high, b.high));
        case kExprSin: return interval_sin(a, 0);
        case kExprCos: return interval_sin(a, 1);
        case kExprExp:
            return nonnegative(make_interval(
                (float)expression_exp((double)a.low),
                a.high < 88.0f ? (float)expression_exp((double)a.high) : (float)kMortiseInfinity));
        case kExprLog:
            if (a.high < 0) return empty_interval();
            if (!(a.low >= 0)) {
                return partly(exact_interval(-(float)kMortiseInfinity,
                                             make_interval(0, (float)expression_log((double)a.high)).high));
            }
            return make_interval((float)expression_log((double)a.low), (float)expression_log((double)a.high));
        case kExprTan: return interval_tan(a);
        case kExprAsin:
        case kExprAcos:
            if (a.low > 1 || a.high < -1) return empty_interval();
            if (!(a.low >= -1) || !(a.high <= 1)) {
                return partly(
                    interval_inverse(operation, exact_interval(larger(a.low, -1), smaller(a.high, 1))));
            }
            return interval_inverse(operation, a);
        case kExprAtan:
            return make_interval((float)expression_atan((double)a.low),
                                 (float)expression_atan((double)a.high));
        case kExprFloor: return exact_interval(mortise_floor(a.low), mortise_floor(a.high));
        case kExprCeil: return exact_interval(-mortise_floor(-a.low), -mortise_floor(-a.high));
        case kExprRound:
            return exact_interval((float)expression_round((double)a.low),
                                  (float)expression_round((double)a.high));
        case kExprSign: return interval_compare(a, exact_interval(0, 0));
        case kExprNot:
            return exact_interval(a.low == 0 && a.high == 0 ? 1.0f : 0.0f, holds_zero(a) ? 1.0f : 0.0f);
        case kExprAtan2: return interval_atan2(a, b);
        case kExprMod: return interval_mod(a, b);
        case kExprCompare: return interval_compare(a, b);
        case kExprHypot: return interval_hypot(a, b);
        default: return interval_power(a, b);
    }
}

MORTISE_FUNCTION Interval interval_apply(i32 operation, Interval a, Interval b) {
    Interval result;
    if (operation == kExprAnd || operation == kExprOr) {
        // The argument that is not taken may be anything.
        const int zero = a.low == 0 && a.high == 0;
        if (is_empty_interval(a)) return a;
        if (!holds_zero(a)) {
            result = operation == kExprAnd ? b : a;
        } else if (zero) {
            result = operation == kExprAnd ? a : b;
        } else {
            const Interval other = operation == kExprAnd ? exact_interval(0, 0) : a;
            result = is_empty_interval(b) ? other : interval_hull(other, b);
            result.partial = b.partial;
        }
        result.partial |= a.partial;
        return result;
    }
    if (is_empty_interval(a)) return a;
    if (expression_is_binary(operation)) {
        if (is_empty_interval(b)) return b;
        a.partial |= b.partial;
    }
    result = interval_of_numbers(operation, a, b);
    // Ends that are no numbers bound nothing.
    if (result.low != result.low) result.low = -(float)kMortiseInfinity;
    if (result.high != result.high) result.high = (float)kMortiseInfinity;
    result.partial |= a.partial;
    return result;
}

// A number, exact where it is one in single precision: exponents and moduli usually are.
MORTISE_FUNCTION Interval interval_literal(double literal) {
    const float rounded = (float)literal;
    return (double)rounded == literal ? exact_interval(rounded, rounded) : make_interval(rounded, rounded);
}

MORTISE_NOINLINE Interval expression_bounds(MORTISE_GLOBAL ExpressionOp* ops, u32 count, Interval x,
                                            Interval y, Interval z) {
    Interval r[kExpressionRegisters + 1];
    r[0] = make_interval(0, 0);
    for (u32 i = 0; i < count; ++i) {
        const i32 operation = ops[i].operation;
        if (operation == kExprConstant) {
            r[ops[i].out] = interval_literal(ops[i].literal);
        } else if (operation <= kExprZ) {
            r[ops[i].out] = operation == kExprX ? x : operation == kExprY ? y : z;
        } else {
            if (ops[i].a == kExpressionLiteral || ops[i].b == kExpressionLiteral) {
                r[kExpressionLiteral] = interval_literal(ops[i].literal);
            }
            r[ops[i].out] = interval_apply(operation, r[ops[i].a], r[ops[i].b]);
        }
    }
    return r[0];
}

#endif
