// Elements of a transition cell: a leaf in one region some of whose faces and edges are split. From a table
// (host/templates/transition.hpp) of the fewest elements for each class of patterns under the cube's
// symmetries.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/common/cube_grid.hpp"

namespace mortise::cnio {

struct TransitionElement {
    int count = 0;                       ///< of nodes; it tells the type
    std::array<std::uint8_t, 8> node{};  ///< vertices of the cube in halves, in the order of mesh.hpp
};

/// The elements of a pattern (is_split_pattern), right-handed. They use all vertices that the pattern makes,
/// and the centre perhaps.
void transition_elements(SplitPattern pattern, std::vector<TransitionElement>& elements);

}  // namespace mortise::cnio
