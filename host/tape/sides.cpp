#include "host/tape/sides.hpp"

#include <algorithm>
#include <utility>

namespace mortise::tape {
namespace {

/// An operand on the tape's stack: literals that one operation joins, so far.
struct Operand {
    std::uint32_t operation;  ///< kTapeAnd, kTapeOr; kTapeLiteral: one literal, or none
    std::vector<std::uint32_t> literals;
};

class SideFinder {
  public:
    explicit SideFinder(CompiledModel& model) : model_(model) {
        model.sides.clear();
        model.sides_of.assign(model.surfaces.size(), CompiledModel::kNoSides);
    }

    void run() {
        for (const std::uint32_t word : model_.tape) {
            const std::uint32_t operation = tape_operation(word);
            if (operation == kTapeLiteral) {
                stack_.push_back({kTapeLiteral, {word}});
            } else if (operation == kTapeSpatial) {
                stack_.push_back({kTapeLiteral, {}});
            } else if (operation == kTapeAnd || operation == kTapeOr) {
                join(operation);
            } else {
                end(pop());
                if (operation == kTapeSelect) pop();  // the regions after this one, which are ended
                stack_.push_back({kTapeLiteral, {}});
            }
        }
    }

  private:
    Operand pop() {
        Operand top = std::move(stack_.back());
        stack_.pop_back();
        return top;
    }

    void join(std::uint32_t operation) {
        Operand b = pop(), a = pop();
        for (Operand* operand : {&a, &b}) {
            if (operand->operation == operation || operand->operation == kTapeLiteral) continue;
            end(std::move(*operand));
            operand->literals.clear();
        }
        if (a.literals.size() < b.literals.size()) std::swap(a, b);
        a.operation = operation;
        a.literals.insert(a.literals.end(), b.literals.begin(), b.literals.end());
        stack_.push_back(std::move(a));
    }

    void end(Operand operand) {
        if (operand.literals.empty()) return;
        for (const std::uint32_t literal : operand.literals)
            model_.sides_of[tape_surface(literal)] = static_cast<std::uint32_t>(model_.sides.size());
        std::sort(operand.literals.begin(), operand.literals.end());
        model_.sides.push_back({operand.operation != kTapeOr, std::move(operand.literals)});
    }

    CompiledModel& model_;
    std::vector<Operand> stack_;
};

}  // namespace

void find_sides(CompiledModel& model) { SideFinder(model).run(); }

}  // namespace mortise::tape
