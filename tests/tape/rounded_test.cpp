// Rounded solids: distances and gradients against a search of directions; what is said of cells against
// points in them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/tape/reference.hpp"
#include "host/tape/variation.hpp"
#include "tests/model/rounded_distance.hpp"
#include "tests/shared/random_surfaces.hpp"

namespace mortise::test {
namespace {

struct Placed {
    RoundedSolid solid;
    tape::BoundModel model;
};

/// A random solid in the unit cube; its map keeps angles in half of the cases.
Placed random_placed(RandomSource& random) {
    Placed placed;
    placed.solid = random_rounded(random);
    Surface s = tape::write_rounded(placed.solid, placed.model.expression_ops);
    const bool rigid = random.chance(0.5);
    const double turn = random.uniform(0, 6.3);
    const double scale = random.uniform(2, 4);
    const double matrix[9] = {std::cos(turn) * scale,
                              -std::sin(turn) * scale,
                              0,  //
                              std::sin(turn) * scale,
                              std::cos(turn) * scale,
                              0,  //
                              0,
                              0,
                              scale};
    for (int i = 0; i < 3; ++i) {
        s.map[4 * i + 3] = 0;
        for (int j = 0; j < 3; ++j) {
            s.map[4 * i + j] = matrix[3 * i + j] + (rigid ? 0 : random.uniform(-0.5, 0.5));
            s.map[4 * i + 3] -= s.map[4 * i + j] * random.uniform(0.4, 0.6);
        }
    }
    placed.model.surfaces.push_back(s);
    return placed;
}

SurfaceSample sample(const tape::BoundModel& model, const double* x) {
    return surface_sample(&model.surfaces[0], model.expression_ops.data(), x[0], x[1], x[2]);
}

}  // namespace

TEST_CASE("rounded solids: the value is the distance, the gradient its direction") {
    RandomSource random(81);
    double worst = 0;
    for (int i = 0; i < 400; ++i) {
        const RoundedSolid solid = random_rounded(random);
        std::vector<ExpressionOp> ops;
        const Surface s = tape::write_rounded(solid, ops);
        for (int k = 0; k < 8; ++k) {
            const Vec3 p = {random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5)};
            const SurfaceSample at = surface_sample(&s, ops.data(), p[0], p[1], p[2]);
            CAPTURE(i);
            CAPTURE(static_cast<int>(solid.shape));
            double square = 0;
            for (const double g : at.gradient) square += g * g;
            REQUIRE(std::fabs(square - 1) < 1e-12);
            // It is what the gradient as direction gives, and no direction gives more.
            const Vec3 direction = {at.gradient[0], at.gradient[1], at.gradient[2]};
            const double radial = std::hypot(p[0], p[1]);
            const Vec3 turned = {(direction[0] * p[0] + direction[1] * p[1]) / radial, direction[2], 0};
            const bool ring = solid.shape == RoundedSolid::Shape::kRing;
            const double beyond = ring ? rounded_beyond(profile_of(solid), in_profile(p), turned)
                                       : rounded_beyond(solid, p, direction);
            REQUIRE(std::fabs(at.value - beyond) < 1e-12);
            const double found = rounded_distance(solid, p);
            REQUIRE(found < at.value + 1e-12);
            worst = std::max(worst, at.value - found);
            if (at.value < -0.05) continue;
            // The foot lies on the surface, if it is not beyond the axis.
            if (ring && turned[0] * at.value > radial) continue;
            const SurfaceSample foot =
                surface_sample(&s, ops.data(), p[0] - at.value * at.gradient[0],
                               p[1] - at.value * at.gradient[1], p[2] - at.value * at.gradient[2]);
            REQUIRE(std::fabs(foot.value) < 1e-12);
        }
    }
    MESSAGE("rounded solids: the search of directions falls short by " << worst << " at most");
}

