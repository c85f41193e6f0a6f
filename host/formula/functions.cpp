#include "host/formula/functions.hpp"

#include "host/common/constants.hpp"

namespace mortise::formula {
namespace {

using Arguments = std::vector<std::uint32_t>;

/// Below this a width is none, and what is divided by it 0.
constexpr double kLeastWidth = 1e-300;

/// What functions are made of, in the order in which one would write it.
class Builder {
  public:
    explicit Builder(Formula& formula) : formula_(formula) {}

    std::uint32_t number(double value) { return formula_.add_constant(value); }
    std::uint32_t of(std::int32_t operation, std::uint32_t a) { return formula_.add(operation, a); }
    std::uint32_t plus(std::uint32_t a, std::uint32_t b) { return formula_.add(kExprAdd, a, b); }
    std::uint32_t minus(std::uint32_t a, std::uint32_t b) { return formula_.add(kExprSubtract, a, b); }
    std::uint32_t times(std::uint32_t a, std::uint32_t b) { return formula_.add(kExprMultiply, a, b); }
    std::uint32_t scaled(std::uint32_t a, double by) { return times(a, number(by)); }
    std::uint32_t over(std::uint32_t a, std::uint32_t b) { return formula_.add(kExprDivide, a, b); }
    std::uint32_t reciprocal(std::uint32_t a) { return over(number(1), a); }
    std::uint32_t least(std::uint32_t a, std::uint32_t b) { return formula_.add(kExprMin, a, b); }
    std::uint32_t largest(std::uint32_t a, std::uint32_t b) { return formula_.add(kExprMax, a, b); }
    std::uint32_t clamp(std::uint32_t a, std::uint32_t low, std::uint32_t high) {
        return least(largest(a, low), high);
    }
    std::uint32_t log_of_base(double base, std::uint32_t a) {
        return over(of(kExprLog, a), of(kExprLog, number(base)));
    }
    /// Half of the sum, or difference, of exp(a) and exp(-a).
    std::uint32_t half_exponentials(std::int32_t sum_or_difference, std::uint32_t a) {
        const std::uint32_t grows = of(kExprExp, a);
        return scaled(formula_.add(sum_or_difference, grows, reciprocal(grows)), 0.5);
    }
    /// Of the polynomial smooth minimum: how far it lies below the smaller one. Where a and b differ by the
    /// width and more: 0.
    std::uint32_t blend(std::uint32_t a, std::uint32_t b, std::uint32_t width) {
        const std::uint32_t overlap = largest(minus(width, of(kExprAbs, minus(a, b))), number(0));
        return over(of(kExprSquare, overlap), scaled(largest(width, number(kLeastWidth)), 4));
    }

