// Register programs. Evaluation order decides how many registers a program needs: arguments that need more
// come first (Sethi and Ullman 1970; exact for trees, good for graphs). Constants are operands of their
// users.
#include <algorithm>
#include <string>

#include "host/formula/formula.hpp"
#include "mortise/error.hpp"

namespace mortise::formula {
namespace {

using Index = std::uint32_t;

class Emitter {
  public:
    Emitter(const std::vector<Formula::Node>& nodes, Index root) : nodes_(nodes), root_(root) {}

    /// Whether the program fits; `by_need`: in the order above, else in that of the formula.
    bool run(bool by_need, std::vector<ExpressionOp>& program) {
        program.clear();
        order_by(by_need);
        count_uses();
        place_.assign(root_ + 1, 0);
        std::vector<Index> free;
        for (Index r = kExpressionRegisters; r-- > 1;) free.push_back(r);
        for (const Index i : order_) {
            const Formula::Node& n = nodes_[i];
            ExpressionOp op{};
            op.operation = n.operation;
            op.literal = n.constant;
            if (!expression_is_leaf(n.operation)) {
                const bool binary = expression_is_binary(n.operation) != 0;
                op.a = operand(n.a, op);
                op.b = binary ? operand(n.b, op) : op.a;
                release(n.a, free);
                if (binary) release(n.b, free);
            }
            if (i != root_) {  // whose result belongs in register 0
                if (free.empty()) return false;
                place_[i] = free.back();
                free.pop_back();
            }
            op.out = place_[i];
            program.push_back(op);
        }
        return true;
    }

  private:
    bool is_operand(Index i) const { return nodes_[i].operation == kExprConstant; }

    Index operand(Index i, ExpressionOp& op) const {
        if (!is_operand(i)) return place_[i];
        op.literal = nodes_[i].constant;
        return kExpressionLiteral;
    }

    void release(Index i, std::vector<Index>& free) {
        if (!is_operand(i) && --uses_[i] == 0) free.push_back(place_[i]);
    }

    /// Nodes that `root_` needs, arguments before their users.
    void order_by(bool by_need) {
        std::vector<Index> need(root_ + 1, 1);
        for (Index i = 0; i <= root_; ++i) {
            const Formula::Node& n = nodes_[i];
            if (expression_is_leaf(n.operation)) {
                need[i] = is_operand(i) ? 0 : 1;
            } else if (expression_is_binary(n.operation)) {
                const Index p = need[n.a];
                const Index q = need[n.b];
                need[i] = std::max({p, q, std::min(p, q) + 1});
            } else {
                need[i] = std::max<Index>(1, need[n.a]);
            }
        }
        order_.clear();
        std::vector<bool> seen(root_ + 1, false);
        std::vector<std::pair<Index, int>> stack = {{root_, 0}};
        seen[root_] = true;
        while (!stack.empty()) {
            auto& [i, next] = stack.back();
            const Formula::Node& n = nodes_[i];
            const int count =
                expression_is_leaf(n.operation) ? 0 : (expression_is_binary(n.operation) ? 2 : 1);
            if (next == count) {
                order_.push_back(i);
                stack.pop_back();
                continue;
            }
            const bool swapped = count == 2 && need[n.b] > need[n.a];
            const Index child = (next == 0) == swapped ? n.b : n.a;
            ++next;
            if (seen[child] || (is_operand(child) && child != root_)) continue;
            seen[child] = true;
            stack.emplace_back(child, 0);
        }
        if (!by_need) std::sort(order_.begin(), order_.end());
    }

    void count_uses() {
        uses_.assign(root_ + 1, 0);
        for (const Index i : order_) {
            const Formula::Node& n = nodes_[i];
            if (expression_is_leaf(n.operation)) continue;
            ++uses_[n.a];
            if (expression_is_binary(n.operation)) ++uses_[n.b];
        }
    }

    const std::vector<Formula::Node>& nodes_;
    Index root_;
    std::vector<Index> order_;
    std::vector<Index> uses_;
    std::vector<Index> place_;
};

}  // namespace

std::uint32_t emit_formula(const Formula& formula, std::uint32_t node, std::vector<ExpressionOp>& ops,
                           bool negative) {
    std::vector<ExpressionOp> program;
    Emitter emitter(formula.nodes(), node);
    if (!emitter.run(true, program) && !emitter.run(false, program)) {
        throw Error(ExitCode::kInput, "formula needs more than " + std::to_string(kExpressionRegisters) +
                                          " intermediate values at once; split it with min and max");
    }
    if (negative) program.push_back({kExprNegate, 0, 0, 0, 0});
    ops.insert(ops.end(), program.begin(), program.end());
    return static_cast<std::uint32_t>(program.size());
}

}  // namespace mortise::formula
