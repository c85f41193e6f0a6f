#include "host/tape/variation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/shared/expression_bounds.h"

namespace mortise::tape {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlack = 1e-9;  ///< relative: far above the rounding of the sums below

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

const Interval kZero = {0, 0};
const Interval kOne = {1, 1};

Interval hull(Interval a, Interval b) {
    Interval both = interval_hull(a, b);
    both.partial = a.partial | b.partial;
    return both;
}

Interval negative(Interval a) { return interval_apply(kExprNegate, a, kZero); }
Interval quotient(Interval a, Interval b) { return interval_apply(kExprDivide, a, b); }

/// A factor that may be anything times a derivative that is 0.
Interval chain(Interval by, Interval d) {
    if ((d.low == 0 && d.high == 0) || (by.low == 0 && by.high == 0)) return kZero;
    if (is_empty_interval(by) || is_empty_interval(d)) return undefined_interval();
    return interval_apply(kExprMultiply, by, d);
}

/// 1 - a², 1 + a², …
Interval one_and_square(Interval a, bool minus) {
    const Interval square = interval_apply(kExprSquare, a, kZero);
    return interval_apply(minus ? kExprSubtract : kExprAdd, kOne, square);
}

/// expression_slopes in interval arithmetic, but for min and max. Where a function may jump: not numbers.
void slopes(std::int32_t operation, Interval a, Interval b, Interval f, Interval* by_a, Interval* by_b) {
    *by_a = kOne;
    *by_b = kZero;
    const bool constant = f.low == f.high;
    switch (operation) {
        case kExprNegate: *by_a = {-1, -1}; break;
        case kExprAbs: *by_a = {a.low >= 0 ? 1.0F : -1.0F, a.high <= 0 ? -1.0F : 1.0F}; break;
        case kExprSqrt: *by_a = quotient({0.5F, 0.5F}, f); break;
        case kExprSquare: *by_a = {2 * a.low, 2 * a.high}; break;
        case kExprAdd: *by_b = kOne; break;
        case kExprSubtract: *by_b = {-1, -1}; break;
        case kExprMultiply:
            *by_a = b;
            *by_b = a;
            break;
        case kExprDivide:
            *by_a = quotient(kOne, b);
            *by_b = negative(interval_apply(kExprMultiply, f, *by_a));
            break;
        case kExprSin: *by_a = interval_apply(kExprCos, a, kZero); break;
        case kExprCos: *by_a = negative(interval_apply(kExprSin, a, kZero)); break;
        case kExprExp: *by_a = f; break;
        case kExprLog: *by_a = quotient(kOne, a); break;
        case kExprTan: *by_a = one_and_square(f, false); break;
        case kExprAsin:
            *by_a = quotient(kOne, interval_apply(kExprSqrt, one_and_square(a, true), kZero));
            break;
        case kExprAcos:
            *by_a = quotient({-1, -1}, interval_apply(kExprSqrt, one_and_square(a, true), kZero));
            break;
        case kExprAtan: *by_a = quotient(kOne, one_and_square(a, false)); break;
        case kExprAtan2: {
            const Interval square = interval_apply(kExprAdd, interval_apply(kExprSquare, a, kZero),
                                                   interval_apply(kExprSquare, b, kZero));
            const bool jumps = a.low < 0 && a.high >= 0 && b.low <= 0;
            *by_a = jumps ? undefined_interval() : quotient(b, square);
            *by_b = jumps ? undefined_interval() : negative(quotient(a, square));
            break;
        }
        case kExprMod: {
            const Interval whole = interval_apply(kExprFloor, quotient(a, b), kZero);
            if (whole.low != whole.high) *by_a = undefined_interval();
            *by_b = whole.low == whole.high ? negative(whole) : undefined_interval();
            break;
        }
        case kExprAnd:
        case kExprOr: {
            const bool first = operation == kExprOr;
            const bool zero = a.low == 0 && a.high == 0;
            *by_a = holds_zero(a) ? (zero ? kZero : undefined_interval()) : (first ? kOne : kZero);
            *by_b = holds_zero(a) ? (zero ? (first ? kOne : kZero) : undefined_interval())
                                  : (first ? kZero : kOne);
            break;
        }
        case kExprHypot:
            *by_a = quotient(a, f);
            *by_b = quotient(b, f);
            break;
        case kExprPower:
            *by_a = interval_apply(kExprMultiply, b, quotient(f, a));
            *by_b = interval_apply(kExprMultiply, f, interval_apply(kExprLog, a, kZero));
            break;
        default: *by_a = constant ? kZero : undefined_interval(); break;  // steps
    }
}

/// Derivatives of a formula by its frame coordinates over a box: expression_sample in interval arithmetic.
Gradient expression_gradient(const ExpressionOp* ops, std::uint32_t count, const Interval* u) {
    Interval value[kExpressionRegisters + 1];
    Interval d[kExpressionRegisters + 1][3];
    value[0] = kZero;
    for (int j = 0; j < 3; ++j) d[0][j] = d[kExpressionLiteral][j] = kZero;
    for (std::uint32_t i = 0; i < count; ++i) {
        const ExpressionOp& op = ops[i];
        value[kExpressionLiteral] = interval_literal(op.literal);
        if (op.operation <= kExprZ) {
            value[op.out] =
                op.operation == kExprConstant ? value[kExpressionLiteral] : u[op.operation - kExprX];
            for (int j = 0; j < 3; ++j) d[op.out][j] = op.operation == kExprX + j ? kOne : kZero;
            continue;
        }
        const Interval a = value[op.a];
        const Interval b = value[op.b];
        const Interval f = interval_apply(op.operation, a, b);
        const bool binary = expression_is_binary(op.operation) != 0;
        Interval by_a;
        Interval by_b;
        slopes(op.operation, a, b, f, &by_a, &by_b);
        for (int j = 0; j < 3; ++j) {
            const Interval da = d[op.a][j];
            const Interval db = d[op.b][j];
            if (op.operation == kExprMin || op.operation == kExprMax) {
                const bool first = op.operation == kExprMin ? a.high < b.low : a.low > b.high;
                const bool second = op.operation == kExprMin ? b.high < a.low : b.low > a.high;
                d[op.out][j] = first ? da : second ? db : hull(da, db);
            } else if (!binary) {
                d[op.out][j] = chain(by_a, da);
            } else {
                d[op.out][j] = interval_apply(kExprAdd, chain(by_a, da), chain(by_b, db));
            }
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
    const double turn = reach / room + kSlack;
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

bool keeps_direction(const GradientBox& box) {
    double low = 0;
    double size = 0;
    for (int j = 0; j < 3; ++j) {
        const Range c = {box.low[j], box.high[j]};
        low += (c * c).low;
        size += std::max(c.low * c.low, c.high * c.high);
    }
    return low > kSlack * size;
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
    GradientBox box;
    return !gradient_box(model, surface, cell, box) || keeps_direction(box);  // patches are not searched
}

}  // namespace mortise::tape
