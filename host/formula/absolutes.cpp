// Absolute values as the greater of a function and its negative, and max and min before constants.
//
// { |g| - t <= 0 } is a sheet with two sides, { |x| + |y| <= 1 } a prism with edges. As the set of one
// function with kinks, both sides would be one surface, whose samples in a cell do not see a thin sheet, and
// edges would be rounded. Sums, differences and multiples by constants are taken into max and min; rounding
// is monotone, so every value stays the same to the last bit. So are functions without kinks that are added
// to other max and min: max(|x|, |y|, |z|) - 1 is a cube, and stays one under ripples. Those with kinks are
// not: min(a, b) - h(|a - b|) is a smooth union. A function that jumps stays inside its absolute value:
// |mod(x, 1) - 1/2| is continuous, its two sides are not.
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/formula/formula_set.hpp"

namespace mortise::formula {
namespace {

using Index = std::uint32_t;

constexpr std::uint32_t kMostTerms = 16;    ///< that one sum may become: four absolute values
constexpr std::uint32_t kMostLeaves = 256;  ///< that are visited for one sum

class AbsoluteSplitter {
  public:
    explicit AbsoluteSplitter(const Formula& formula) : nodes_(formula.nodes()), signs_(formula.nodes()) {
        split_.resize(formula.root + 1);
        find_jumps(formula.root);
        find_kinks(formula.root);
        count_uses(formula.root);
        for (Index i = 0; i <= formula.root; ++i) split_[i] = split(nodes_[i]);
        out_.root = split_[formula.root].whole;
    }
    Formula take() { return std::move(out_); }

  private:
    /// A node of the formula in the new one.
    struct Split {
        Index plain = 0;          ///< as it was
        Index whole = 0;          ///< max and min at its top
        std::uint32_t terms = 1;  ///< of `whole`, if a sum may be taken into it; 1: it may not, or need not
        /// The same, if a function without kinks may be: max and min of any origin count, where one with
        /// kinks may make a smooth union of them.
        std::uint32_t parts = 1;
        std::uint32_t leaves = 1;  ///< below max and min at the top of `whole`; kMany: as many, or more
    };
    static constexpr std::uint32_t kMany = 1u << 12;

    /// Which nodes may jump where their arguments do not: steps, branches, poles.
    void find_jumps(Index root) {
        jumps_.assign(root + 1, 0);
        for (Index i = 0; i <= root; ++i) {
            const Formula::Node& n = nodes_[i];
            if (expression_is_leaf(n.operation)) continue;
            if (Formula::steps(n.operation)) {
                jumps_[i] = 1;
                continue;
            }
            switch (n.operation) {
                case kExprTan: jumps_[i] = 1; break;
                case kExprDivide: jumps_[i] = is_constant(n.b) ? jumps_[n.a] : std::uint8_t{1}; break;
                case kExprPower:
                    jumps_[i] = jumps_[n.a] | (is_constant(n.b) && nodes_[n.b].constant >= 0 ? 0 : 1);
                    break;
                default:
                    jumps_[i] = jumps_[n.a];
                    if (expression_is_binary(n.operation) != 0) jumps_[i] |= jumps_[n.b];
            }
        }
    }

    /// Which nodes may have kinks.
    void find_kinks(Index root) {
        kinks_.assign(root + 1, 0);
        for (Index i = 0; i <= root; ++i) {
            const Formula::Node& n = nodes_[i];
            if (expression_is_leaf(n.operation)) continue;
            kinks_[i] = jumps_[i] | kinks_[n.a];
            if (expression_is_binary(n.operation) != 0) kinks_[i] |= kinks_[n.b];
            switch (n.operation) {
                case kExprAbs:
                case kExprMin:
                case kExprMax:
                case kExprAsin:
                case kExprAcos: kinks_[i] = 1; break;
                case kExprHypot: kinks_[i] |= is_constant(n.a) || is_constant(n.b) ? 1 : 0; break;
                case kExprSqrt: kinks_[i] |= is_square(nodes_[n.a]) ? 1 : 0; break;
                default: break;
            }
        }
    }
    void count_uses(Index root) {
        uses_.assign(root + 1, 0);
        for (Index i = root + 1; i-- > 0;) {
            const Formula::Node& n = nodes_[i];
            if (expression_is_leaf(n.operation) || (i < root && uses_[i] == 0)) continue;
            ++uses_[n.a];
            if (expression_is_binary(n.operation) != 0) ++uses_[n.b];
        }
    }

    static bool is_square(const Formula::Node& n) {
        return n.operation == kExprSquare || (n.operation == kExprMultiply && n.a == n.b);
    }

