// A formula as steps on blocks of lanes (lanes.hpp). In a grid a step that depends on one coordinate only is
// done once for each plane of cells: a table.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/tape/lanes.hpp"
#include "host/tape/surface_batch.hpp"

namespace mortise::tape {

template <class Lanes>
class ExpressionProgram {
  public:
    using Block = typename Lanes::Block;
    using Input = typename Lanes::Input;

    /// Without a grid: `side` 0. `planes(i, axis, k)` is coordinate u[i] in plane k across an axis.
    template <class Planes>
    void prepare(const Surface& s, const ExpressionOp* ops, std::size_t side, const Planes& planes) {
        steps_.resize(s.op_count);
        if (side > 0) tables_.resize(std::max<std::size_t>(tables_.size(), s.op_count));
        blocks_.resize(kExpressionRegisters + 4);
        result_ = {Operand::kLiteral, 0};
        needs_coordinates_ = false;
        Operand writer[kExpressionRegisters];
        unsigned writer_axes[kExpressionRegisters];
        for (std::uint32_t i = 0; i < s.op_count; ++i) {
            Step& step = steps_[i];
            step.op = ops[s.first_op + i];
            unsigned axes = 0;
            if (expression_is_leaf(step.op.operation) == 0) {
                const auto take = [&](std::uint32_t source) {
                    if (source == kExpressionLiteral) return Operand{Operand::kLiteral, 0};
                    axes |= writer_axes[source];
                    return writer[source];
                };
                step.a = take(step.op.a);
                step.b = expression_is_binary(step.op.operation) != 0 ? take(step.op.b) : step.a;
            } else if (step.op.operation != kExprConstant) {
                for (unsigned j = 0; j < 3; ++j)
                    axes |= s.map[4 * (step.op.operation - kExprX) + static_cast<int>(j)] != 0 ? 1u << j : 0;
            }
            step.axis = side == 0 || (axes & (axes - 1)) != 0 ? -1 : axes == 4 ? 2 : axes == 2 ? 1 : 0;
            writer[step.op.out] =
                step.axis < 0 ? Operand{Operand::kBlock, step.op.out} : Operand{Operand::kTable, i};
            writer_axes[step.op.out] = axes;
            if (step.axis >= 0)
                fill_table(i, side, planes);
            else if (expression_is_leaf(step.op.operation) != 0)
                needs_coordinates_ = true;
        }
        if (s.op_count > 0) result_ = writer[0];
        for (std::uint32_t r = 0; r <= kExpressionRegisters; ++r) place_[r] = r;
    }

    /// Whether run() reads coordinates; else all are in tables.
    bool needs_coordinates() const { return needs_coordinates_; }

    /// For up to kLanes lanes; `places`, of a grid, and u, for each lane.
    const Block& run(std::size_t n, const GridPlace* places, const Input (*u)[3]) {
        for (const Step& step : steps_) {
            if (step.axis >= 0) continue;
            Block& out = blocks_[place_[kExpressionRegisters]];  // the spare one
            if (step.op.operation == kExprConstant) {
                fill(out, n, step.op.literal);
            } else if (expression_is_leaf(step.op.operation) != 0) {
                const int i = step.op.operation - kExprX;
                for (std::size_t k = 0; k < n; ++k) Lanes::set_variable(out, k, i, u[k][i]);
                Lanes::finish(out, n);
            } else {
                const Block& a = operand(step.a, step.op.literal, n, places, blocks_[kFirst]);
                const Block& b =
                    step.b == step.a ? a : operand(step.b, step.op.literal, n, places, blocks_[kSecond]);
                Lanes::apply(step.op.operation, a, b, out, n);
            }
            std::swap(place_[step.op.out], place_[kExpressionRegisters]);
        }
        return operand(result_, 0, n, places, blocks_[kFirst]);
    }

  private:
    static constexpr std::uint32_t kFirst = kExpressionRegisters + 1;
    static constexpr std::uint32_t kSecond = kExpressionRegisters + 2;

    struct Operand {
        enum Kind : std::uint32_t { kLiteral, kTable, kBlock } kind;
        std::uint32_t index;  ///< step of the table, register of the block
        bool operator==(const Operand& o) const { return kind == o.kind && index == o.index; }
    };
    struct Step {
        ExpressionOp op;
        Operand a, b;
        int axis;  ///< its table's, else -1
    };

    static void fill(Block& block, std::size_t n, double literal) {
        for (std::size_t k = 0; k < n; ++k) Lanes::set_literal(block, k, literal);
        Lanes::finish(block, n);
    }

    template <class Planes>
    void fill_table(std::uint32_t i, std::size_t side, const Planes& planes) {
        const Step& step = steps_[i];
        Block& out = tables_[i];
        if (step.op.operation == kExprConstant) {
            fill(out, side, step.op.literal);
        } else if (expression_is_leaf(step.op.operation) != 0) {
            const int j = step.op.operation - kExprX;
            for (std::size_t k = 0; k < side; ++k)
                Lanes::set_variable(
                    out, k, j, planes(static_cast<std::size_t>(j), static_cast<std::size_t>(step.axis), k));
            Lanes::finish(out, side);
        } else {
            const auto source = [&](const Operand& from, Block& scratch) -> const Block& {
                if (from.kind == Operand::kTable) return tables_[from.index];
                fill(scratch, side, step.op.literal);
                return scratch;
            };
            const Block& a = source(step.a, blocks_[kFirst]);
            Lanes::apply(step.op.operation, a, source(step.b, blocks_[kSecond]), out, side);
        }
    }

    const Block& operand(const Operand& from, double literal, std::size_t n, const GridPlace* places,
                         Block& scratch) {
        if (from.kind == Operand::kBlock) return blocks_[place_[from.index]];
        if (from.kind == Operand::kLiteral) {
            fill(scratch, n, literal);
            return scratch;
        }
        const Block& table = tables_[from.index];
        const int axis = steps_[from.index].axis;
        for (std::size_t k = 0; k < n; ++k) Lanes::copy(table, places[k].at[axis], scratch, k);
        Lanes::finish(scratch, n);
        return scratch;
    }

    std::vector<Step> steps_;
    std::vector<Block> tables_;  ///< by step; never fewer, since new ones are cleared
    std::vector<Block> blocks_;  ///< of registers by place_, one spare, scratch for two operands
    std::uint32_t place_[kExpressionRegisters + 1] = {};
    bool needs_coordinates_ = false;
    Operand result_{Operand::kLiteral, 0};
};

}  // namespace mortise::tape
