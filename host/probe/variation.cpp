#include "host/probe/variation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/shared/expression_bounds.h"

namespace mortise::probe {
namespace {

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

/// Whether the inner product of any two vectors of the box is positive. Ends that are not numbers: no.
bool keeps_direction(const Gradient& g) {
    double low = 0;
    double size = 0;
    for (const Range& c : g) {
        low += (c * c).low;
        size += std::max(c.low * c.low, c.high * c.high);
    }
    return low > kSlack * size;
}

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

Interval hull(Interval a, Interval b) {
    if (a.low != a.low || b.low != b.low) return undefined_interval();
    return make_interval(smaller(a.low, b.low), larger(a.high, b.high));
}

/// Derivatives of a formula by its frame coordinates over a box: expression_sample in interval arithmetic.
Gradient expression_gradient(const ExpressionOp* ops, std::uint32_t count, const Interval* u) {
    Interval value[kExpressionRegisters];
    Interval d[kExpressionRegisters][3];
    const Interval zero = {0, 0};
    const Interval one = {1, 1};
    value[0] = zero;
    for (Interval& x : d[0]) x = zero;
    for (std::uint32_t i = 0; i < count; ++i) {
        const ExpressionOp& op = ops[i];
        if (op.operation <= kExprZ) {
            const auto literal = static_cast<float>(op.literal);
            value[op.out] =
                op.operation == kExprConstant ? make_interval(literal, literal) : u[op.operation - kExprX];
            for (int j = 0; j < 3; ++j) d[op.out][j] = op.operation == kExprX + j ? one : zero;
            continue;
        }
        const Interval a = value[op.a];
        const Interval b = value[op.b];
        const Interval f = interval_apply(op.operation, a, b);
        Interval by_a = one;
        Interval by_b = zero;
        switch (op.operation) {
            case kExprNegate: by_a = {-1, -1}; break;
            case kExprAbs: by_a = {a.low >= 0 ? 1.0F : -1.0F, a.high <= 0 ? -1.0F : 1.0F}; break;
            case kExprSqrt: by_a = interval_apply(kExprDivide, {0.5F, 0.5F}, f); break;
            case kExprSquare: by_a = {2 * a.low, 2 * a.high}; break;
            case kExprAdd: by_b = one; break;
            case kExprSubtract: by_b = {-1, -1}; break;
            case kExprMultiply:
                by_a = b;
                by_b = a;
                break;
            case kExprDivide:
                by_a = interval_apply(kExprDivide, one, b);
                by_b = interval_apply(kExprNegate, interval_multiply(f, by_a), zero);
                break;
            case kExprSin: by_a = interval_sin(a, 1); break;
            case kExprCos: by_a = interval_apply(kExprNegate, interval_sin(a, 0), zero); break;
            case kExprExp: by_a = f; break;
            case kExprLog: by_a = interval_apply(kExprDivide, one, a); break;
            default: break;  // min and max: below
        }
        for (int j = 0; j < 3; ++j) {
            const Interval da = d[op.a][j];
            const Interval db = d[op.b][j];
            if (op.operation == kExprMin || op.operation == kExprMax) {
                const bool first = op.operation == kExprMin ? a.high < b.low : a.low > b.high;
                const bool second = op.operation == kExprMin ? b.high < a.low : b.low > a.high;
                d[op.out][j] = first ? da : second ? db : hull(da, db);
            } else if (op.operation < kExprAdd || op.operation > kExprDivide) {
                d[op.out][j] = interval_multiply(by_a, da);
            } else {
                d[op.out][j] =
                    interval_apply(kExprAdd, interval_multiply(by_a, da), interval_multiply(by_b, db));
            }
        }
        value[op.out] = f;
    }
    Gradient g{};
    for (std::size_t j = 0; j < 3; ++j) g[j] = {d[0][j].low, d[0][j].high};
    return g;
}

}  // namespace

bool has_small_variation(const tape::BoundModel& model, std::uint32_t surface, const tape::Cell& cell) {
    const Surface& s = model.surfaces[surface];
    if (s.kind == kSurfacePlane || s.kind == kSurfacePatch) return true;  // patches are not searched
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
        return keeps_direction(g);
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
        return keeps_direction(
            to_local(s, expression_gradient(model.expression_ops.data() + s.first_op, s.op_count, x)));
    }
    const Range squared = square(u[0]) + square(u[1]);
    if (!(squared.low > 0)) return false;  // the axis
    const Range radial = {std::sqrt(squared.low), std::sqrt(squared.high)};
    const Range inverse = {1 / radial.high, 1 / radial.low};
    Gradient d = {u[0] * inverse, u[1] * inverse, Range{1, 1}};
    for (std::size_t i = 0; i < 2; ++i) d[i] = {std::max(d[i].low, -1.0), std::min(d[i].high, 1.0)};
    if (s.kind == kSurfaceTorus) {
        const Range twice = {2 * (radial.low - s.form[0]), 2 * (radial.high - s.form[0])};
        d = {d[0] * twice, d[1] * twice, u[2] * Range{2, 2}};
    }
    return keeps_direction(to_local(s, d));
}

}  // namespace mortise::probe
