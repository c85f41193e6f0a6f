// Elementary functions of formulas against libm in extended precision.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/common/constants.hpp"
#include "kernels/shared/expression.h"
#include "tests/mesher/random_source.hpp"

using mortise::test::RandomSource;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double relative(double found, long double expected) {
    if (static_cast<double>(expected) == found) return 0;
    return static_cast<double>(std::fabs((static_cast<long double>(found) - expected) / expected));
}

/// A number of any size and sign.
double any(RandomSource& random, double smallest, double largest) {
    const double size = std::pow(10.0, random.uniform(smallest, largest));
    return random.chance(0.5) ? size : -size;
}

}  // namespace

TEST_CASE("tan and inverse functions agree with libm to a relative 1e-14") {
    RandomSource random(71);
    double worst[4] = {0, 0, 0, 0};
    for (int i = 0; i < 200000; ++i) {
        double x = any(random, -12, 6);
        if (i % 4 == 0) x = std::rint(x) * 1.5707963267948966;
        if (std::fabs(x) < 1e6)
            worst[0] = std::max(worst[0], relative(expression_tan(x), std::tan(static_cast<long double>(x))));
        const double y = any(random, -300, 300);
        worst[1] = std::max(worst[1], relative(expression_atan(y), std::atan(static_cast<long double>(y))));
        const double near = any(random, -16, 0.4);
        worst[1] =
            std::max(worst[1], relative(expression_atan(near), std::atan(static_cast<long double>(near))));
        double sine = i % 3 == 0 ? any(random, -18, 0) : random.uniform(-1, 1);
        if (i % 5 == 0) sine = std::copysign(1 - std::pow(10.0, random.uniform(-16, 0)), sine);
        worst[2] =
            std::max(worst[2], relative(expression_asin(sine), std::asin(static_cast<long double>(sine))));
        worst[3] =
            std::max(worst[3], relative(expression_acos(sine), std::acos(static_cast<long double>(sine))));
    }
    for (const double error : worst) CHECK(error < 1e-14);
    CHECK(expression_atan(mortise::kInfinity) == std::atan(mortise::kInfinity));
    CHECK(expression_asin(1) == std::asin(1.0));
    CHECK(expression_acos(1) == 0);
    CHECK(expression_acos(-1) == std::acos(-1.0));
    for (const double bad : {1.0000001, -2.0, mortise::kInfinity, kNan}) {
        CHECK(std::isnan(expression_asin(bad)));
        CHECK(std::isnan(expression_acos(bad)));
    }
    for (const double bad : {mortise::kInfinity, 1e12, kNan}) CHECK(std::isnan(expression_tan(bad)));
}

TEST_CASE("atan2 and hypot agree with libm to a relative 1e-14, in all quadrants and on the axes") {
    RandomSource random(72);
    double worst[2] = {0, 0};
    for (int i = 0; i < 200000; ++i) {
        const double spread = i % 2 == 0 ? 2 : 140;
        const double y = i % 17 == 0 ? 0 : any(random, -spread, spread);
        const double x = i % 19 == 0 ? 0 : any(random, -spread, spread);
        worst[0] = std::max(worst[0],
                            relative(expression_atan2(y, x),
                                     std::atan2(static_cast<long double>(y), static_cast<long double>(x))));
        worst[1] = std::max(worst[1],
                            relative(expression_hypot(y, x),
                                     std::hypot(static_cast<long double>(y), static_cast<long double>(x))));
    }
    for (const double error : worst) CHECK(error < 1e-14);
    CHECK(expression_atan2(0, 0) == 0);
    CHECK(expression_atan2(0, -1) == std::acos(-1.0));
    CHECK(expression_atan2(-0.0, -1) == std::acos(-1.0));  // zeros have no sign
    CHECK(expression_atan2(-1e-300, -1) == -std::acos(-1.0));
    CHECK(expression_atan2(mortise::kInfinity, mortise::kInfinity) == std::atan(1.0));
    CHECK(std::isnan(expression_atan2(kNan, 1)));
    CHECK(expression_hypot(1e300, 1e300) == doctest::Approx(std::sqrt(2.0) * 1e300));
    CHECK(expression_hypot(mortise::kInfinity, 1) == mortise::kInfinity);
}

