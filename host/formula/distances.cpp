// Signed distances of sharp solids.
//
// The distance to a box, and to all that is cut or extruded like one, is written
//     length(max(q1, 0), max(q2, 0), …) + min(max(q1, q2, …), 0),
// the distance outside and that inside. It is one function whose kinks meet in the box's edges, so these
// would be rounded off and saw-toothed. But it has the sign of max(q1, q2, …), and so has the distance plus a
// positive number that of max(…) plus that number: intersections, whose edges are sharp. Less a positive
// number it is a box with rounded edges, and stays as it is.
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "host/common/sort_unique.hpp"
#include "host/formula/formula_set.hpp"

namespace mortise::formula {
namespace {

using Index = std::uint32_t;

class DistanceReplacer {
  public:
    explicit DistanceReplacer(const Formula& formula) : nodes_(formula.nodes()) {
        copy_.reserve(formula.root + 1);
        for (Index i = 0; i <= formula.root; ++i) copy_.push_back(out_.add_copy(nodes_[i], copy_));
        const std::vector<std::uint8_t> in_set = set_nodes(formula);
        std::vector<Index> sign(copy_);
        for (Index i = 0; i <= formula.root; ++i) {
            const Formula::Node& n = nodes_[i];
            if (in_set[i] == 0) continue;
            if (Formula::combines(n))
                sign[i] = out_.add(n.operation, sign[n.a], sign[n.b]);
            else if (n.operation == kExprNegate)
                sign[i] = out_.add(kExprNegate, sign[n.a]);
            else if (const std::optional<Index> same = with_sign_of(i))
                sign[i] = *same;
        }
        out_.root = sign[formula.root];
    }

    /// None if nothing was replaced.
    std::optional<Formula> take() {
        if (!has_replaced_) return std::nullopt;
        return std::move(out_);
    }

  private:
    bool is_constant(Index i) const { return nodes_[i].operation == kExprConstant; }
    bool is_zero(Index i) const { return is_constant(i) && nodes_[i].constant == 0; }

    /// factor * (a distance) + constant.
    struct Linear {
        Index core;
        double factor = 1;
        double constant = 0;
    };
    Linear take_apart(Index i) const {
        Linear linear{i};
        for (;;) {
            const Formula::Node& n = nodes_[linear.core];
            if (n.operation == kExprNegate) {
                linear.factor = -linear.factor;
                linear.core = n.a;
            } else if ((n.operation == kExprAdd || n.operation == kExprSubtract) && is_constant(n.b)) {
                const double by = linear.factor * nodes_[n.b].constant;
                linear.constant += n.operation == kExprAdd ? by : -by;
                linear.core = n.a;
            } else if ((n.operation == kExprAdd || n.operation == kExprSubtract) && is_constant(n.a)) {
                linear.constant += linear.factor * nodes_[n.a].constant;
                if (n.operation == kExprSubtract) linear.factor = -linear.factor;
                linear.core = n.b;
            } else if ((n.operation == kExprMultiply || n.operation == kExprDivide) && is_constant(n.b)) {
                const double by = nodes_[n.b].constant;
                linear.factor = n.operation == kExprMultiply ? linear.factor * by : linear.factor / by;
                linear.core = n.a;
            } else if (n.operation == kExprMultiply && is_constant(n.a)) {
                linear.factor *= nodes_[n.a].constant;
                linear.core = n.b;
            } else {
                return linear;
            }
        }
    }

    /// A node of the new formula with the sign of node i, if it is a distance.
    std::optional<Index> with_sign_of(Index i) {
        const Linear linear = take_apart(i);
        const Formula::Node& n = nodes_[linear.core];
        const double inset = linear.constant / linear.factor;
        if (n.operation != kExprAdd || linear.factor == 0 || !std::isfinite(linear.factor) || !(inset >= 0) ||
            !std::isfinite(inset))
            return std::nullopt;
        for (const auto& [outside, inside] : {std::pair{n.a, n.b}, std::pair{n.b, n.a}}) {
            const std::optional<Index> most = greatest_of(outside, inside);
            if (!most) continue;
            has_replaced_ = true;
            const Index moved = out_.add(kExprAdd, copy_[*most], out_.add_constant(inset));
            return linear.factor < 0 ? out_.add(kExprNegate, moved) : moved;
        }
        return std::nullopt;
    }

    /// m, if `inside` is min(m, 0) and `outside` is 0 exactly where m is not positive, and positive
    /// elsewhere.
    std::optional<Index> greatest_of(Index outside, Index inside) const {
        const Formula::Node& n = nodes_[inside];
        if (n.operation != kExprMin || is_zero(n.a) == is_zero(n.b)) return std::nullopt;
        const Index most = is_zero(n.a) ? n.b : n.a;
        std::vector<Index> excesses, arguments;
        if (!gather_excesses(outside, excesses)) return std::nullopt;
        gather_arguments(most, arguments);
        sort_unique(excesses);
        sort_unique(arguments);
        if (excesses != arguments) return std::nullopt;
        return most;
    }

    /// The arguments of max, through further max.
    void gather_arguments(Index of, std::vector<Index>& found) const {
        for (const Index i : formula::arguments_of(nodes_, of, kExprMax)) found.push_back(i);
    }

    /// Those q of which a node that is not negative is 0 exactly where none is positive; false if it is none
    /// of such.
    bool gather_excesses(Index of, std::vector<Index>& found) const {
        std::vector<Index> open = {of};
        std::set<Index> seen;
        while (!open.empty()) {
            const Index i = open.back();
            const Formula::Node& n = nodes_[i];
            open.pop_back();
            if (!seen.insert(i).second) continue;
            switch (n.operation) {
                case kExprMax:
                    if (is_zero(n.a) == is_zero(n.b)) return false;
                    gather_arguments(is_zero(n.a) ? n.b : n.a, found);
                    break;
                case kExprMultiply:
                    if (n.a != n.b) return false;
                    open.push_back(n.a);
                    break;
                case kExprSqrt:
                case kExprSquare: open.push_back(n.a); break;
                case kExprAdd:
                case kExprHypot: open.insert(open.end(), {n.a, n.b}); break;
                default: return false;
            }
        }
        return true;
    }

    const std::vector<Formula::Node>& nodes_;
    std::vector<Index> copy_;  ///< in the new formula, as they were
    bool has_replaced_ = false;
    Formula out_;
};

}  // namespace

std::optional<Formula> replace_distances(const Formula& formula) { return DistanceReplacer(formula).take(); }

}  // namespace mortise::formula
