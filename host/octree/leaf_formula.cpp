#include "host/octree/leaf_formula.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "host/tape/local_tape.hpp"
#include "host/tape/reference.hpp"
#include "kernels/shared/tape.h"

namespace mortise::octree {

bool LeafFormula::load(std::vector<std::uint32_t> tape) {
    tape_ = std::move(tape);
    const bool is_spatial = std::any_of(
        tape_.begin(), tape_.end(), [](std::uint32_t word) { return tape_operation(word) == kTapeSpatial; });
    list_surfaces();
    return !is_spatial && count() <= kMostSurfaces;
}

void LeafFormula::list_surfaces() { tape::list_surfaces(tape_.data(), tape_.size(), surfaces_); }

std::int32_t LeafFormula::value(std::uint32_t choice) const {
    std::array<std::int8_t, kMostSurfaces> signs{};
    for (std::size_t s = 0; s < count(); ++s) signs[s] = ((choice >> s) & 1u) != 0 ? -1 : 1;
    return tape::evaluate_signs(tape_.data(), tape_.size(), surfaces_.data(), count(), signs.data());
}

std::uint32_t LeafFormula::replaced(std::uint32_t literal, const Substitution& s) const {
    if (tape_surface(literal) != surfaces_[s.gone]) return literal;
    return make_literal(surfaces_[s.by], tape_negated(literal) ^ (s.negated ? 1u : 0u));
}

void LeafFormula::substitute(const Substitution& s) {
    for (std::uint32_t& word : tape_) {
        if (tape_operation(word) == kTapeLiteral) word = replaced(word, s);
    }
    list_surfaces();
}

LeafFormula::Part LeafFormula::combined(std::uint32_t operation, Part a, Part b) {
    if (b.is_constant) std::swap(a, b);
    if (a.is_constant) return a.value == (operation == kTapeAnd) ? b : a;
    if (a.words == b.words) return a;
    a.words.insert(a.words.end(), b.words.begin(), b.words.end());
    a.words.push_back(make_operation(operation, 0, 0));
    return a;
}

/// The truth value that the last word turns into a region, on one side of a surface.
LeafFormula::Part LeafFormula::restricted(std::size_t surface, bool inside, const Substitution& s) const {
    std::vector<Part> stack;
    for (std::size_t i = 0; i + 1 < tape_.size(); ++i) {
        if (tape_operation(tape_[i]) == kTapeLiteral) {
            const std::uint32_t literal = replaced(tape_[i], s);
            if (tape_surface(literal) == surfaces_[surface])
                stack.push_back({true, inside != (tape_negated(literal) != 0), {}});
            else
                stack.push_back({false, false, {literal}});
            continue;
        }
        Part b = std::move(stack.back());
        stack.pop_back();
        stack.back() = combined(tape_operation(tape_[i]), std::move(stack.back()), std::move(b));
    }
    return std::move(stack.back());
}

bool LeafFormula::has_one_select() const {
    return tape_operation(tape_.back()) == kTapeSelectConst &&
           std::none_of(tape_.begin(), tape_.end() - 1, [](std::uint32_t word) {
               return tape_operation(word) == kTapeSelect || tape_operation(word) == kTapeSelectConst;
           });
}

std::vector<std::uint32_t> LeafFormula::joined(const Substitution& s, std::size_t free,
                                               std::uint32_t renamed) const {
    if (!has_one_select()) return {};
    for (std::uint32_t choice = 0; choice < (1u << count()); ++choice) {
        const bool tied = (((choice >> s.gone) ^ (choice >> s.by)) & 1u) == (s.negated ? 1u : 0u);
        if (tied && value(choice) != value(choice ^ (1u << free))) return {};
    }
    Part part = restricted(free, true, s);
    if (part.is_constant) return {};
    for (std::uint32_t& word : part.words) {
        if (tape_operation(word) == kTapeLiteral && tape_surface(word) == surfaces_[s.by])
            word = make_literal(renamed, tape_negated(word));
    }
    part.words.push_back(tape_.back());
    return std::move(part.words);
}

bool LeafFormula::choose(std::size_t chooser, const Substitution& inside, const Substitution& outside) {
    if (!has_one_select()) return false;
    const std::uint32_t last = tape_.back();
    const auto side = [&](bool is_inside, const Substitution& s) {
        const Part chosen{false, false, {make_literal(surfaces_[chooser], is_inside ? 0 : 1)}};
        return combined(kTapeAnd, chosen, restricted(chooser, is_inside, s));
    };
    Part whole = combined(kTapeOr, side(true, inside), side(false, outside));
    if (whole.is_constant) return false;
    whole.words.push_back(last);
    if (whole.words == tape_) return false;
    tape_ = std::move(whole.words);
    list_surfaces();
    return true;
}

}  // namespace mortise::octree
