// Functions that jump, but whose min or max does not.
//
// Space is often repeated by mod: the rods of a lattice are min(a, b, c, d) in a cell, and where one cell
// ends the next rod goes on where the last one stopped. Each function alone jumps there, and its set would
// have a face; the min is continuous. So arguments of a min or max that jump stay one surface together, if
// their min or max is found to be continuous wherever they are found to jump. Others are sets of their own,
// and so are those whose faces are meant (steps), and those that have sharp edges of their own (square
// rods), which would be rounded off.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "host/formula/formula_set.hpp"

namespace mortise::formula {
namespace {

using Index = std::uint32_t;

/// Lines on which jumps are looked for: so many for each power of ten as length, in so many steps.
constexpr int kLeastPower = -2, kMostPower = 4;
constexpr int kLines = 16, kSteps = 48;
constexpr int kHalvings = 50;                         ///< of a step in which something jumps
constexpr std::uint64_t kMostEvaluated = 30'000'000;  ///< operations
constexpr std::size_t kMostNumbers = 4'000'000;       ///< values that are kept
constexpr int kLeastLines = 4;                        ///< of each length, or too little is known
constexpr double kSame = 1e-6;  ///< relative difference of the values beside a jump that is none

/// Which nodes have an operation that steps below them, or are one.
std::vector<std::uint8_t> find_steps(const Formula& formula) {
    std::vector<std::uint8_t> found(formula.root + 1, 0);
    for (Index i = 0; i <= formula.root; ++i) {
        const Formula::Node& n = formula.nodes()[i];
        if (expression_is_leaf(n.operation)) continue;
        found[i] = Formula::steps(n.operation) || found[n.a] != 0 ||
                           (expression_is_binary(n.operation) != 0 && found[n.b] != 0)
                       ? 1
                       : 0;
    }
    return found;
}

/// Values of all nodes at places where one of them jumps, on either side.
class JumpSearch {
  public:
    struct Place {
        std::vector<double> before, behind;
    };

    explicit JumpSearch(const Formula& formula) : nodes_(formula.nodes()), count_(formula.root + 1) {
        for (Index i = 0; i < count_; ++i) {
            if (Formula::steps(nodes_[i].operation)) stepping_.push_back(i);
        }
        for (; lines_ < kLines && !is_spent(); ++lines_) {
            for (int power = kLeastPower; power <= kMostPower; ++power) search_line(std::pow(10.0, power));
        }
    }

    /// Whether enough has been looked at.
    bool is_whole() const { return lines_ >= kLeastLines; }

    const std::vector<Place>& places() const { return places_; }

  private:
    using Point = std::array<double, 3>;

    /// Between -1 and 1, the same in every run.
    double next_number() {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return std::ldexp(static_cast<double>(state_ >> 11), -52) - 1;
    }

    std::vector<double> values_at(const Point& x) {
        std::vector<double> value(count_);
        for (Index i = 0; i < count_; ++i) {
            const Formula::Node& n = nodes_[i];
            if (n.operation == kExprConstant)
                value[i] = n.constant;
            else if (expression_is_leaf(n.operation))
                value[i] = x[n.operation == kExprX ? 0 : n.operation == kExprY ? 1 : 2];
            else
                value[i] = expression_apply(n.operation, value[n.a],
                                            value[expression_is_binary(n.operation) != 0 ? n.b : n.a]);
        }
        evaluated_ += count_;
        return value;
    }

    bool is_spent() const {
        return evaluated_ > kMostEvaluated || 2 * count_ * places_.size() > kMostNumbers;
    }

    /// Whether a node stands on another step of its staircase.
    bool has_stepped(Index i, const std::vector<double>& p, const std::vector<double>& q) const {
        const Formula::Node& n = nodes_[i];
        const auto step = [&n](const std::vector<double>& value) {
            return std::floor(value[n.a] / std::fabs(value[n.b]));
        };
        if (n.operation == kExprMod) return step(p) != step(q);
        if (n.operation == kExprAtan2) return p[n.b] < 0 && q[n.b] < 0 && (p[n.a] < 0) != (q[n.a] < 0);
        if (n.operation == kExprAnd || n.operation == kExprOr) return (p[n.a] == 0) != (q[n.a] == 0);
        return p[i] != q[i];
    }

    void search_line(double size) {
        Point from{}, to{};
        for (Point* end : {&from, &to}) {
            for (double& x : *end) x = size * next_number();
        }
        const auto at = [&](double t) {
            return values_at({from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]),
                              from[2] + t * (to[2] - from[2])});
        };
        std::vector<std::uint8_t> is_found(count_, 0);
        std::vector<double> last = at(0);
        for (int k = 1; k <= kSteps; ++k) {
            std::vector<double> here = at(static_cast<double>(k) / kSteps);
            for (const Index i : stepping_) {
                if (is_spent()) return;
                if (is_found[i] != 0 || !has_stepped(i, last, here)) continue;
                is_found[i] = 1;
                double low = static_cast<double>(k - 1) / kSteps, high = static_cast<double>(k) / kSteps;
                Place place{last, here};
                for (int h = 0; h < kHalvings; ++h) {
                    const double middle = 0.5 * (low + high);
                    std::vector<double> value = at(middle);
                    const bool is_before = !has_stepped(i, place.before, value);
                    (is_before ? low : high) = middle;
                    (is_before ? place.before : place.behind) = std::move(value);
                }
                places_.push_back(std::move(place));
            }
            last = std::move(here);
        }
    }

