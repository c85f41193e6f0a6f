// General expressions: a register program over doubles, with first derivatives by dual numbers.
//
// Registers are allocated by the compiler; a program leaves its result in register 0. sin, cos, exp and log
// are our own sequences of correctly rounded operations, because the ones of OpenCL differ between devices
// and no sign may depend on the device (opencl.md, decision 7). Their error is below 1e-14 relative to 1 for
// |x| < 1e6.
#ifndef MORTISE_SHARED_EXPRESSION_H
#define MORTISE_SHARED_EXPRESSION_H

#include "platform.h"

// Operations. Append-only.
#define kExprConstant 0
#define kExprX 1
#define kExprY 2
#define kExprZ 3
#define kExprNegate 4
#define kExprAbs 5
#define kExprSqrt 6
#define kExprSquare 7
#define kExprAdd 8
#define kExprSubtract 9
#define kExprMultiply 10
#define kExprDivide 11
#define kExprMin 12
#define kExprMax 13
#define kExprSin 14
#define kExprCos 15
#define kExprExp 16
#define kExprLog 17

#define kExpressionRegisters 64

typedef struct ExpressionOp {
    i32 operation;
    u32 out;
    u32 a;
    u32 b;
    double literal;
} ExpressionOp;

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define mortise_bits(x) as_long(x)
#define mortise_from_bits(x) as_double(x)
#define kMortiseInfinity INFINITY
#define kMortiseNan NAN
#else
#include <cstring>
#include <limits>
inline i64 mortise_bits(double x) {
    i64 bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}
inline double mortise_from_bits(i64 bits) {
    double x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}
inline constexpr double kMortiseInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kMortiseNan = std::numeric_limits<double>::quiet_NaN();
#endif

// sin(r) and cos(r) for |r| <= π/4 by their Taylor series.
MORTISE_FUNCTION double sin_reduced(double r) {
    const double s = r * r;
    double p = -1.0 / 121645100408832000.0;
    p = p * s + 1.0 / 355687428096000.0;
    p = p * s - 1.0 / 1307674368000.0;
    p = p * s + 1.0 / 6227020800.0;
    p = p * s - 1.0 / 39916800.0;
    p = p * s + 1.0 / 362880.0;
    p = p * s - 1.0 / 5040.0;
    p = p * s + 1.0 / 120.0;
    p = p * s - 1.0 / 6.0;
    return r + r * s * p;
}
MORTISE_FUNCTION double cos_reduced(double r) {
    const double s = r * r;
    double p = 1.0 / 2432902008176640000.0;
    p = p * s - 1.0 / 6402373705728000.0;
    p = p * s + 1.0 / 20922789888000.0;
    p = p * s - 1.0 / 87178291200.0;
    p = p * s + 1.0 / 479001600.0;
    p = p * s - 1.0 / 3628800.0;
    p = p * s + 1.0 / 40320.0;
    p = p * s - 1.0 / 720.0;
    p = p * s + 1.0 / 24.0;
    return 1.0 - 0.5 * s + s * s * p;
}

// sin(x + quarter·π/2), with π/2 in three parts (Cody and Waite).
MORTISE_FUNCTION double expression_sin(double x, i32 quarter) {
    const double k = mortise_rint(x * 0.63661977236758134308);
    double r;
    i32 q;
    if (!(mortise_fabs(x) < 1e9)) return kMortiseNan;
    r = x - k * 1.5707963267341256142;
    r = r - k * 6.0771005063039659765e-11;
    r = r - k * 2.0222662487959505e-21;
    q = ((i32)(i64)k + quarter) & 3;
    if (q == 0) return sin_reduced(r);
    if (q == 1) return cos_reduced(r);
    if (q == 2) return -sin_reduced(r);
    return -cos_reduced(r);
}

MORTISE_FUNCTION double expression_exp(double x) {
    double k;
    double r;
    double p = 1;
    if (x != x) return x;
    if (x > 709.0) return kMortiseInfinity;
    if (x < -708.0) return 0;
    k = mortise_rint(x * 1.4426950408889634074);
    r = x - k * 0.693147180369123816490;
    r = r - k * 1.90821492927058770002e-10;
    for (i32 n = 14; n > 0; --n) p = 1.0 + r * p / (double)n;
    return p * mortise_from_bits(((i64)k + 1023) << 52);
}

