// Interval arithmetic of expressions: every result must hold all values over the argument intervals, also
// where values overflow or are not numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "kernels/shared/expression_bounds.h"
#include "tests/mesher/random_source.hpp"
#include "tests/shared/random_programs.hpp"

using mortise::test::RandomSource;

namespace {

constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

/// A value that is not a number is held only by bounds that allow for it.
bool holds(const Interval& interval, double value) {
    if (std::isnan(value)) return interval.partial != 0;
    return value >= interval.low && value <= interval.high;
}

/// Boxes per operation: 1e5, or what MORTISE_LONG_TESTS says (10000000 for a run of minutes).
int box_count() {
    const char* text = std::getenv("MORTISE_LONG_TESTS");
    return text == nullptr ? 100000 : std::max(100000, std::atoi(text));
}

float random_end(RandomSource& random) {
    const double chance = random.uniform(0, 1);
    if (chance < 0.1) return 0;
    if (chance < 0.2) return static_cast<float>(random.integer(-3, 3));
    if (chance < 0.6) return static_cast<float>(random.uniform(-4, 4));
    const float size = static_cast<float>(std::pow(10.0, random.uniform(-44, 38)));
    return random.chance(0.5) ? size : -size;
}

Interval random_interval(RandomSource& random) {
    float low = random_end(random);
    float high = random.chance(0.4)   ? static_cast<float>(low * (1 + std::pow(10.0, random.uniform(-7, 0))))
                 : random.chance(0.2) ? low
                                      : random_end(random);
    if (random.chance(0.02)) high = kFloatInfinity;
    if (random.chance(0.02)) low = -kFloatInfinity;
    if (low > high) std::swap(low, high);
    return {low, high};
}

double random_member(RandomSource& random, const Interval& interval) {
    const double low = std::max(static_cast<double>(interval.low), -1e300);
    const double high = std::min(static_cast<double>(interval.high), 1e300);
    const double chance = random.uniform(0, 1);
    if (chance < 0.2) return low;
    if (chance < 0.4) return high;
    if (chance < 0.5 && low <= 0 && high >= 0) return 0;
    return std::min(high, std::max(low, low + (high - low) * random.uniform(0, 1)));
}

}  // namespace

TEST_CASE("each interval operation holds the values of its members, over 1e5 boxes each") {
    const int boxes = box_count();
    for (int operation = kExprNegate; operation < kExprOperations; ++operation) {
        RandomSource random(static_cast<std::uint64_t>(operation) + 100);
        int wrong = 0;
        int decided = 0;
        std::string first;
        for (int i = 0; i < boxes; ++i) {
            const Interval a = random_interval(random);
            const Interval b = random_interval(random);
            const Interval result = interval_apply(operation, a, b);
            decided += interval_sign(result) != 0;
            for (int k = 0; k < 4; ++k) {
                const double x = random_member(random, a);
                const double y = random_member(random, b);
                const double value = expression_apply(operation, x, y);
                if (holds(result, value)) continue;
                if (wrong++ == 0) {
                    char text[240];
                    std::snprintf(text, sizeof text,
                                  "operation %d on [%.9g, %.9g], [%.9g, %.9g]: [%.9g, %.9g] lacks f(%.17g, "
                                  "%.17g) = %.17g",
                                  operation, a.low, a.high, b.low, b.high, result.low, result.high, x, y,
                                  value);
                    first = text;
                }
            }
        }
        INFO(first);
        CHECK(wrong == 0);
        CHECK(decided > 5000);  // bounds that decide nothing would hold everything
    }
}

TEST_CASE("bounds are not much wider than the range") {
    // Ends of monotone operations on moderate arguments are the values at the ends, up to float rounding.
    RandomSource random(31);
    for (int i = 0; i < 20000; ++i) {
        const float low = static_cast<float>(random.uniform(0.01, 3));
        const Interval a = {low, low + static_cast<float>(random.uniform(0, 1))};
        for (const int operation : {kExprSqrt, kExprSquare, kExprExp, kExprLog, kExprAbs}) {
            const Interval result = interval_apply(operation, a, a);
            const double at_low = expression_apply(operation, a.low, 0);
            const double at_high = expression_apply(operation, a.high, 0);
            REQUIRE(at_low - result.low <= 1e-6 * (1e-30 + std::fabs(at_low)));
            REQUIRE(result.high - at_high <= 1e-6 * (1e-30 + std::fabs(at_high)));
        }
        const Interval sine = interval_apply(kExprSin, a, a);
        REQUIRE(sine.high <= 1.000001f);
        if (a.high < 1.57f) REQUIRE(sine.high <= std::sin(a.high) + 1e-6);
    }
}