    const std::vector<Formula::Node>& nodes_;
    const std::size_t count_;
    std::vector<Index> stepping_;
    std::vector<Place> places_;
    int lines_ = 0;  ///< of each length
    std::uint64_t evaluated_ = 0;
    std::uint64_t state_ = 1;
};

/// Also where a value is infinite, or none.
bool is_jump(double before, double behind) {
    return before != behind &&
           !(std::fabs(before - behind) <= kSame * std::max(std::fabs(before), std::fabs(behind)));
}

/// Rebuilds a formula with such arguments side by side.
class Joiner {
  public:
    explicit Joiner(const Formula& formula)
        : nodes_(formula.nodes()), search_(formula), in_set_(set_nodes(formula)) {
        const std::vector<std::uint8_t> may_jump = find_steps(formula);
        for (Index i = 0; i <= formula.root; ++i) copy_.push_back(out_.add_copy(nodes_[i], copy_));
        find_tops(formula.root);
        std::vector<Index> made(copy_);
        for (Index i = 0; i <= formula.root; ++i) {
            const Formula::Node& n = nodes_[i];
            if (in_set_[i] == 0) continue;
            if (n.operation == kExprNegate) made[i] = out_.add(kExprNegate, made[n.a]);
            if (is_top_[i] != 0) made[i] = tree(i, may_jump, made);
        }
        out_.root = made[formula.root];
    }

    /// None if there are none.
    std::optional<Formula> take() {
        if (!has_joined_) return std::nullopt;
        return std::move(out_);
    }

  private:
    /// Marks the topmost of each run of min or max that is reached from the root.
    void find_tops(Index root) {
        is_top_.assign(root + 1, 0);
        is_top_[root] = Formula::combines(nodes_[root]) ? 1 : 0;
        for (Index i = 0; i <= root; ++i) {
            const Formula::Node& n = nodes_[i];
            if (in_set_[i] == 0 || (!Formula::combines(n) && n.operation != kExprNegate)) continue;
            for (const Index argument : {n.a, n.operation == kExprNegate ? n.a : n.b}) {
                const Formula::Node& below = nodes_[argument];
                if (Formula::combines(below) && below.operation != n.operation) is_top_[argument] = 1;
            }
        }
    }

    Index tree(Index top, const std::vector<std::uint8_t>& may_jump, const std::vector<Index>& made) {
        const std::int32_t operation = nodes_[top].operation;
        std::vector<Index> joined, apart;
        for (const Index argument : arguments_of(nodes_, top, operation))
            (may_jump[argument] != 0 && jumps(argument) ? joined : apart).push_back(argument);
        const bool has_own_edges = std::any_of(joined.begin(), joined.end(), [&](Index i) {
            while (nodes_[i].operation == kExprNegate) i = nodes_[i].a;
            return Formula::combines(nodes_[i]);
        });
        if (joined.size() < 2 || has_own_edges || !search_.is_whole() || !are_continuous(operation, joined)) {
            apart.insert(apart.end(), joined.begin(), joined.end());
            std::sort(apart.begin(), apart.end());
            joined.clear();
        }
        std::optional<Index> result;
        const auto add = [&](Index argument) {
            result = result ? out_.add(operation, *result, argument) : argument;
        };
        for (const Index argument : joined) add(copy_[argument]);
        if (result) {
            out_.keep_whole(*result);
            has_joined_ = true;
        }
        for (const Index argument : apart) add(made[argument]);
        return *result;
    }

    bool jumps(Index i) const {
        return std::any_of(
            search_.places().begin(), search_.places().end(),
            [i](const JumpSearch::Place& place) { return is_jump(place.before[i], place.behind[i]); });
    }

    /// Whether min, or max, of these never jumps.
    bool are_continuous(std::int32_t operation, const std::vector<Index>& arguments) const {
        const auto combined = [&](const std::vector<double>& value) {
            double result = value[arguments[0]];
            for (const Index i : arguments) result = expression_apply(operation, result, value[i]);
            return result;
        };
        return std::none_of(search_.places().begin(), search_.places().end(),
                            [&](const JumpSearch::Place& place) {
                                return is_jump(combined(place.before), combined(place.behind));
                            });
    }

    const std::vector<Formula::Node>& nodes_;
    JumpSearch search_;
    std::vector<Index> copy_;  ///< in the new formula, as they were
    const std::vector<std::uint8_t> in_set_;
    std::vector<std::uint8_t> is_top_;
    bool has_joined_ = false;
    Formula out_;
};

}  // namespace

Formula with_joined_jumps(const Formula& formula) {
    if (find_steps(formula)[formula.root] == 0) return formula;
    return Joiner(formula).take().value_or(formula);
}

}  // namespace mortise::formula
