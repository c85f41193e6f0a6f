// Formulas in x, y, z: parsing, and compilation into the register program of kernels/shared/expression.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/shared/expression.h"

namespace mortise::tape {

/// A parsed formula: operations in one arena, arguments before their users.
struct Formula {
    struct Node {
        std::int32_t operation = kExprConstant;  ///< kExpr… of expression.h
        std::uint32_t a = 0;
        std::uint32_t b = 0;
        double constant = 0;
    };
    std::vector<Node> nodes;
    std::uint32_t root = 0;
};

/// Parses `text`. Grammar: + - * / ^ (integer powers), parentheses, numbers, pi, x y z, and the functions
/// neg abs sqrt square min max sin cos exp log. Throws Error(kInput) naming the column and what was expected.
Formula parse_formula(const std::string& text);

/// Appends the register program of the subexpression `node` to `ops`; returns its length.
/// Throws Error(kInput) if it needs more than kExpressionRegisters registers.
std::uint32_t emit_formula(const Formula& formula, std::uint32_t node, std::vector<ExpressionOp>& ops);

}  // namespace mortise::tape