MORTISE_FUNCTION double expression_log(double x) {
    i64 bits;
    i64 exponent;
    double m;
    double s;
    double square;
    double p = 0;
    if (!(x > 0)) return x == 0 ? -kMortiseInfinity : kMortiseNan;
    if (x > 1.7e308) return kMortiseInfinity;
    if (x < 2.3e-308) return -kMortiseInfinity;
    bits = mortise_bits(x);
    exponent = ((bits >> 52) & 0x7ff) - 1023;
    m = mortise_from_bits((bits & 0xfffffffffffffL) | 0x3ff0000000000000L);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        exponent += 1;
    }
    s = (m - 1) / (m + 1);
    square = s * s;
    for (i32 n = 23; n > 0; n -= 2) p = p * square + 1.0 / (double)n;
    return (double)exponent * 0.69314718055994530942 + 2 * s * p;
}

// Result of one operation; NaN arguments give NaN through every operation, min and max too.
MORTISE_FUNCTION double expression_apply(i32 operation, double a, double b) {
    switch (operation) {
        case kExprNegate: return -a;
        case kExprAbs: return mortise_fabs(a);
        case kExprSqrt: return a >= 0 ? mortise_sqrt(a) : kMortiseNan;
        case kExprSquare: return a * a;
        case kExprAdd: return a + b;
        case kExprSubtract: return a - b;
        case kExprMultiply: return a * b;
        case kExprDivide: return a / b;
        case kExprMin: return (a != a || a < b) ? a : b;
        case kExprMax: return (a != a || a > b) ? a : b;
        case kExprSin: return expression_sin(a, 0);
        case kExprCos: return expression_sin(a, 1);
        case kExprExp: return expression_exp(a);
        default: return expression_log(a);
    }
}

MORTISE_FUNCTION double expression_value(MORTISE_GLOBAL ExpressionOp* ops, u32 count, const double* u) {
    double r[kExpressionRegisters];
    r[0] = 0;
    for (u32 i = 0; i < count; ++i) {
        const i32 operation = ops[i].operation;
        if (operation == kExprConstant) {
            r[ops[i].out] = ops[i].literal;
        } else if (operation <= kExprZ) {
            r[ops[i].out] = u[operation - kExprX];
        } else {
            r[ops[i].out] = expression_apply(operation, r[ops[i].a], r[ops[i].b]);
        }
    }
    return r[0];
}

// Value, and gradient with respect to u, by forward differentiation.
MORTISE_FUNCTION double expression_sample(MORTISE_GLOBAL ExpressionOp* ops, u32 count, const double* u,
                                          double* gradient) {
    double r[kExpressionRegisters];
    double d[kExpressionRegisters][3];
    r[0] = 0;
    for (int j = 0; j < 3; ++j) d[0][j] = 0;
    for (u32 i = 0; i < count; ++i) {
        const i32 operation = ops[i].operation;
        const u32 out = ops[i].out;
        if (operation <= kExprZ) {
            r[out] = operation == kExprConstant ? ops[i].literal : u[operation - kExprX];
            for (int j = 0; j < 3; ++j) d[out][j] = (operation == kExprX + j) ? 1 : 0;
            continue;
        }
        {
            const double a = r[ops[i].a];
            const double b = r[ops[i].b];
            const double value = expression_apply(operation, a, b);
            double by_a = 0;
            double by_b = 0;
            switch (operation) {
                case kExprNegate: by_a = -1; break;
                case kExprAbs: by_a = a < 0 ? -1 : 1; break;
                case kExprSqrt: by_a = value > 0 ? 0.5 / value : 0; break;
                case kExprSquare: by_a = 2 * a; break;
                case kExprAdd:
                    by_a = 1;
                    by_b = 1;
                    break;
                case kExprSubtract:
                    by_a = 1;
                    by_b = -1;
                    break;
                case kExprMultiply:
                    by_a = b;
                    by_b = a;
                    break;
                case kExprDivide:
                    by_a = 1 / b;
                    by_b = -value / b;
                    break;
                case kExprMin:
                    by_a = a < b ? 1 : 0;
                    by_b = 1 - by_a;
                    break;
                case kExprMax:
                    by_a = a > b ? 1 : 0;
                    by_b = 1 - by_a;
                    break;
                case kExprSin: by_a = expression_sin(a, 1); break;
                case kExprCos: by_a = -expression_sin(a, 0); break;
                case kExprExp: by_a = value; break;
                default: by_a = 1 / a; break;
            }
            for (int j = 0; j < 3; ++j) {
                const double da = d[ops[i].a][j];
                const double db = d[ops[i].b][j];
                d[out][j] = by_a * da + by_b * db;
            }
            r[out] = value;
        }
    }
    for (int j = 0; j < 3; ++j) gradient[j] = d[0][j];
    return r[0];
}

#endif
