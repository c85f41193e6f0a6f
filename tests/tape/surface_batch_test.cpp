// Surfaces at many places at once: the same bits as one after the other, and slopes that hold.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "host/tape/surface_batch.hpp"
#include "host/tape/variation.hpp"
#include "tests/shared/random_surfaces.hpp"

namespace mortise::test {
namespace {

/// A random formula; its coordinates are those of the box in half of the cases, else turned.
tape::BoundModel random_formula(RandomSource& random) {
    tape::BoundModel model;
    model.expression_ops = random_program(random, random.integer(4, 40), false);
    Surface s{};
    s.kind = kSurfaceExpression;
    s.op_count = static_cast<u32>(model.expression_ops.size());
    const bool straight = random.chance(0.5);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            s.map[4 * i + j] = i == j ? random.uniform(1, 8) : straight ? 0 : random.uniform(-2, 2);
        s.map[4 * i + 3] = random.uniform(-4, 1);
    }
    model.surfaces.push_back(s);
    return model;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b); }

bool same_bits(const SurfaceSample& a, const SurfaceSample& b) {
    bool same = same_bits(a.value, b.value);
    for (int j = 0; j < 3; ++j) same = same && same_bits(a.gradient[j], b.gradient[j]);
    return same;
}

}  // namespace

TEST_CASE("surfaces at many places: the bits of one after the other") {
    RandomSource random(7);
    int decided = 0;
    int bounded = 0;
    int steady = 0;
    int steady_alone = 0;
    for (int i = 0; i < 3000; ++i) {
        CAPTURE(i);
        const tape::BoundModel model = random_formula(random);
        // Zeros of both signs may come out of a step, and quotients by them jump.
        const bool divides_by_steps =
            has_steps(model.expression_ops) &&
            std::any_of(model.expression_ops.begin(), model.expression_ops.end(),
                        [](const ExpressionOp& op) { return op.operation == kExprDivide; });
        tape::SurfaceBatch batch(model);
        const ExpressionOp* ops = model.expression_ops.data();
        const std::size_t side = std::size_t{1} << random.integer(1, 4);
        const tape::Grid grid = {{random.uniform(0, 0.9), random.uniform(0, 0.9), random.uniform(0, 0.9)},
                                 std::pow(2.0, -random.integer(5, 10)),
                                 side};
        std::vector<tape::GridPlace> cells;
        const auto at = [&] {
            return static_cast<std::uint8_t>(random.integer(0, static_cast<int>(side) - 1));
        };
        for (int k = random.integer(1, 300); k > 0; --k) cells.push_back({{at(), at(), at()}});
        const tape::Places places(grid, cells);
        std::vector<Vec3> points;
        for (std::size_t k = 0; k < cells.size(); ++k) points.push_back(places.point(k));

        std::vector<std::int8_t> signs;
        std::vector<double> widths, slopes, values, values_at;
        std::vector<SurfaceSample> samples, samples_at;
        std::vector<std::uint8_t> is_steady;
        batch.classify(0, grid, cells, signs, &widths);
        batch.slopes(0, grid, cells, slopes);
        batch.values(0, places, values);
        batch.values(0, tape::Places(points), values_at);
        batch.samples(0, places, samples);
        batch.samples(0, tape::Places(points), samples_at);
        batch.find_steady(0, points, 0.5 * grid.edge, is_steady);
        for (std::size_t k = 0; k < cells.size(); ++k) {
            const Vec3& x = points[k];
            const double half = 0.5 * grid.edge;
            const tape::Cell cell = {{x[0], x[1], x[2]}, half};
            REQUIRE(signs[k] == tape::classify_surface(model, 0, cell));
            const double value = surface_value(&model.surfaces[0], ops, x[0], x[1], x[2]);
            REQUIRE(same_bits(values[k], value));
            REQUIRE(same_bits(values_at[k], value));
            const SurfaceSample sample = surface_sample(&model.surfaces[0], ops, x[0], x[1], x[2]);
            REQUIRE(same_bits(samples[k], sample));
            REQUIRE(same_bits(samples_at[k], sample));
            decided += signs[k] != 0 ? 1 : 0;
            if (tape::has_small_variation(model, 0, cell)) {
                ++steady_alone;
                REQUIRE(is_steady[k] != 0);
            }
            if (divides_by_steps || !(slopes[k] < kMortiseInfinity) || !(widths[k] < kMortiseInfinity))
                continue;
            ++bounded;
            const Vec3 y = {x[0] + random.uniform(-half, half), x[1] + random.uniform(-half, half),
                            x[2] + random.uniform(-half, half)};
            const SurfaceSample there = surface_sample(&model.surfaces[0], ops, y[0], y[1], y[2]);
            if (is_steady[k] != 0) {
                ++steady;
                double product = 0;
                for (int j = 0; j < 3; ++j) product += sample.gradient[j] * there.gradient[j];
                REQUIRE(product > 0);
            }
            const double other = surface_value(&model.surfaces[0], ops, y[0], y[1], y[2]);
            REQUIRE(std::fabs(other - value) <= half * slopes[k] + 1e-6 * widths[k]);
        }
    }
    CHECK(decided > 100000);
    CHECK(bounded > 50000);
    MESSAGE(steady, " cells in which the gradient keeps its direction, ", steady_alone,
            " one after the other");
    CHECK(steady > 20000);
}

}  // namespace mortise::test
