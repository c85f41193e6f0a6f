// A formula as a set { f <= 0 }, and what brings up its sharp edges before (docs/design/models.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/formula/formula.hpp"

namespace mortise::formula {

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

/// The same function, to the last bit, with summands without kinks taken into min and max, and with |a| as
/// max(a, -a) where that can come before all sums and multiples by constants, so that formula_set() tells the
/// two sides of a sheet |a| <= t apart.
Formula split_absolutes(const Formula& formula);

/// A function of the same sign, with signed distances of sharp solids, as of boxes, replaced by the max that
/// they are the distance to; none if there are none.
std::optional<Formula> replace_distances(const Formula& formula);

/// The same function, with arguments of min or max that jump where their min or max does not side by side,
/// and kept whole.
Formula with_joined_jumps(const Formula& formula);

/// All of these, as often as there is something to do: what formula_set() is to be made of.
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

}  // namespace mortise::formula
