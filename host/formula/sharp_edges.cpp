#include "host/formula/formula_set.hpp"

namespace mortise::formula {
namespace {

constexpr int kMostNested = 16;  ///< distances in each other's arguments, as of extruded outlines

}  // namespace

Formula with_sharp_edges(const Formula& formula) {
    Formula sharp = split_absolutes(formula);
    for (int nested = 0; nested < kMostNested; ++nested) {
        const std::optional<Formula> replaced = replace_distances(sharp);
        if (!replaced) break;
        sharp = split_absolutes(*replaced);
    }
    return with_joined_jumps(sharp);
}

}  // namespace mortise::formula
