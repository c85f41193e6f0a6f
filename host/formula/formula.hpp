// A formula as a graph of operations, and its register program for kernels/shared/expression.h.
#pragma once

#include <cstdint>
#include <set>
#include <unordered_map>
#include <vector>

#include "kernels/shared/expression.h"

namespace mortise::formula {

/// Operations in one arena, arguments before their users. Equal operations are one node, and those of
/// constants are constants: the same bits as if they were evaluated with the rest.
class Formula {
  public:
    struct Node {
        std::int32_t operation = kExprConstant;  ///< kExpr… of expression.h
        std::uint32_t a = 0;
        std::uint32_t b = 0;  ///< operations of one argument: 0
        double constant = 0;
    };

    std::uint32_t add(std::int32_t operation, std::uint32_t a = 0, std::uint32_t b = 0);
    std::uint32_t add_constant(double value);
    /// A node of another formula, the copies of whose arguments are here.
    std::uint32_t add_copy(const Node& node, const std::vector<std::uint32_t>& copies);
    /// a^b: products for small whole exponents.
    std::uint32_t add_power(std::uint32_t a, std::uint32_t b);

    /// Min and max, which are set operations where only signs count.
    static bool combines(const Node& node) {
        return node.operation == kExprMin || node.operation == kExprMax;
    }

    /// A min or max that is no set operation, but one surface.
    void keep_whole(std::uint32_t node) { whole_.insert(node); }
    bool is_whole(std::uint32_t node) const { return whole_.count(node) != 0; }

    /// Whether an operation may jump where its arguments do not: steps and branches.
    static bool steps(std::int32_t operation);

    const std::vector<Node>& nodes() const { return nodes_; }
    std::uint32_t root = 0;

  private:
    struct Hash {
        std::size_t operator()(const Node& node) const;
    };
    struct Equal {
        bool operator()(const Node& p, const Node& q) const;
    };
    std::uint32_t find_or_add(const Node& node);

    std::vector<Node> nodes_;
    std::set<std::uint32_t> whole_;
    std::unordered_map<Node, std::uint32_t, Hash, Equal> places_;
};

/// Appends the register program of the subexpression `node`, or of its negative, to `ops`; returns its
/// length. Throws Error(kInput) if it needs more than kExpressionRegisters registers.
std::uint32_t emit_formula(const Formula& formula, std::uint32_t node, std::vector<ExpressionOp>& ops,
                           bool negative = false);

}  // namespace mortise::formula
