// Changes of element blocks in place.
#pragma once

#include <algorithm>
#include <cstddef>

#include "mortise/mesh.hpp"

namespace mortise {

/// Leaves those elements of a block for which keeps(index) holds, in their order; it is asked once for each,
/// in ascending order. `per_element`: nodes of an element.
template <class Keeps>
void keep_elements(ElementBlock& block, std::size_t per_element, const Keeps& keeps) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (!keeps(i)) continue;
        if (kept != i) {
            std::copy_n(block.nodes.begin() + static_cast<std::ptrdiff_t>(i * per_element), per_element,
                        block.nodes.begin() + static_cast<std::ptrdiff_t>(kept * per_element));
            block.region[kept] = block.region[i];
            block.kind[kept] = block.kind[i];
        }
        ++kept;
    }
    block.nodes.resize(kept * per_element);
    block.region.resize(kept);
    block.kind.resize(kept);
}

}  // namespace mortise
