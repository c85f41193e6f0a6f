#include "host/cnio/transition.hpp"

#include <iterator>

#include "host/cnio/transition_table.hpp"

namespace mortise::cnio {
namespace {

constexpr std::uint16_t kNoTemplate = 0xffff;

/// By pattern: its row of the table, and the symmetry that takes the row's pattern to it: row × 48 +
/// symmetry.
std::vector<std::uint16_t> index_patterns() {
    std::vector<std::uint16_t> index(std::size_t{1} << kSplitBits, kNoTemplate);
    const auto& symmetries = cube_symmetries();
    for (std::size_t row = 0; row < std::size(kTransitionRows); ++row) {
        for (std::size_t s = 0; s < symmetries.size(); ++s) {
            std::uint16_t& entry = index[transform(symmetries[s], kTransitionRows[row].pattern)];
            if (entry == kNoTemplate) entry = static_cast<std::uint16_t>(row * symmetries.size() + s);
        }
    }
    return index;
}

}  // namespace

void transition_elements(SplitPattern pattern, std::vector<TransitionElement>& elements) {
    static const std::vector<std::uint16_t> index = index_patterns();
    elements.clear();
    const std::uint16_t entry = index[pattern];
    if (entry == kNoTemplate) return;
    const auto& symmetries = cube_symmetries();
    const TransitionRow& row = kTransitionRows[entry / symmetries.size()];
    const CubeSymmetry& symmetry = symmetries[entry % symmetries.size()];
    const std::uint8_t* at = kTransitionNodes + row.first;
    for (int i = 0; i < row.count; ++i) {
        TransitionElement element;
        element.count = *at++;
        for (std::size_t k = 0; k < static_cast<std::size_t>(element.count); ++k)
            element.node[k] = symmetry.vertex[*at++];
        if (symmetry.mirrored) turn_over(element.node.data(), element.count);
        elements.push_back(element);
    }
}

}  // namespace mortise::cnio
