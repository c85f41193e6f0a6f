// Elementary functions for formulas: our own sequences of correctly rounded operations, because the ones of
// OpenCL differ between devices and no sign may depend on the device.
//
// Relative error below 1e-14 (tests/shared/elementary_test.cpp), except: sin and cos, whose error is relative
// to 1, for |x| < 1e6 (they and tan are not numbers from 1e9 on); exp, power and mod where the result is
// below 1e-300. Arguments below 2.3e-308 count as 0 in log and power.
#ifndef MORTISE_SHARED_ELEMENTARY_H
#define MORTISE_SHARED_ELEMENTARY_H

#include "platform.h"

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

// Functions for sin(r) and cos(r), |r| <= π/4, by their Taylor series; Real: double, or lanes of them;
// Function: what stands before such a function.
#define MORTISE_REDUCED_SINE_AND_COSINE(Function, Real, sine, cosine)          \
    Function Real sine(Real r) {                                               \
        const Real s = r * r;                                                  \
        Real p = s * (-1.0 / 121645100408832000.0) + 1.0 / 355687428096000.0;  \
        p = p * s - 1.0 / 1307674368000.0;                                     \
        p = p * s + 1.0 / 6227020800.0;                                        \
        p = p * s - 1.0 / 39916800.0;                                          \
        p = p * s + 1.0 / 362880.0;                                            \
        p = p * s - 1.0 / 5040.0;                                              \
        p = p * s + 1.0 / 120.0;                                               \
        p = p * s - 1.0 / 6.0;                                                 \
        return r + r * s * p;                                                  \
    }                                                                          \
    Function Real cosine(Real r) {                                             \
        const Real s = r * r;                                                  \
        Real p = s * (1.0 / 2432902008176640000.0) - 1.0 / 6402373705728000.0; \
        p = p * s + 1.0 / 20922789888000.0;                                    \
        p = p * s - 1.0 / 87178291200.0;                                       \
        p = p * s + 1.0 / 479001600.0;                                         \
        p = p * s - 1.0 / 3628800.0;                                           \
        p = p * s + 1.0 / 40320.0;                                             \
        p = p * s - 1.0 / 720.0;                                               \
        p = p * s + 1.0 / 24.0;                                                \
        return 1.0 - 0.5 * s + s * s * p;                                      \
    }
MORTISE_REDUCED_SINE_AND_COSINE(MORTISE_FUNCTION, double, sin_reduced, cos_reduced)

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

MORTISE_FUNCTION double expression_tan(double x) {
    const double c = expression_sin(x, 1);
    return expression_sin(x, 0) / c;
}

// Integers next to x, exact.
MORTISE_FUNCTION double expression_round(double x) {  // halves away from zero
    const double size = mortise_fabs(x);
    double whole = mortise_floor(size);
    if (size - whole >= 0.5) whole += 1;
    return x < 0 ? -whole : whole;
}

// atan(k / 8).
MORTISE_TABLE double kAtanTable[9] = {0,
                                      0.12435499454676143503,
                                      0.24497866312686415417,
                                      0.35877067027057222040,
                                      0.46364760900080611621,
                                      0.55859931534356243597,
                                      0.64350110879328438680,
                                      0.71882999962162450542,
                                      0.78539816339744830962};

// The angle in [0, π] of the direction (x, y) for y >= 0, not both zero or not numbers.
MORTISE_FUNCTION double direction_angle(double x, double y) {
    const double across = mortise_fabs(x);
    const double least = across < y ? across : y;
    const double most = across < y ? y : across;
    const double t = least == most ? 1 : least / most;  // also where both are infinite
    const i32 k = (i32)mortise_rint(t * 8);
    const double c = (double)k * 0.125;
    const double r = (t - c) / (1 + t * c);
    const double s = r * r;
    double p = 1.0 / 15.0;
    double angle;
    p = 1.0 / 13.0 - s * p;
    p = 1.0 / 11.0 - s * p;
    p = 1.0 / 9.0 - s * p;
    p = 1.0 / 7.0 - s * p;
    p = 1.0 / 5.0 - s * p;
    p = 1.0 / 3.0 - s * p;
    angle = kAtanTable[k] + (r - r * s * p);
    if (across < y) angle = 1.5707963267948966192 - (angle - 6.123233995736766e-17);
    return x < 0 ? 3.1415926535897932385 - (angle - 1.2246467991473532e-16) : angle;
}

// In (-π, π]; 0 at the origin, π on the negative x-axis (zeros have no sign here).
MORTISE_FUNCTION double expression_atan2(double y, double x) {
    if (x != x || y != y) return kMortiseNan;
    if (x == 0 && y == 0) return 0;
    return y < 0 ? -direction_angle(x, -y) : direction_angle(x, y == 0 ? 0 : y);
}