TEST_CASE("power agrees with libm to a relative 1e-14 wherever the result is normal") {
    RandomSource random(73);
    double worst = 0;
    int compared = 0;
    for (int i = 0; i < 300000; ++i) {
        const double a = i % 3 == 0 ? std::fabs(any(random, -300, 300)) : random.uniform(0.01, 3);
        double b = any(random, -3, i % 3 == 1 ? 5 : 1);
        if (i % 7 == 0) b = std::rint(b);
        const long double expected = std::pow(static_cast<long double>(a), static_cast<long double>(b));
        if (!(expected < 1e307L) || !(expected > 1e-300L)) continue;
        worst = std::max(worst, relative(expression_power(a, b), expected));
        ++compared;
    }
    CHECK(compared > 100000);
    CHECK(worst < 1e-14);
    CHECK(expression_power(-2, 3) == -8);
    CHECK(expression_power(-2, 2) == 4);
    CHECK(std::isnan(expression_power(-2, 0.5)));
    CHECK(expression_power(0, 2) == 0);
    CHECK(expression_power(0, -1) == mortise::kInfinity);
    CHECK(expression_power(5, 0) == 1);
    CHECK(expression_power(2, 1e300) == mortise::kInfinity);
    CHECK(expression_power(0.5, 1e300) == 0);
    CHECK(expression_power(mortise::kInfinity, -1) == 0);
    CHECK(std::isnan(expression_power(kNan, 0)));
}

TEST_CASE("exp is good to a relative 1e-14 over its whole range") {
    RandomSource random(74);
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
        const double x = random.uniform(-690, 709);
        worst = std::max(worst, relative(expression_exp(x), std::exp(static_cast<long double>(x))));
    }
    CHECK(worst < 1e-14);
}

TEST_CASE("mod is the exact remainder of the division that rounds down") {
    RandomSource random(75);
    for (int i = 0; i < 200000; ++i) {
        const double a = i % 2 == 0 ? any(random, -6, 9) : static_cast<double>(random.integer(-1000, 1000));
        const double b = i % 4 < 2 ? any(random, -3, 3) : static_cast<double>(random.integer(1, 12)) / 4;
        long double expected = std::fmod(static_cast<long double>(a), static_cast<long double>(b));
        if (expected < 0) expected += std::fabs(static_cast<long double>(b));
        const double found = expression_mod(a, b);
        CAPTURE(a);
        CAPTURE(b);
        REQUIRE(found >= 0);
        REQUIRE(found < std::fabs(b));
        const double error = static_cast<double>(std::fabs(found - expected));
        // A remainder that rounds to |b| starts anew.
        REQUIRE((error <= 1e-15 * std::fabs(b) || error >= std::fabs(b) * (1 - 1e-15)));
    }
    CHECK(expression_mod(-1, 3) == 2);
    CHECK(expression_mod(7, -3) == 1);
    for (const double bad : {0.0, kNan}) CHECK(std::isnan(expression_mod(1, bad)));
    CHECK(std::isnan(expression_mod(1e300, 1)));
}

TEST_CASE("steps and logic have the meaning that .vm gives them") {
    CHECK(expression_apply(kExprRound, 2.5, 0) == 3);
    CHECK(expression_apply(kExprRound, -2.5, 0) == -3);
    CHECK(expression_apply(kExprRound, 0.49999999999999994, 0) == 0);
    CHECK(expression_apply(kExprFloor, -0.5, 0) == -1);
    CHECK(expression_apply(kExprCeil, -0.5, 0) == 0);
    CHECK(expression_apply(kExprSign, -3, 0) == -1);
    CHECK(expression_apply(kExprSign, 0, 0) == 0);
    CHECK(expression_apply(kExprCompare, 1, 2) == -1);
    CHECK(expression_apply(kExprCompare, 2, 2) == 0);
    CHECK(expression_apply(kExprNot, 0, 0) == 1);
    CHECK(expression_apply(kExprNot, 0.1, 0) == 0);
    CHECK(expression_apply(kExprAnd, 3, 7) == 7);
    CHECK(expression_apply(kExprOr, 3, 7) == 3);
    CHECK(expression_apply(kExprOr, 0, 7) == 7);
}