TEST_CASE("rounded solids: cells are IN or OUT only where all their points are, and most that can be are") {
    RandomSource random(82);
    std::size_t decided = 0;
    std::size_t open = 0;
    std::size_t passed = 0;  // of those that are open, by points on both sides
    for (int i = 0; i < 600; ++i) {
        const Placed placed = random_placed(random);
        for (int k = 0; k < 40; ++k) {
            tape::Cell cell{};
            cell.half = std::pow(0.5, random.integer(2, 8));
            for (double& x : cell.centre) x = random.uniform(0, 1);
            const int sign = tape::classify_surface(placed.model, 0, cell);
            double low = 1e300;
            double high = -1e300;
            for (int c = 0; c < 27 + 10; ++c) {
                double x[3];
                for (int j = 0; j < 3; ++j) {
                    const double step = c < 27 ? (c / (j == 0   ? 1
                                                       : j == 1 ? 3
                                                                : 9)) %
                                                         3 -
                                                     1
                                               : random.uniform(-1, 1);
                    x[j] = cell.centre[j] + step * cell.half;
                }
                const double value = sample(placed.model, x).value;
                low = std::min(low, value);
                high = std::max(high, value);
            }
            if (sign < 0) REQUIRE(high < 0);
            if (sign > 0) REQUIRE(low > 0);
            if (sign != 0) {
                ++decided;
                continue;
            }
            ++open;
            passed += low <= 0 && high >= 0 ? 1 : 0;
        }
    }
    MESSAGE("rounded solids: " << decided << " cells decided, " << open << " not, " << passed
                               << " of these with points on both sides");
    CHECK(decided > 10000);
    CHECK(open > 3000);
    CHECK(passed > open * 8 / 10);
}

TEST_CASE("rounded solids: gradient boxes hold the gradients in their cell") {
    RandomSource random(83);
    std::size_t steady = 0;
    for (int i = 0; i < 600; ++i) {
        const Placed placed = random_placed(random);
        for (int k = 0; k < 20; ++k) {
            tape::Cell cell{};
            cell.half = std::pow(0.5, random.integer(3, 9));
            for (double& x : cell.centre) x = random.uniform(0, 1);
            tape::GradientBox box;
            REQUIRE(tape::gradient_box(placed.model, 0, cell, box));
            steady += tape::keeps_direction(box) ? 1 : 0;
            for (int c = 0; c < 20; ++c) {
                double x[3];
                for (int j = 0; j < 3; ++j) x[j] = cell.centre[j] + random.uniform(-1, 1) * cell.half;
                const SurfaceSample at = sample(placed.model, x);
                for (int j = 0; j < 3; ++j) {
                    REQUIRE(at.gradient[j] >= box.low[j] - 1e-9);
                    REQUIRE(at.gradient[j] <= box.high[j] + 1e-9);
                }
            }
        }
    }
    MESSAGE("rounded solids: " << steady << " of 12000 cells keep the gradient's direction");
    CHECK(steady > 4000);
}

TEST_CASE("rounded solids that cannot be are refused") {
    const auto refusal = [](RoundedSolid solid) -> std::string {
        try {
            rounded(std::move(solid));
        } catch (const Error& error) {
            return error.what();
        }
        return {};
    };
    CHECK(refusal({}) == "rounded solid: it has no balls; expected at least one");
    CHECK(refusal({RoundedSolid::Shape::kHull, {{{}, 0}}, 0, 0, 0}) ==
          "rounded solid: radius is 0; expected a positive, finite number");
    CHECK(refusal({RoundedSolid::Shape::kPlate, {{{}, 0}}, 0, 1, 0}) ==
          "rounded solid: rounding is 0; expected a positive, finite number");
    CHECK(refusal({RoundedSolid::Shape::kPlate, {{{}, 0}}, 1, 1, 1}) ==
          "rounded solid: height is 0; expected a positive, finite number");
    CHECK(refusal({RoundedSolid::Shape::kPlate, {{{}, 0}}, 0, 1, 1}).empty());
}

}  // namespace mortise::test