  private:
    Formula& formula_;
};

template <std::int32_t operation>
std::uint32_t unary(Formula& formula, const Arguments& arguments) {
    return formula.add(operation, arguments[0]);
}

/// From the left, if there are more than two.
template <std::int32_t operation>
std::uint32_t binary(Formula& formula, const Arguments& arguments) {
    std::uint32_t value = arguments[0];
    for (std::size_t i = 1; i < arguments.size(); ++i) value = formula.add(operation, value, arguments[i]);
    return value;
}

std::uint32_t length(Formula& formula, const Arguments& a) {
    if (a.size() == 2) return formula.add(kExprHypot, a[0], a[1]);
    Builder build(formula);
    std::uint32_t sum = build.of(kExprSquare, a[0]);
    for (std::size_t i = 1; i < a.size(); ++i) sum = build.plus(sum, build.of(kExprSquare, a[i]));
    return build.of(kExprSqrt, sum);
}

std::uint32_t arc_tangent(Formula& formula, const Arguments& a) {
    return a.size() == 1 ? formula.add(kExprAtan, a[0]) : formula.add(kExprAtan2, a[0], a[1]);
}

/// 1 - 2 / (exp(2 a) + 1): finite where exp is not.
std::uint32_t hyperbolic_tangent(Formula& formula, const Arguments& a) {
    Builder build(formula);
    const std::uint32_t grows = build.of(kExprExp, build.scaled(a[0], 2));
    return build.minus(build.number(1),
                       build.scaled(build.reciprocal(build.plus(grows, build.number(1))), 2));
}

std::uint32_t cube_root(Formula& formula, const Arguments& a) {
    Builder build(formula);
    const std::uint32_t root = formula.add_power(build.of(kExprAbs, a[0]), build.number(1.0 / 3));
    return build.times(build.of(kExprSign, a[0]), root);
}

/// smoothstep(low, high, a): 3 t² - 2 t³ of the clamped share t of the way.
std::uint32_t smooth_step(Formula& formula, const Arguments& a) {
    Builder build(formula);
    const std::uint32_t share = build.over(build.minus(a[2], a[0]), build.minus(a[1], a[0]));
    const std::uint32_t t = build.clamp(share, build.number(0), build.number(1));
    return build.times(build.of(kExprSquare, t), build.minus(build.number(3), build.scaled(t, 2)));
}

std::uint32_t mix(Formula& formula, const Arguments& a) {
    Builder build(formula);
    return build.plus(a[0], build.times(a[2], build.minus(a[1], a[0])));
}

std::uint32_t clamp(Formula& formula, const Arguments& a) { return Builder(formula).clamp(a[0], a[1], a[2]); }

std::uint32_t power(Formula& formula, const Arguments& a) { return formula.add_power(a[0], a[1]); }

std::uint32_t reciprocal(Formula& formula, const Arguments& a) { return Builder(formula).reciprocal(a[0]); }

std::uint32_t fraction(Formula& formula, const Arguments& a) {
    Builder build(formula);
    return build.minus(a[0], build.of(kExprFloor, a[0]));
}

std::uint32_t hyperbolic_sine(Formula& formula, const Arguments& a) {
    return Builder(formula).half_exponentials(kExprSubtract, a[0]);
}

std::uint32_t hyperbolic_cosine(Formula& formula, const Arguments& a) {
    return Builder(formula).half_exponentials(kExprAdd, a[0]);
}

std::uint32_t common_logarithm(Formula& formula, const Arguments& a) {
    return Builder(formula).log_of_base(10, a[0]);
}

std::uint32_t binary_logarithm(Formula& formula, const Arguments& a) {
    return Builder(formula).log_of_base(2, a[0]);
}

std::uint32_t to_degrees(Formula& formula, const Arguments& a) {
    return Builder(formula).scaled(a[0], 1 / kRadians);
}

std::uint32_t to_radians(Formula& formula, const Arguments& a) {
    return Builder(formula).scaled(a[0], kRadians);
}

std::uint32_t smooth_minimum(Formula& formula, const Arguments& a) {
    Builder build(formula);
    return build.minus(build.least(a[0], a[1]), build.blend(a[0], a[1], a[2]));
}

std::uint32_t smooth_maximum(Formula& formula, const Arguments& a) {
    Builder build(formula);
    return build.plus(build.largest(a[0], a[1]), build.blend(a[0], a[1], a[2]));
}

}  // namespace

const std::map<std::string, Function>& functions() {
    static const std::map<std::string, Function> all = {
        {"abs", {unary<kExprAbs>, 1, 1}},
        {"acos", {unary<kExprAcos>, 1, 1}},
        {"and", {binary<kExprAnd>, 2, 2}},
        {"asin", {unary<kExprAsin>, 1, 1}},
        {"atan", {arc_tangent, 1, 2}},
        {"atan2", {binary<kExprAtan2>, 2, 2}},
        {"cbrt", {cube_root, 1, 1}},
        {"ceil", {unary<kExprCeil>, 1, 1}},
        {"clamp", {clamp, 3, 3}},
        {"compare", {binary<kExprCompare>, 2, 2}},
        {"cos", {unary<kExprCos>, 1, 1}},
        {"cosh", {hyperbolic_cosine, 1, 1}},
        {"degrees", {to_degrees, 1, 1}},
        {"exp", {unary<kExprExp>, 1, 1}},
        {"floor", {unary<kExprFloor>, 1, 1}},
        {"fract", {fraction, 1, 1}},
        {"hypot", {length, 2, -1}},
        {"length", {length, 2, -1}},
        {"ln", {unary<kExprLog>, 1, 1}},
        {"log", {unary<kExprLog>, 1, 1}},
        {"log10", {common_logarithm, 1, 1}},
        {"log2", {binary_logarithm, 1, 1}},
        {"max", {binary<kExprMax>, 1, -1}},
        {"min", {binary<kExprMin>, 1, -1}},
        {"mix", {mix, 3, 3}},
        {"mod", {binary<kExprMod>, 2, 2}},
        {"neg", {unary<kExprNegate>, 1, 1}},
        {"not", {unary<kExprNot>, 1, 1}},
        {"or", {binary<kExprOr>, 2, 2}},
        {"pow", {power, 2, 2}},
        {"radians", {to_radians, 1, 1}},
        {"recip", {reciprocal, 1, 1}},
        {"round", {unary<kExprRound>, 1, 1}},
        {"sign", {unary<kExprSign>, 1, 1}},
        {"sin", {unary<kExprSin>, 1, 1}},
        {"sinh", {hyperbolic_sine, 1, 1}},
        {"smax", {smooth_maximum, 3, 3}},
        {"smin", {smooth_minimum, 3, 3}},
        {"smoothstep", {smooth_step, 3, 3}},
        {"sqrt", {unary<kExprSqrt>, 1, 1}},
        {"square", {unary<kExprSquare>, 1, 1}},
        {"tan", {unary<kExprTan>, 1, 1}},
        {"tanh", {hyperbolic_tangent, 1, 1}},
    };
    return all;
}

}  // namespace mortise::formula
