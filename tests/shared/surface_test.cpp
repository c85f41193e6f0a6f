// Surfaces: values against their definitions, gradients, signs with their tolerance, and roots.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/shared/random_surfaces.hpp"

using mortise::test::has_steps;
using mortise::test::kSurfaceKinds;
using mortise::test::random_surface;
using mortise::test::RandomSource;

namespace {

double norm(const double* v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// f from the definitions at the head of surface.h, in extended precision.
double defined_value(const Surface& s, const double* x) {
    long double u[3];
    for (int i = 0; i < 3; ++i) {
        u[i] = s.map[4 * i + 3];
        for (int j = 0; j < 3; ++j) u[i] += static_cast<long double>(s.map[4 * i + j]) * x[j];
    }
    if (s.kind == kSurfacePlane) return static_cast<double>(u[0]);
    const long double radial = std::sqrt(u[0] * u[0] + u[1] * u[1]);
    if (s.kind == kSurfaceCone) return static_cast<double>(radial + u[2]);
    if (s.kind == kSurfaceTorus) {
        const long double ring = radial - s.form[0];
        return static_cast<double>(ring * ring + u[2] * u[2] + s.form[3]);
    }
    return static_cast<double>(s.form[0] * u[0] * u[0] + s.form[1] * u[1] * u[1] + s.form[2] * u[2] * u[2] +
                               s.form[3]);
}

Surface flipped(Surface s) {
    if (s.kind == kSurfacePlane) {
        for (int j = 0; j < 4; ++j) s.map[j] = -s.map[j];
    } else {
        for (double& form : s.form) form = -form;
    }
    return s;
}

}  // namespace

TEST_CASE("values follow the definitions; the sampled value is the same bits") {
    RandomSource random(41);
    for (int i = 0; i < 40000; ++i) {
        std::vector<ExpressionOp> ops;
        const Surface s = random_surface(random, i % kSurfaceKinds, ops);
        const double x[3] = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const double value = surface_value(&s, ops.data(), x[0], x[1], x[2]);
        const double sampled = surface_sample(&s, ops.data(), x[0], x[1], x[2]).value;
        REQUIRE((value == sampled || (std::isnan(value) && std::isnan(sampled))));
        const bool defined = s.kind != kSurfaceExpression && s.kind != kSurfaceRounded;
        if (defined) REQUIRE(std::fabs(value - defined_value(s, x)) < 1e-13);
    }
}

TEST_CASE("gradients agree with central differences") {
    RandomSource random(42);
    for (int kind = 0; kind < kSurfaceKinds; ++kind) {
        int compared = 0;
        for (int i = 0; i < 4000; ++i) {
            std::vector<ExpressionOp> ops;
            const Surface s = random_surface(random, kind, ops);
            const double x[3] = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
            const SurfaceSample sample = surface_sample(&s, ops.data(), x[0], x[1], x[2]);
            if (kind == kSurfaceExpression && has_steps(ops)) continue;
            for (int j = 0; j < 3; ++j) {
                double slope[2];
                for (int k = 0; k < 2; ++k) {
                    const double h = k == 0 ? 1e-5 : 5e-6;
                    double low[3] = {x[0], x[1], x[2]};
                    double high[3] = {x[0], x[1], x[2]};
                    low[j] -= h;
                    high[j] += h;
                    slope[k] = (surface_value(&s, ops.data(), high[0], high[1], high[2]) -
                                surface_value(&s, ops.data(), low[0], low[1], low[2])) /
                               (2 * h);
                }
                const double size = std::max({1.0, std::fabs(slope[1]), std::fabs(sample.value)});
                if (!(std::fabs(slope[0] - slope[1]) < 1e-6 * size)) continue;  // a kink or a pole
                if (!std::isfinite(sample.gradient[j])) continue;  // a value on the way overflows
                REQUIRE(std::fabs(sample.gradient[j] - slope[1]) < 1e-5 * size);
                ++compared;
            }
        }
        INFO(kind);
        CHECK(compared > 4000);
    }
}

TEST_CASE("signs are -1, 0 and +1 within, at and beyond the tolerance, to first order") {
    RandomSource random(43);
    const double cell = 1.0 / 64;
    for (int kind = 0; kind < kSurfaceExpression; ++kind) {
        int found = 0;
        for (int i = 0; i < 20000; ++i) {
            std::vector<ExpressionOp> ops;
            const Surface s = random_surface(random, kind, ops);
            // A point of the surface by Newton steps, then a step along the normal.
            double x[3] = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
            SurfaceSample sample{};
            double length = 0;
            for (int step = 0; step < 40; ++step) {
                sample = surface_sample(&s, ops.data(), x[0], x[1], x[2]);
                length = norm(sample.gradient);
                if (length == 0) break;
                for (int j = 0; j < 3; ++j) x[j] -= sample.value * sample.gradient[j] / (length * length);
            }
            if (length < 0.1 || std::fabs(sample.value) > 1e-13) continue;
            double u[3];
            surface_frame(&s, x[0], x[1], x[2], u);
            if (kind == kSurfaceCone && std::fabs(u[2]) < 1e-3) continue;  // the apex
            ++found;
            for (const double steps : {-30.0, -1.02, -0.98, 0.0, 0.98, 1.02, 30.0}) {
                double at[3];
                for (int j = 0; j < 3; ++j) {
                    at[j] = x[j] + steps * kSignTolerance * cell * sample.gradient[j] / length;
                }
                const int sign = surface_sign(&s, ops.data(), at[0], at[1], at[2], cell);
                CAPTURE(kind);
                CAPTURE(steps);
                CAPTURE(length);
                CAPTURE(sample.value);
                REQUIRE(sign == (steps < -1 ? -1 : steps > 1 ? 1 : 0));
                if (kind == kSurfacePlane || kind == kSurfaceQuadric) {
                    const Surface other = flipped(s);
                    REQUIRE(surface_sign(&other, ops.data(), at[0], at[1], at[2], cell) == -sign);
                }
            }
        }
        INFO(kind);
        CHECK(found > 5000);
    }
}

TEST_CASE("a value that is not a number is outside") {
    const std::vector<ExpressionOp> ops = {{kExprX, 1, 0, 0, 0}, {kExprSqrt, 0, 1, 1, 0}};
    Surface s{};
    s.kind = kSurfaceExpression;
    s.op_count = 2;
    for (int i = 0; i < 3; ++i) s.map[4 * i + i] = 1;
    CHECK(surface_sign(&s, ops.data(), -0.5, 0, 0, 0.1) == 1);
}

TEST_CASE("a gradient that is not finite leaves the sign of the value") {
    // 1 / exp(800 x) - 0.5: the exponential overflows where the value is -0.5. log(x): -inf at 0.
    const std::vector<ExpressionOp> overflow = {{kExprX, 1, 0, 0, 0},          {kExprConstant, 2, 0, 0, 800},
                                                {kExprMultiply, 1, 1, 2, 0},   {kExprExp, 1, 1, 1, 0},
                                                {kExprConstant, 2, 0, 0, 1},   {kExprDivide, 1, 2, 1, 0},
                                                {kExprConstant, 2, 0, 0, 0.5}, {kExprSubtract, 0, 1, 2, 0}};
    const std::vector<ExpressionOp> pole = {{kExprX, 1, 0, 0, 0}, {kExprLog, 0, 1, 1, 0}};
    Surface s{};
    s.kind = kSurfaceExpression;
    for (int i = 0; i < 3; ++i) s.map[4 * i + i] = 1;
    s.op_count = static_cast<u32>(overflow.size());
    CHECK(surface_sign(&s, overflow.data(), 0.95, 0, 0, 0.1) == -1);
    CHECK(surface_sign(&s, overflow.data(), 0, 0, 0, 0.1) == 1);
    s.op_count = static_cast<u32>(pole.size());
    CHECK(surface_sign(&s, pole.data(), 0, 0, 0, 0.1) == -1);
}

TEST_CASE("roots lie inside their segment and on the surface") {
    RandomSource random(44);
    for (int kind = 0; kind < kSurfaceKinds; ++kind) {
        int bracketed = 0;
        for (int i = 0; i < 20000; ++i) {
            std::vector<ExpressionOp> ops;
            const Surface s = random_surface(random, kind, ops);
            double a[3];
            double b[3];
            const double length = std::pow(10.0, random.uniform(-3, 0));
            for (int j = 0; j < 3; ++j) {
                a[j] = random.uniform(0, 1);
                b[j] = a[j] + length * random.uniform(-1, 1);
            }
            const double f_a = surface_value(&s, ops.data(), a[0], a[1], a[2]);
            const double f_b = surface_value(&s, ops.data(), b[0], b[1], b[2]);
            const double t = segment_root(&s, ops.data(), a, b);
            if (!std::isfinite(f_a) || !std::isfinite(f_b)) continue;
            REQUIRE(t >= 0);
            REQUIRE(t <= 1);
            const i32 units = edge_root(&s, ops.data(), a, b);
            REQUIRE(units >= kRootMargin);
            REQUIRE(units <= kCellUnits - kRootMargin);
            const double kept = std::min(std::max(t * kCellUnits, static_cast<double>(kRootMargin)),
                                         static_cast<double>(kCellUnits - kRootMargin));
            REQUIRE(std::fabs(units - kept) <= 0.5);
            if (!((f_a < 0 && f_b > 0) || (f_a > 0 && f_b < 0))) continue;
            ++bracketed;
            // The sign must change within a small step about t, or the value be small there.
            const auto along = [&](double at) {
                return surface_value(&s, ops.data(), a[0] + at * (b[0] - a[0]), a[1] + at * (b[1] - a[1]),
                                     a[2] + at * (b[2] - a[2]));
            };
            const double low = along(std::max(0.0, t - 1e-9));
            const double high = along(std::min(1.0, t + 1e-9));
            const bool changes = !(low * high > 0);
            const bool small = std::fabs(along(t)) <= 1e-12 * std::max({1.0, std::fabs(f_a), std::fabs(f_b)});
            CAPTURE(kind);
            CAPTURE(i);
            CAPTURE(t);
            CAPTURE(f_a);
            CAPTURE(f_b);
            CHECK((changes || small));
        }
        INFO(kind);
        CHECK(bracketed > 300);
    }
}

TEST_CASE("roots of ends without a change of sign stay inside their segment") {
    Surface s{};
    s.kind = kSurfacePlane;
    s.map[0] = 1;
    s.map[3] = 0.25;
    const double a[3] = {0, 0, 0};
    const double b[3] = {0.5, 0, 0};
    CHECK(segment_root(&s, nullptr, a, b) == doctest::Approx(0.25));  // values 0.25 and 0.75
    s.map[0] = 0;
    s.map[3] = 0;
    CHECK(segment_root(&s, nullptr, a, b) == 0.5);
    s.kind = kSurfaceExpression;
    s.op_count = 1;
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), 0.0, 1e300}) {
        const ExpressionOp constant = {kExprConstant, 0, 0, 0, value};
        const double t = segment_root(&s, &constant, a, b);
        CHECK(t >= 0);
        CHECK(t <= 1);
    }
}

