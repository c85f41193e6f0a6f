// expression_sample (shared/expression.h) at eight points at a time: the same operations in the same order,
// lane by lane, and so the same bits. Rare operations go lane by lane.
#ifndef MORTISE_SNIO_EXPRESSION_LANES_H
#define MORTISE_SNIO_EXPRESSION_LANES_H

#include "shared/expression.h"
#include "shared/lanes.h"

#if LANES == 8

MORTISE_REDUCED_SINE_AND_COSINE(static, double8, sin_reduced_lanes, cos_reduced_lanes)

// expression_sin(x, 0) and expression_sin(x, 1).
static void sin_cos_lanes(double8 x, double8* sine, double8* cosine) {
    const double8 k = rint(x * 0.63661977236758134308);
    // The last two bits of the integer k, which |x| < 1e9 leaves small.
    const long8 quarter = as_long8(k + 6755399441055744.0);
    const long8 odd = (quarter & 1) != 0;
    const long8 is_number = fabs(x) < 1e9;
    double8 r = x - k * 1.5707963267341256142;
    r = r - k * 6.0771005063039659765e-11;
    r = r - k * 2.0222662487959505e-21;
    const double8 s = sin_reduced_lanes(r);
    const double8 c = cos_reduced_lanes(r);
    const double8 first = select(s, c, odd);
    const double8 second = select(c, s, odd);
    *sine = select((double8)NAN, select(first, -first, (quarter & 2) != 0), is_number);
    *cosine = select((double8)NAN, select(second, -second, ((quarter + 1) & 2) != 0), is_number);
}

// Value of an operation, and its derivatives by the arguments.
static double8 apply_lanes(int operation, double8 a, double8 b, double8* by_a, double8* by_b) {
    double8 value;
    *by_a = 0;
    *by_b = 0;
    switch (operation) {
        case kExprNegate: *by_a = -1; return -a;
        case kExprAbs: *by_a = select((double8)1, (double8)-1, a < 0); return fabs(a);
        case kExprSqrt:
            value = select((double8)NAN, sqrt(a), a >= 0);
            *by_a = select((double8)0, 0.5 / value, value > 0);
            return value;
        case kExprSquare: *by_a = 2 * a; return a * a;
        case kExprAdd:
            *by_a = 1;
            *by_b = 1;
            return a + b;
        case kExprSubtract:
            *by_a = 1;
            *by_b = -1;
            return a - b;
        case kExprMultiply:
            *by_a = b;
            *by_b = a;
            return a * b;
        case kExprDivide:
            value = a / b;
            *by_a = 1 / b;
            *by_b = -value / b;
            return value;
        case kExprMin:
            *by_a = select((double8)0, (double8)1, a < b);
            *by_b = 1 - *by_a;
            return select(b, a, (a != a) | (a < b));
        case kExprMax:
            *by_a = select((double8)0, (double8)1, a > b);
            *by_b = 1 - *by_a;
            return select(b, a, (a != a) | (a > b));
        case kExprSin: sin_cos_lanes(a, &value, by_a); return value;
        case kExprCos:
            sin_cos_lanes(a, by_a, &value);
            *by_a = -*by_a;
            return value;
        default: break;
    }
    for (uint lane = 0; lane < kLanes; ++lane) {
        const double x = get_lane(&a, lane);
        const double y = get_lane(&b, lane);
        const double f = expression_apply(operation, x, y);
        double by_x;
        double by_y;
        expression_slopes(operation, x, y, f, &by_x, &by_y);
        set_lane(&value, lane, f);
        set_lane(by_a, lane, by_x);
        set_lane(by_b, lane, by_y);
    }
    return value;
}

// Value, and gradient with respect to u.
MORTISE_NOINLINE double8 expression_sample_lanes(__global const ExpressionOp* ops, uint count,
                                                 const double8* u, double8* gradient) {
    double8 r[kExpressionRegisters + 1];
    double8 d[kExpressionRegisters + 1][3];
    r[0] = 0;
    for (int j = 0; j < 3; ++j) d[0][j] = d[kExpressionLiteral][j] = 0;
    for (uint i = 0; i < count; ++i) {
        const int operation = ops[i].operation;
        const uint out = ops[i].out;
        if (operation <= kExprZ) {
            r[out] = operation == kExprConstant ? (double8)ops[i].literal : u[operation - kExprX];
            for (int j = 0; j < 3; ++j) d[out][j] = (operation == kExprX + j) ? 1 : 0;
            continue;
        }
        r[kExpressionLiteral] = ops[i].literal;
        const uint a = ops[i].a;
        const uint b = ops[i].b;
        double8 by_a;
        double8 by_b;
        const double8 value = apply_lanes(operation, r[a], r[b], &by_a, &by_b);
        for (int j = 0; j < 3; ++j) {
            const double8 da = d[a][j];
            const double8 db = d[b][j];
            d[out][j] = select((double8)0, by_a * da, (by_a != 0) & (da != 0)) +
                        select((double8)0, by_b * db, (by_b != 0) & (db != 0));
        }
        r[out] = value;
    }
    for (int j = 0; j < 3; ++j) gradient[j] = d[0][j];
    return r[0];
}

#endif
#endif
