// Expression programs: elementary functions against libm, derivatives against central differences.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/common/constants.hpp"
#include "kernels/shared/expression.h"
#include "tests/mesher/random_source.hpp"
#include "tests/shared/random_programs.hpp"

using mortise::test::RandomSource;

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("sin and cos agree with libm to 1e-14 for arguments up to 1e6") {
    RandomSource random(11);
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
        const double size = std::pow(10.0, random.uniform(-8, 6));
        double x = random.uniform(-size, size);
        if (i % 4 == 0) x = std::rint(x) * 1.5707963267948966;  // where sin or cos vanish
        if (std::fabs(x) > 1e6) continue;
        worst = std::max(worst, std::fabs(expression_sin(x, 0) - std::sin(x)));
        worst = std::max(worst, std::fabs(expression_sin(x, 1) - std::cos(x)));
    }
    CHECK(worst < 1e-14);
    CHECK(expression_sin(0, 0) == 0);
    CHECK(expression_sin(0, 1) == 1);
    for (const double bad : {kNotANumber, mortise::kInfinity, -mortise::kInfinity, 1e12})
        CHECK(std::isnan(expression_sin(bad, 0)));
}

TEST_CASE("exp agrees with libm to a relative 1e-14 and saturates") {
    RandomSource random(12);
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
        const double x = i % 2 == 0 ? random.uniform(-708, 709) : random.uniform(-2, 2);
        worst = std::max(worst, std::fabs(expression_exp(x) / std::exp(x) - 1));
    }
    CHECK(worst < 1e-13);
    double near_one = 0;
    for (int i = 0; i < 100000; ++i) {
        const double x = random.uniform(-10, 10);
        near_one = std::max(near_one, std::fabs(expression_exp(x) / std::exp(x) - 1));
    }
    CHECK(near_one < 1e-14);
    CHECK(expression_exp(0) == 1);
    CHECK(expression_exp(1000) == mortise::kInfinity);
    CHECK(expression_exp(mortise::kInfinity) == mortise::kInfinity);
    CHECK(expression_exp(-mortise::kInfinity) == 0);
    CHECK(std::isnan(expression_exp(kNotANumber)));
}

TEST_CASE("log agrees with libm to 1e-14 and has the right poles") {
    RandomSource random(13);
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
        const double x = i % 2 == 0 ? std::exp(random.uniform(-700, 700)) : random.uniform(0.5, 2);
        const double expected = std::log(x);
        worst = std::max(worst, std::fabs(expression_log(x) - expected) / std::max(1.0, std::fabs(expected)));
    }
    CHECK(worst < 1e-14);
    CHECK(expression_log(1) == 0);
    CHECK(expression_log(0) == -mortise::kInfinity);
    CHECK(expression_log(mortise::kInfinity) == mortise::kInfinity);
    CHECK(std::isnan(expression_log(-1)));
    CHECK(std::isnan(expression_log(kNotANumber)));
}

TEST_CASE("not-a-number passes through every operation") {
    for (int operation = kExprNegate; operation < kExprOperations; ++operation) {
        CAPTURE(operation);
        CHECK(std::isnan(expression_apply(operation, kNotANumber, kNotANumber)));
        CHECK(std::isnan(expression_apply(operation, kNotANumber, 1)));
        if (expression_is_binary(operation) && operation != kExprOr) {
            CHECK(std::isnan(expression_apply(operation, 1, kNotANumber)));
        }
    }
    CHECK(expression_apply(kExprAnd, 0, kNotANumber) == 0);  // not taken
    CHECK(expression_apply(kExprOr, 1, kNotANumber) == 1);
    CHECK(std::isnan(expression_apply(kExprOr, 0, kNotANumber)));
    CHECK(std::isnan(expression_apply(kExprSqrt, -1, 0)));
    CHECK(expression_apply(kExprMin, 2, 3) == 2);
    CHECK(expression_apply(kExprMax, 2, 3) == 3);
}

