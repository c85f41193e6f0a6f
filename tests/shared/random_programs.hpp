// Random register programs for the tests of expressions, and the comparison of a gradient with differences.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/shared/expression.h"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {

/// A program of `length` operations whose result is in register 0. `smooth`: without kinks and jumps.
inline std::vector<ExpressionOp> random_program(RandomSource& random, int length, bool smooth) {
    std::vector<ExpressionOp> ops = {{kExprX, 1, 0, 0, 0}, {kExprY, 2, 0, 0, 0}, {kExprZ, 3, 0, 0, 0}};
    u32 top = 4;
    const auto place = [&] {
        return random.chance(0.1) ? kExpressionLiteral
                                  : static_cast<u32>(random.integer(1, static_cast<int>(top) - 1));
    };
    while (static_cast<int>(ops.size()) < length || top == 4) {
        int operation = random.integer(kExprConstant, kExprOperations - 1);
        if (operation >= kExprX && operation <= kExprZ) operation = kExprConstant;
        const bool kinks = operation == kExprAbs || operation == kExprMin || operation == kExprMax ||
                           (operation >= kExprFloor && operation <= kExprOr);
        if (smooth && kinks) continue;
        ops.push_back({operation, top, place(), place(), random.uniform(-3, 3)});
        if (top + 1 < kExpressionRegisters) ++top;
    }
    ops.back().out = 0;
    return ops;
}

/// Steps: differences of values say nothing of slopes.
inline bool has_steps(const std::vector<ExpressionOp>& ops) {
    return std::any_of(ops.begin(), ops.end(), [](const ExpressionOp& op) {
        return op.operation >= kExprFloor && op.operation <= kExprOr;
    });
}

/// Compares expression_sample with expression_value and its differences of two step widths; where these
/// disagree (near a pole or a kink), and where a value on the way overflows, nothing is compared and the
/// result is false.
inline bool check_gradient(const std::vector<ExpressionOp>& ops, const double* u, double tolerance) {
    const u32 count = static_cast<u32>(ops.size());
    double gradient[3];
    const double sampled = expression_sample(ops.data(), count, u, gradient);
    const double value = expression_value(ops.data(), count, u);
    if (std::isnan(value)) return false;
    CHECK(sampled == value);
    bool compared = false;
    for (int j = 0; j < 3; ++j) {
        double slope[2];
        for (int k = 0; k < 2; ++k) {
            const double h = k == 0 ? 1e-5 : 5e-6;
            double low[3] = {u[0], u[1], u[2]};
            double high[3] = {u[0], u[1], u[2]};
            low[j] -= h;
            high[j] += h;
            slope[k] =
                (expression_value(ops.data(), count, high) - expression_value(ops.data(), count, low)) /
                (2 * h);
        }
        const double size = std::max({1.0, std::fabs(slope[0]), std::fabs(value)});
        if (!(std::fabs(slope[0] - slope[1]) < 0.1 * tolerance * size)) continue;
        if (!std::isfinite(gradient[j])) continue;
        CHECK(std::fabs(gradient[j] - slope[1]) < tolerance * size);
        compared = true;
    }
    return compared;
}

}  // namespace mortise::test
