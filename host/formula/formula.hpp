// A formula as a graph of operations, and its register program for kernels/shared/expression.h.
#pragma once

#include <algorithm>
#include <cstdint>
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
    void keep_whole(std::uint32_t node) { whole_.push_back(node); }
    bool is_whole(std::uint32_t node) const {
        return std::find(whole_.begin(), whole_.end(), node) != whole_.end();
    }

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
    std::vector<std::uint32_t> whole_;
    std::unordered_map<Node, std::uint32_t, Hash, Equal> places_;
};

/// What the min or max (`operation`) at `of` is of, through further ones of the same kind: ascending, each
/// once.
std::vector<std::uint32_t> arguments_of(const std::vector<Formula::Node>& nodes, std::uint32_t of,
                                        std::int32_t operation);

/// Per node up to the root whether it is reached from there through min, max and neg alone: of these, and of
/// what they are of, only the sign counts.
std::vector<std::uint8_t> set_nodes(const Formula& formula);

/// Which nodes cannot be negative, and which may not be a number for numbers x, y, z.
struct Signs {
    std::vector<bool> nonnegative;
    std::vector<bool> partial;

    explicit Signs(const std::vector<Formula::Node>& nodes);
};

/// The same function, to the last bit, with |a| as max(a, -a) where that can come before all sums and
/// multiples by constants, so that formula_set() tells the two sides of a sheet |a| <= t apart.
Formula split_absolutes(const Formula& formula);

/// The same function, with arguments of min or max that jump where their min or max does not side by side,
/// and kept whole.
Formula with_joined_jumps(const Formula& formula);

/// A function of the same sign for formula_set(): with absolutes split, signed distances of sharp solids, as
/// of boxes, replaced by the max that they are the distance to, and jumps joined.
Formula with_sharp_edges(const Formula& formula);

/// What a formula is as a set { f <= 0 }: min and max that are reached from the root through each other and
/// through changes of sign are unions and intersections of surfaces.
struct FormulaSet {
    enum class Kind : std::uint8_t { kSurface, kUnion, kIntersection };
    struct Node {
        Kind kind = Kind::kSurface;
        std::uint32_t a = 0;   ///< kSurface: node of the formula; else index of a node here
        std::uint32_t b = 0;   ///< unions and intersections only
        bool negated = false;  ///< kSurface: the set is { -f <= 0 }
        /// KSurface: f may not be a number, which is outside of { f <= 0 } and { -f <= 0 }.
        bool partial = false;
    };
    std::vector<Node> nodes;  ///< children first, the last one is the whole set; shared ones occur once
};

/// Shared min and max are expanded while the tree they make stays within a few times the formula's length;
/// beyond that they stay inside the function of one surface, which then has kinks.
FormulaSet formula_set(const Formula& formula);

/// Appends the register program of the subexpression `node`, or of its negative, to `ops`; returns its
/// length. Throws Error(kInput) if it needs more than kExpressionRegisters registers.
std::uint32_t emit_formula(const Formula& formula, std::uint32_t node, std::vector<ExpressionOp>& ops,
                           bool negative = false);

}  // namespace mortise::formula