MORTISE_FUNCTION double expression_atan(double x) { return expression_atan2(x, 1); }

MORTISE_FUNCTION double expression_asin(double x) {
    if (!(mortise_fabs(x) <= 1)) return kMortiseNan;
    return expression_atan2(x, mortise_sqrt((1 - x) * (1 + x)));
}

MORTISE_FUNCTION double expression_acos(double x) {
    if (!(mortise_fabs(x) <= 1)) return kMortiseNan;
    return expression_atan2(mortise_sqrt((1 - x) * (1 + x)), x);
}

MORTISE_FUNCTION double expression_hypot(double a, double b) {
    const double p = mortise_fabs(a);
    const double q = mortise_fabs(b);
    const double most = p > q ? p : q;
    double ratio;
    if (p != p || q != q) return kMortiseNan;
    if (most == 0 || most == kMortiseInfinity) return most;
    ratio = (p > q ? q : p) / most;
    return most * mortise_sqrt(1 + ratio * ratio);
}

// a·b = result + *error exactly (Dekker), for factors below 1e300.
MORTISE_FUNCTION double exact_product(double a, double b, double* error) {
    const double product = a * b;
    const double p = 134217729.0 * a;
    const double q = 134217729.0 * b;
    const double a_high = p - (p - a);
    const double b_high = q - (q - b);
    const double a_low = a - a_high;
    const double b_low = b - b_high;
    *error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return product;
}

// Remainder in [0, |b|) of the division that rounds down; not a number for b = 0, and where the quotient has
// more digits than a double.
MORTISE_FUNCTION double expression_mod(double a, double b) {
    const double modulus = mortise_fabs(b);
    const double quotient = mortise_floor(a / modulus);
    double error;
    double product;
    double rest;
    if (!(modulus > 0) || !(modulus < 1e300) || !(mortise_fabs(quotient) < 1e15)) return kMortiseNan;
    product = exact_product(quotient, modulus, &error);
    rest = (a - product) - error;
    if (rest < 0) rest += modulus;  // the quotient was rounded
    if (rest >= modulus) rest -= modulus;
    return rest < 0 ? 0 : rest;
}

// ln(x) = result + *low to about 1e-18, for normal x.
MORTISE_FUNCTION double log_in_two_parts(double x, double* low) {
    const i64 bits = mortise_bits(x);
    i64 exponent = ((bits >> 52) & 0x7ff) - 1023;
    double m = mortise_from_bits((bits & 0xfffffffffffffL) | 0x3ff0000000000000L);
    double below;  // 1 ... sum - sum
    double sum;    // m + 1, rounded
    double error;
    double product;
    double s;  // (m - 1) / (m + 1) = s + rest
    double rest;
    double square;
    double p = 0;
    double high;
    double whole;
    double total;
    if (m > 1.4142135623730951) {
        m *= 0.5;
        exponent += 1;
    }
    sum = m + 1;
    below = m - (sum - 1);
    s = (m - 1) / sum;
    product = exact_product(s, sum, &error);
    rest = (((m - 1) - product) - error - s * below) / sum;
    square = s * s;
    for (i32 n = 23; n > 1; n -= 2) p = p * square + 1.0 / (double)n;
    // ln 2 in two parts, the first of 32 bits: its product is exact.
    whole = (double)exponent * 6.93147180369123816490e-01;
    high = whole + 2 * s;
    // The larger summand is the whole part, or that is zero.
    *low = (2 * s - (high - whole)) +
           (2 * s * square * p + 2 * rest * (1 + square) + (double)exponent * 1.90821492927058770002e-10);
    total = high + *low;
    *low -= total - high;
    return total;
}

// a^b: for a < 0 only if b is an integer.
MORTISE_FUNCTION double expression_power(double a, double b) {
    const double size = mortise_fabs(a);
    const int whole = mortise_rint(b) == b;
    double result;
    if (a != a || b != b || (a < 0 && !whole)) return kMortiseNan;
    if (b == 0 || a == 1) return 1;
    if (size < 2.3e-308) {
        result = b > 0 ? 0 : kMortiseInfinity;
    } else if (size > 1.7e308) {
        result = b > 0 ? kMortiseInfinity : 0;
    } else if (!(mortise_fabs(b) < 1e20)) {
        result = size == 1 ? 1 : ((size > 1) == (b > 0) ? kMortiseInfinity : 0);
    } else {
        double low;
        double error;
        const double high = log_in_two_parts(size, &low);
        const double product = exact_product(high, b, &error);
        result = expression_exp(product);
        if (result > 0 && result < kMortiseInfinity) result += result * (error + b * low);
    }
    if (a < 0 && mortise_rint(b * 0.5) != b * 0.5) return -result;
    return result;
}

#endif
