#include "host/formula/formula.hpp"

#include <cmath>
#include <functional>

namespace mortise::formula {
namespace {

constexpr double kLargestProductExponent = 64;

}  // namespace

std::size_t Formula::Hash::operator()(const Node& node) const {
    std::size_t hash = std::hash<std::int64_t>()(mortise_bits(node.constant));
    for (const std::uint32_t part : {static_cast<std::uint32_t>(node.operation), node.a, node.b})
        hash = (hash ^ part) * 0x9e3779b97f4a7c15u + (hash >> 29);
    return hash;
}

bool Formula::Equal::operator()(const Node& p, const Node& q) const {
    return p.operation == q.operation && p.a == q.a && p.b == q.b &&
           mortise_bits(p.constant) == mortise_bits(q.constant);
}

std::uint32_t Formula::find_or_add(const Node& node) {
    const auto [entry, is_new] = places_.try_emplace(node, static_cast<std::uint32_t>(nodes_.size()));
    if (is_new) nodes_.push_back(node);
    return entry->second;
}

bool Formula::steps(std::int32_t operation) {
    switch (operation) {
        case kExprFloor:
        case kExprCeil:
        case kExprRound:
        case kExprSign:
        case kExprNot:
        case kExprAtan2:
        case kExprMod:
        case kExprCompare:
        case kExprAnd:
        case kExprOr: return true;
        default: return false;
    }
}

std::uint32_t Formula::add_constant(double value) { return find_or_add({kExprConstant, 0, 0, value}); }

std::uint32_t Formula::add_copy(const Node& node, const std::vector<std::uint32_t>& copies) {
    if (node.operation == kExprConstant) return add_constant(node.constant);
    if (expression_is_leaf(node.operation)) return add(node.operation);
    const bool binary = expression_is_binary(node.operation) != 0;
    return add(node.operation, copies[node.a], copies[binary ? node.b : node.a]);
}

std::uint32_t Formula::add(std::int32_t operation, std::uint32_t a, std::uint32_t b) {
    if (expression_is_leaf(operation)) return find_or_add({operation, 0, 0, 0});
    const bool binary = expression_is_binary(operation) != 0;
    const Node p = nodes_[a];
    const Node q = nodes_[binary ? b : a];
    if (p.operation == kExprConstant && q.operation == kExprConstant)
        return add_constant(expression_apply(operation, p.constant, q.constant));
    if (operation == kExprNegate && p.operation == kExprNegate) return p.a;
    if ((operation == kExprMin || operation == kExprMax) && a == b) return a;
    const auto is = [](const Node& node, double value) {
        return node.operation == kExprConstant && node.constant == value;
    };
    if ((operation == kExprAdd || operation == kExprSubtract) && is(q, 0)) return a;
    if (operation == kExprAdd && is(p, 0)) return b;
    if ((operation == kExprMultiply || operation == kExprDivide) && is(q, 1)) return a;
    if (operation == kExprMultiply && is(p, 1)) return b;
    return find_or_add({operation, a, binary ? b : 0, 0});
}

std::uint32_t Formula::add_power(std::uint32_t a, std::uint32_t b) {
    const Node exponent = nodes_[b];
    const double n = std::fabs(exponent.constant);
    if (exponent.operation != kExprConstant) return add(kExprPower, a, b);
    if (exponent.constant == 0.5) return add(kExprSqrt, a);
    if (n != std::floor(n) || n > kLargestProductExponent || n == 0) return add(kExprPower, a, b);
    const auto bits = static_cast<unsigned>(n);
    std::uint32_t result = a;
    for (int bit = 30 - __builtin_clz(bits); bit >= 0; --bit) {
        result = add(kExprSquare, result);
        if (((bits >> bit) & 1u) != 0) result = add(kExprMultiply, result, a);
    }
    return exponent.constant < 0 ? add(kExprDivide, add_constant(1), result) : result;
}

}  // namespace mortise::formula