TEST_CASE("roots of negatives and quotients across zero decide nothing") {
    for (const int operation : {kExprSqrt, kExprLog}) {
        const Interval result = interval_apply(operation, {-1, 2}, {0, 0});
        CHECK(result.partial != 0);
        CHECK(interval_sign(interval_apply(kExprSubtract, result, {9, 9})) == 0);  // inside or no number
        CHECK(interval_apply(operation, {-1, 2}, {0, 0}).high < 1.5f);
    }
    for (const int operation : {kExprSqrt, kExprLog, kExprAsin}) {
        // Where no value is a number is outside.
        const Interval result = interval_apply(operation, {-3, -2}, {0, 0});
        CHECK(result.low > 0);
        const Interval sum = interval_apply(kExprSubtract, result, {1, 2});
        CHECK(sum.low > 0);
    }
    for (const Interval& b : {Interval{-1, 1}, Interval{0, 1}, Interval{-1, 0}, Interval{0, 0}}) {
        const Interval result = interval_apply(kExprDivide, {1, 2}, b);
        CHECK_FALSE(result.low > -kFloatInfinity);
        CHECK_FALSE(result.high < kFloatInfinity);
    }
    for (int operation = kExprNegate; operation < kExprOperations; ++operation) {
        const Interval result = interval_apply(operation, undefined_interval(), undefined_interval());
        INFO(operation);
        CHECK(result.partial != 0);
        CHECK(interval_sign(result) >= 0);
    }
}

TEST_CASE("bounds go through what is not taken, through branch cuts and beside poles") {
    const Interval nothing = undefined_interval();
    CHECK(interval_apply(kExprAnd, {0, 0}, nothing).high == 0);
    CHECK(interval_apply(kExprOr, {1, 2}, nothing).low == 1);
    CHECK(interval_apply(kExprAnd, {0, 1}, nothing).partial != 0);
    // Roots of sums of squares stay numbers where they vanish.
    const Interval square = interval_apply(kExprSquare, {-1, 1}, {0, 0});
    const Interval root = interval_apply(kExprSqrt, interval_apply(kExprAdd, square, square), {0, 0});
    CHECK(root.low == 0);
    CHECK(root.high < 1.4143f);
    const Interval above = interval_apply(kExprAtan2, {1, 2}, {-2, 2});
    CHECK(above.low > 0.4f);
    CHECK(above.high < 2.7f);
    const Interval across = interval_apply(kExprAtan2, {-1, 1}, {-2, -1});
    CHECK(across.low < -3.14159f);
    CHECK(across.high > 3.14159f);
    const Interval turn = interval_apply(kExprAtan, interval_apply(kExprDivide, {1, 2}, {-1, 1}), {0, 0});
    CHECK(turn.low > -1.571f);
    CHECK(turn.high < 1.571f);
    const Interval rest = interval_apply(kExprMod, {7.25f, 7.5f}, {3, 3});
    CHECK(rest.low > 1.2499f);
    CHECK(rest.high < 1.5001f);
    CHECK(interval_apply(kExprMod, {5.5f, 6.5f}, {3, 3}).low == 0);
    CHECK(interval_apply(kExprTan, {1.5f, 1.6f}, {0, 0}).high == kFloatInfinity);
    CHECK(interval_apply(kExprPower, {2, 3}, {2, 2}).low > 3.99f);
}

TEST_CASE("bounds of random programs hold their values") {
    RandomSource random(32);
    int decided = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto ops = mortise::test::random_program(random, random.integer(4, 24), false);
        const u32 count = static_cast<u32>(ops.size());
        Interval box[3];
        for (Interval& side : box) {
            const double low = random.uniform(-2, 2);
            side.low = static_cast<float>(low);
            side.high = side.low + static_cast<float>(std::pow(10.0, random.uniform(-4, 0.5)));
        }
        const Interval bounds = expression_bounds(ops.data(), count, box[0], box[1], box[2]);
        const bool is_decided = interval_sign(bounds) != 0;
        decided += is_decided;
        for (int k = 0; k < 6; ++k) {
            const double u[3] = {random_member(random, box[0]), random_member(random, box[1]),
                                 random_member(random, box[2])};
            const double value = expression_value(ops.data(), count, u);
            REQUIRE(holds(bounds, value));
        }
    }
    CHECK(decided > 2000);
}