    Split split(const Formula::Node& n) {
        if (n.operation == kExprConstant) return leaf(out_.add_constant(n.constant));
        if (expression_is_leaf(n.operation)) return leaf(out_.add(n.operation));
        const Split& a = split_[n.a];
        const Split& b = split_[expression_is_binary(n.operation) != 0 ? n.b : n.a];
        const Index plain = out_.add(n.operation, a.plain, b.plain);
        switch (n.operation) {
            case kExprAbs:
                if (jumps_[n.a] != 0) return leaf(plain);
                return {plain, out_.add(kExprMax, a.whole, negative(a.whole)), 2 * a.terms, 2 * a.parts,
                        std::min(kMany, 2 * a.leaves)};
            case kExprNegate: return {plain, negative(a.whole), a.terms, a.parts, a.leaves};
            case kExprMin:
            case kExprMax:
                return {plain, out_.add(n.operation, a.whole, b.whole), 1,
                        a.parts + b.parts <= kMostTerms ? a.parts + b.parts : 1,
                        std::min(kMany, a.leaves + b.leaves)};
            case kExprAdd:
            case kExprSubtract:
                return sum(plain, a, b, n.operation == kExprSubtract,
                           may_join(n.a, n.b) || may_join(n.b, n.a));
            case kExprMultiply:
                if (is_constant(n.b)) return multiple(plain, a, nodes_[n.b].constant, kExprMultiply);
                if (is_constant(n.a)) return multiple(plain, b, nodes_[n.a].constant, kExprMultiply);
                return leaf(plain);
            case kExprDivide:
                if (is_constant(n.b)) return multiple(plain, a, nodes_[n.b].constant, kExprDivide);
                return leaf(plain);
            default: return leaf(plain);
        }
    }

    /// Whether a function may be added to each part of another. Where that is used elsewhere, too, the set
    /// would grow with every level of such uses.
    bool may_join(Index function, Index other) const {
        if (is_constant(function)) return true;
        // Where one of them is no number, all is outside; of a union only its part would be.
        if (signs_.partial[function] || signs_.partial[other]) return false;
        while (nodes_[other].operation == kExprNegate && uses_[other] == 1) other = nodes_[other].a;
        return kinks_[function] == 0 && uses_[other] == 1;
    }

    static Split leaf(Index plain) { return {plain, plain, 1, 1, 1}; }
    bool is_constant(Index i) const { return nodes_[i].operation == kExprConstant; }
    Index negative(Index i) { return out_.add(kExprNegate, i); }

    Split sum(Index plain, const Split& a, const Split& b, bool subtracts, bool by_parts) {
        if (a.parts * b.parts > kMostTerms) by_parts = false;
        const std::uint32_t terms = a.terms * b.terms, parts = by_parts ? a.parts * b.parts : terms;
        if (parts == 1 || parts > kMostTerms || a.leaves * b.leaves > kMostLeaves) return leaf(plain);
        const Index whole = map(a, by_parts, false, [&](Index p, bool negative_p) {
            return map(b, by_parts, subtracts, [&](Index q, bool negative_q) {
                const Index first = negative_p ? negative(p) : p;
                return out_.add(negative_q ? kExprSubtract : kExprAdd, first, q);
            });
        });
        return {plain, whole, terms, parts, a.leaves * b.leaves};
    }

    Split multiple(Index plain, const Split& a, double factor, std::int32_t operation) {
        if (a.parts == 1 || !std::isfinite(factor) || factor == 0) return leaf(plain);
        const Index size = out_.add_constant(std::fabs(factor));
        const Index whole = map(a, true, factor < 0, [&](Index p, bool is_negative) {
            const Index scaled = out_.add(operation, p, size);
            return is_negative ? negative(scaled) : scaled;
        });
        return {plain, whole, a.terms, a.parts, a.leaves};
    }

    /// The max and min of `a`, or of its negative, over make(term, whether the term's negative is meant).
    template <class Make>
    Index map(const Split& a, bool by_parts, bool is_negative, const Make& make) {
        return (by_parts ? a.parts : a.terms) == 1 ? make(a.plain, is_negative)
                                                   : map_node(a.whole, is_negative, make);
    }
    template <class Make>
    Index map_node(Index i, bool is_negative, const Make& make) {
        const Formula::Node n = out_.nodes()[i];
        if (n.operation == kExprNegate) return map_node(n.a, !is_negative, make);
        if (!Formula::combines(n)) return make(i, is_negative);
        const Index first = map_node(n.a, is_negative, make);
        const Index second = map_node(n.b, is_negative, make);
        return out_.add((n.operation == kExprMax) != is_negative ? kExprMax : kExprMin, first, second);
    }

    const std::vector<Formula::Node>& nodes_;
    std::vector<Split> split_;
    const Signs signs_;
    std::vector<std::uint8_t> jumps_;
    std::vector<std::uint8_t> kinks_;
    std::vector<std::uint32_t> uses_;  ///< as arguments
    Formula out_;
};

}  // namespace

Formula split_absolutes(const Formula& formula) { return AbsoluteSplitter(formula).take(); }

}  // namespace mortise::formula