TEST_CASE("derivatives of each operation agree with central differences") {
    RandomSource random(14);
    for (int operation = kExprNegate; operation < kExprOperations; ++operation) {
        const bool binary = expression_is_binary(operation) != 0;
        // operation(2x + y, z - x): every argument depends on two coordinates.
        std::vector<ExpressionOp> ops = {{kExprX, 1, 0, 0, 0},   {kExprY, 2, 0, 0, 0},
                                         {kExprZ, 3, 0, 0, 0},   {kExprAdd, 4, 1, 1, 0},
                                         {kExprAdd, 4, 4, 2, 0}, {kExprSubtract, 5, 3, 1, 0}};
        ops.push_back({operation, 0, 4, binary ? 5u : 4u, 0});
        int compared = 0;
        for (int i = 0; i < 2000; ++i) {
            const double u[3] = {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
            const double a = 2 * u[0] + u[1];
            const double b = u[2] - u[0];
            const bool needs_positive =
                operation == kExprSqrt || operation == kExprLog || operation == kExprPower;
            if (needs_positive && a < 0.05) continue;
            if ((operation == kExprAsin || operation == kExprAcos) && std::fabs(a) > 0.95) continue;
            if (operation == kExprTan && std::fabs(std::cos(a)) < 0.1) continue;
            if (operation == kExprAtan2 && (std::hypot(a, b) < 0.1 || (b < 0 && std::fabs(a) < 1e-3)))
                continue;
            if (operation == kExprHypot && std::hypot(a, b) < 0.1) continue;
            if (operation >= kExprFloor && operation <= kExprRound &&
                std::fabs(2 * a - std::rint(2 * a)) < 1e-3)
                continue;
            if ((operation == kExprSign || operation == kExprNot || operation == kExprAnd ||
                 operation == kExprOr) &&
                std::fabs(a) < 1e-3)
                continue;
            if (operation == kExprCompare && std::fabs(a - b) < 1e-3) continue;
            if (operation == kExprMod &&
                (std::fabs(b) < 0.05 || std::fabs(a / b - std::rint(a / b)) < 1e-2 / std::fabs(b)))
                continue;
            if (operation == kExprAbs && std::fabs(a) < 1e-3) continue;
            if (operation == kExprDivide && std::fabs(b) < 0.05) continue;
            if ((operation == kExprMin || operation == kExprMax) && std::fabs(a - b) < 1e-3) continue;
            mortise::test::check_gradient(ops, u, 1e-5);
            ++compared;
        }
        CHECK(compared > 200);
    }
}

TEST_CASE("derivatives of random programs agree with central differences") {
    RandomSource random(15);
    int compared = 0;
    for (int i = 0; i < 4000; ++i) {
        const auto ops = mortise::test::random_program(random, random.integer(4, 20), true);
        const double u[3] = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        const double value = expression_value(ops.data(), static_cast<u32>(ops.size()), u);
        if (!(std::fabs(value) < 1e3)) continue;
        compared += mortise::test::check_gradient(ops, u, 1e-4) ? 1 : 0;
    }
    CHECK(compared > 1500);
}

TEST_CASE("an infinite slope at what does not change is no slope") {
    // acos(min(x, 1)) + y, acos(max(x, -1)) + y.
    for (const double bound : {1.0, -1.0}) {
        const std::vector<ExpressionOp> ops = {
            {kExprX, 1, 0, 0, 0},
            {bound > 0 ? kExprMin : kExprMax, 1, 1, kExpressionLiteral, bound},
            {kExprAcos, 1, 1, 0, 0},
            {kExprY, 2, 0, 0, 0},
            {kExprAdd, 0, 1, 2, 0}};
        const double u[3] = {3 * bound, 0.25, 0};
        double gradient[3];
        CHECK(expression_sample(ops.data(), static_cast<u32>(ops.size()), u, gradient) ==
              doctest::Approx(bound > 0 ? 0.25 : 3.14159265358979 + 0.25));
        CHECK(gradient[0] == 0);
        CHECK(gradient[1] == 1);
        CHECK(gradient[2] == 0);
    }
}

TEST_CASE("a program may use every register") {
    // x in all registers, added up from the last to the first.
    std::vector<ExpressionOp> ops;
    for (u32 r = 1; r < kExpressionRegisters; ++r) ops.push_back({kExprX, r, 0, 0, 0});
    for (u32 r = kExpressionRegisters - 1; r > 1; --r) ops.push_back({kExprAdd, r - 1, r - 1, r, 0});
    ops.push_back({kExprNegate, 0, 1, 1, 0});
    const double u[3] = {0.5, 7, 9};
    double gradient[3];
    CHECK(expression_sample(ops.data(), static_cast<u32>(ops.size()), u, gradient) ==
          -0.5 * (kExpressionRegisters - 1));
    CHECK(gradient[0] == -(kExpressionRegisters - 1));
    CHECK(gradient[1] == 0);
    CHECK(gradient[2] == 0);
}