TEST_CASE("steep and flat formulas still give roots") {
    // x^64 - 1e-9, exp(200 (x - 0.3)) - 1 and (x - 0.7)^3 on [0, 1].
    struct Steep {
        std::vector<ExpressionOp> ops;
        double root;
    };
    std::vector<Steep> formulas;
    formulas.push_back({{{kExprX, 1, 0, 0, 0}}, std::pow(1e-9, 1.0 / 64)});
    for (int i = 0; i < 6; ++i) formulas[0].ops.push_back({kExprSquare, 1, 1, 1, 0});
    formulas[0].ops.push_back({kExprConstant, 2, 0, 0, 1e-9});
    formulas[0].ops.push_back({kExprSubtract, 0, 1, 2, 0});
    formulas.push_back({{{kExprX, 1, 0, 0, 0},
                         {kExprConstant, 2, 0, 0, 0.3},
                         {kExprSubtract, 1, 1, 2, 0},
                         {kExprConstant, 2, 0, 0, 200},
                         {kExprMultiply, 1, 1, 2, 0},
                         {kExprExp, 1, 1, 1, 0},
                         {kExprConstant, 2, 0, 0, 1},
                         {kExprSubtract, 0, 1, 2, 0}},
                        0.3});
    formulas.push_back({{{kExprX, 1, 0, 0, 0},
                         {kExprConstant, 2, 0, 0, 0.7},
                         {kExprSubtract, 1, 1, 2, 0},
                         {kExprSquare, 2, 1, 1, 0},
                         {kExprMultiply, 0, 1, 2, 0}},
                        0.7});
    for (const Steep& steep : formulas) {
        Surface s{};
        s.kind = kSurfaceExpression;
        s.op_count = static_cast<u32>(steep.ops.size());
        for (int i = 0; i < 3; ++i) s.map[4 * i + i] = 1;
        const double a[3] = {0, 0, 0};
        const double b[3] = {1, 0, 0};
        CHECK(segment_root(&s, steep.ops.data(), a, b) == doctest::Approx(steep.root).epsilon(1e-4));
        CHECK(segment_root(&s, steep.ops.data(), b, a) == doctest::Approx(1 - steep.root).epsilon(1e-4));
    }
}
