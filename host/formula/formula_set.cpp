// Which min and max of a formula become set operations.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "host/formula/formula_set.hpp"

namespace mortise::formula {
namespace {

using Index = std::uint32_t;

constexpr Index kNone = 0xffffffffu;
constexpr std::uint64_t kGrowth = 4;       ///< words of tape per node of the formula
constexpr std::uint64_t kShortest = 256;   ///< words that every formula may have
constexpr std::uint64_t kMostCopies = 64;  ///< of one min or max

}  // namespace

std::vector<std::uint32_t> arguments_of(const std::vector<Formula::Node>& nodes, std::uint32_t of,
                                        std::int32_t operation) {
    std::vector<std::uint32_t> found, open = {of};
    std::set<std::uint32_t> seen;
    while (!open.empty()) {
        const std::uint32_t i = open.back();
        open.pop_back();
        if (!seen.insert(i).second) continue;
        const Formula::Node& n = nodes[i];
        if (n.operation == operation)
            open.insert(open.end(), {n.a, n.b});
        else
            found.push_back(i);
    }
    std::sort(found.begin(), found.end());
    return found;
}

std::vector<std::uint8_t> set_nodes(const Formula& formula) {
    std::vector<std::uint8_t> found(formula.root + 1, 0);
    found[formula.root] = 1;
    for (std::uint32_t i = formula.root + 1; i-- > 0;) {
        const Formula::Node& n = formula.nodes()[i];
        if (found[i] == 0 || (!Formula::combines(n) && n.operation != kExprNegate)) continue;
        found[n.a] = 1;
        if (Formula::combines(n)) found[n.b] = 1;
    }
    return found;
}

Signs::Signs(const std::vector<Formula::Node>& nodes)
    : nonnegative(nodes.size(), false), partial(nodes.size(), false) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Formula::Node& n = nodes[i];
        if (n.operation == kExprConstant) nonnegative[i] = n.constant >= 0;
        if (expression_is_leaf(n.operation)) continue;
        const bool binary = expression_is_binary(n.operation) != 0;
        const bool both = nonnegative[n.a] && binary && nonnegative[n.b];
        partial[i] = partial[n.a] || (binary && partial[n.b]);
        switch (n.operation) {
            case kExprAbs:
            case kExprSquare:
            case kExprExp:
            case kExprHypot:
            case kExprNot: nonnegative[i] = true; break;
            case kExprSqrt:
                nonnegative[i] = true;
                partial[i] = partial[i] || !nonnegative[n.a];
                break;
            case kExprAdd:
            case kExprMultiply:
            case kExprMin: nonnegative[i] = both; break;
            case kExprMax: nonnegative[i] = nonnegative[n.a] || nonnegative[n.b]; break;
            case kExprDivide:
                nonnegative[i] = both;
                partial[i] = partial[i] || nodes[n.b].operation != kExprConstant;
                break;
            case kExprLog:
            case kExprAsin:
            case kExprAcos:
            case kExprMod:
            case kExprPower: partial[i] = true; break;
            default: break;
        }
    }
}

FormulaSet formula_set(const Formula& formula) {
    const std::vector<Formula::Node>& nodes = formula.nodes();
    const Index root = formula.root;
    const Signs signs(nodes);

    // Users come after their arguments, so one backward sweep knows how often each node occurs in the tree,
    // with either sign, when it decides whether to expand it.
    std::vector<std::array<std::uint64_t, 2>> copies(root + 1, {0, 0});
    std::vector<std::array<bool, 2>> expanded(root + 1, {false, false});
    const std::uint64_t most = std::max(kShortest, kGrowth * nodes.size());
    std::uint64_t length = 1;
    copies[root][0] = 1;
    for (Index i = root + 1; i-- > 0;) {
        for (std::size_t flipped = 0; flipped < 2; ++flipped) {
            const std::uint64_t count = copies[i][flipped];
            if (count == 0) continue;
            const Formula::Node& n = nodes[i];
            if (n.operation == kExprNegate) {
                copies[n.a][1 - flipped] += count;
                expanded[i][flipped] = true;
            } else if (Formula::combines(n) && !formula.is_whole(i) && count <= kMostCopies &&
                       length + count <= most) {
                copies[n.a][flipped] += count;
                copies[n.b][flipped] += count;
                length += count;
                expanded[i][flipped] = true;
            }
        }
    }

    FormulaSet set;
    std::vector<std::array<Index, 2>> place(root + 1, {kNone, kNone});
    for (Index i = 0; i <= root; ++i) {
        for (std::size_t flipped = 0; flipped < 2; ++flipped) {
            if (copies[i][flipped] == 0) continue;
            const Formula::Node& n = nodes[i];
            if (expanded[i][flipped] && n.operation == kExprNegate) {
                place[i][flipped] = place[n.a][1 - flipped];
                continue;
            }
            FormulaSet::Node node;
            if (expanded[i][flipped]) {
                const bool is_and = (n.operation == kExprMax) != (flipped == 1);
                node.kind = is_and ? FormulaSet::Kind::kIntersection : FormulaSet::Kind::kUnion;
                node.a = place[n.a][flipped];
                node.b = place[n.b][flipped];
            } else {
                node.a = i;
                node.negated = flipped == 1;
                node.partial = signs.partial[i];
            }
            place[i][flipped] = static_cast<Index>(set.nodes.size());
            set.nodes.push_back(node);
        }
    }
    // A change of sign at the root stands before its argument's place.
    if (place[root][0] + 1 != set.nodes.size()) set.nodes.push_back(set.nodes[place[root][0]]);
    return set;
}

}  // namespace mortise::formula
