#include "host/tape/variation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/tape/interval_slopes.hpp"
#include "host/tape/patch_bounds.hpp"

namespace mortise::tape {
namespace {

constexpr double kVariationSlack = 1e-9;  ///< relative: far above the rounding of the sums below

struct Range {
    double low;
    double high;
};

Range operator+(Range a, Range b) { return {a.low + b.low, a.high + b.high}; }
Range operator*(Range a, Range b) {
    const double p[4] = {a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
    return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
}
Range square(Range a) {
    const Range p = a * a;
    return a.low <= 0 && a.high >= 0 ? Range{0, p.high} : p;
}

using Gradient = std::array<Range, 3>;

/// From the surface's own frame to box-local coordinates: the transpose of its map.
Gradient to_local(const Surface& s, const Gradient& d) {
    Gradient g{};
    for (std::size_t j = 0; j < 3; ++j) {
        g[j] = {0, 0};
        for (std::size_t i = 0; i < 3; ++i) {
            const double m = s.map[4 * i + j];
            g[j] = g[j] + d[i] * Range{m, m};
        }
    }
    return g;
}

/// Derivatives of a formula by its frame coordinates over a box: expression_sample in interval arithmetic.
Gradient expression_gradient(const ExpressionOp* ops, std::uint32_t count, const Interval* u) {
    Interval value[kExpressionRegisters + 1];
    Interval d[kExpressionRegisters + 1][3];
    const Interval zero = {0, 0};
    const Interval one = {1, 1};
    value[0] = zero;
    for (int j = 0; j < 3; ++j) d[0][j] = d[kExpressionLiteral][j] = zero;
    for (std::uint32_t i = 0; i < count; ++i) {
        const ExpressionOp& op = ops[i];
        value[kExpressionLiteral] = interval_literal(op.literal);
        if (op.operation <= kExprZ) {
            value[op.out] =
                op.operation == kExprConstant ? value[kExpressionLiteral] : u[op.operation - kExprX];
            for (int j = 0; j < 3; ++j) d[op.out][j] = op.operation == kExprX + j ? one : zero;
            continue;
        }
        const Interval a = value[op.a];
        const Interval b = value[op.b];
        const Interval f = interval_apply(op.operation, a, b);
        const bool binary = expression_is_binary(op.operation) != 0;
        Interval by_a;
        Interval by_b;
        interval_slopes(op.operation, a, b, f, &by_a, &by_b);
        for (int j = 0; j < 3; ++j) {
            const Interval da = d[op.a][j];
            const Interval db = d[op.b][j];
            if (op.operation == kExprMin || op.operation == kExprMax)
                d[op.out][j] = slope_of_extremum(op.operation, a, b, da, db);
            else if (!binary)
                d[op.out][j] = chain(by_a, da);
            else
                d[op.out][j] = interval_apply(kExprAdd, chain(by_a, da), chain(by_b, db));
        }
        value[op.out] = f;
    }
    Gradient g{};
    bool partial = value[0].partial != 0;
    for (const Interval& slope : d[0]) partial = partial || slope.partial != 0;
    const Interval anything = any_number();
    for (std::size_t j = 0; j < 3; ++j) {
        const Interval& slope = partial ? anything : d[0][j];
        g[j] = {slope.low, slope.high};
    }
    return g;
}

/// Derivatives of a rounded solid by its frame coordinates: the gradient turns by no more than the distance
/// from the centre, divided by the distance from where the surface's normals meet (kernels/shared/rounded.h).
Gradient rounded_gradient(const Surface& s, const ExpressionOp* ops, const double* centre, const Range* u) {
    const Range anything = {-1, 1};
    const bool turned = s.form[2] >= kRoundedRevolution;
    const Range squared = square(u[0]) + square(u[1]);
    const Range radial = {std::sqrt(squared.low), std::sqrt(squared.high)};
    double middle[3] = {centre[0], centre[1], centre[2]};
    double half[3];
    for (int i = 0; i < 3; ++i) half[i] = (u[i].high - u[i].low) / 2;
    if (turned) {
        middle[0] = (radial.low + radial.high) / 2;
        middle[1] = 0;
        half[0] = (radial.high - radial.low) / 2;
        half[1] = 0;
    }
    double g[3];
    const double value = rounded_sample(ops + s.first_op, middle, g);
    const double reach = std::sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
    const double room = s.form[0] + value - reach;
    if (!(room > 0)) return {anything, anything, anything};
    const double turn = reach / room + kVariationSlack;
    Gradient d{};
    for (std::size_t i = 0; i < 3; ++i) d[i] = {std::max(g[i] - turn, -1.0), std::min(g[i] + turn, 1.0)};
    if (s.form[2] == kRoundedColumn) d[2] = {0, 0};
    if (!turned) return d;
    const Range away = d[0];
    for (std::size_t i = 0; i < 2; ++i) {
        Range cosine = anything;
        if (radial.low > 0) {
            cosine = u[i] * Range{1 / radial.high, 1 / radial.low};
            cosine = {std::max(cosine.low, -1.0), std::min(cosine.high, 1.0)};
        }
        d[i] = away * cosine;
    }
    return d;
}

}  // namespace

GradientBox to_local(const Surface& surface, const GradientBox& gradient) {
    Gradient frame{};
    for (std::size_t j = 0; j < 3; ++j) frame[j] = {gradient.low[j], gradient.high[j]};
    const Gradient local = to_local(surface, frame);
    GradientBox box{};
    for (std::size_t j = 0; j < 3; ++j) {
        box.low[j] = local[j].low;
        box.high[j] = local[j].high;
    }
    return box;
}

bool keeps_direction(const GradientBox& box) {
    double low = 0;
    double size = 0;
    for (int j = 0; j < 3; ++j) {
        const Range c = {box.low[j], box.high[j]};
        low += (c * c).low;
        size += std::max(c.low * c.low, c.high * c.high);
    }
    return low > kVariationSlack * size;
}

bool gradient_box(const BoundModel& model, std::uint32_t surface, const Cell& cell, GradientBox& box) {
    const Surface& s = model.surfaces[surface];
    if (s.kind == kSurfacePlane || s.kind == kSurfacePatch) return false;
    const auto store = [&box](const Gradient& g) {
        for (std::size_t j = 0; j < 3; ++j) {
            box.low[j] = g[j].low;
            box.high[j] = g[j].high;
        }
        return true;
    };
    double centre[3];
    surface_frame(&s, cell.centre[0], cell.centre[1], cell.centre[2], centre);
    if (s.kind == kSurfaceQuadric) {
        // The gradient is linear in x, so its box is exact: its value at the centre, and the Hessian.
        Gradient g{};
        for (std::size_t j = 0; j < 3; ++j) {
            double value = 0;
            double width = 0;
            for (std::size_t i = 0; i < 3; ++i) value += 2 * s.form[i] * centre[i] * s.map[4 * i + j];
            for (std::size_t k = 0; k < 3; ++k) {
                double second = 0;
                for (std::size_t i = 0; i < 3; ++i)
                    second += 2 * s.form[i] * s.map[4 * i + j] * s.map[4 * i + k];
                width += cell.half * std::fabs(second);
            }
            g[j] = {value - width, value + width};
        }
        return store(g);
    }
    Range u[3];
    for (std::size_t i = 0; i < 3; ++i) {
        const double width =
            cell.half * (std::fabs(s.map[4 * i]) + std::fabs(s.map[4 * i + 1]) + std::fabs(s.map[4 * i + 2]));
        u[i] = {centre[i] - width, centre[i] + width};
    }
    if (s.kind == kSurfaceExpression) {
        Interval x[3];
        for (int i = 0; i < 3; ++i)
            x[i] = make_interval(static_cast<float>(u[i].low), static_cast<float>(u[i].high));
        return store(
            to_local(s, expression_gradient(model.expression_ops.data() + s.first_op, s.op_count, x)));
    }
    if (s.kind == kSurfaceRounded)
        return store(to_local(s, rounded_gradient(s, model.expression_ops.data(), centre, u)));
    const Range squared = square(u[0]) + square(u[1]);
    if (!(squared.low > 0)) {  // the axis
        const Range anything = {-kInfinity, kInfinity};
        return store({anything, anything, anything});
    }
    const Range radial = {std::sqrt(squared.low), std::sqrt(squared.high)};
    const Range inverse = {1 / radial.high, 1 / radial.low};
    Gradient d = {u[0] * inverse, u[1] * inverse, Range{1, 1}};
    for (std::size_t i = 0; i < 2; ++i) d[i] = {std::max(d[i].low, -1.0), std::min(d[i].high, 1.0)};
    if (s.kind == kSurfaceTorus) {
        const Range twice = {2 * (radial.low - s.form[0]), 2 * (radial.high - s.form[0])};
        d = {d[0] * twice, d[1] * twice, u[2] * Range{2, 2}};
    }
    return store(to_local(s, d));
}

bool has_small_variation(const BoundModel& model, std::uint32_t surface, const Cell& cell) {
    if (model.surfaces[surface].kind == kSurfacePatch)
        return patch_in(model, surface, cell) != PatchState::kTurning;
    GradientBox box;
    return !gradient_box(model, surface, cell, box) || keeps_direction(box);
}

}  // namespace mortise::tape
