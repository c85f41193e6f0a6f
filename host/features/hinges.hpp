// Edges and nodes by which parts of a mesh hang together, where a model is thinner than its cells, or touches
// itself.
#pragma once

#include <cstdint>
#include <optional>

#include "mortise/mesh.hpp"

namespace mortise::features {

struct Hinges {
    std::uint64_t edges = 0;      ///< with more than two facets of the outer boundary
    std::uint64_t nodes = 0;      ///< on no such edge, but with several fans of facets
    std::optional<NodeId> first;  ///< the lowest node of them all

    bool any() const { return first.has_value(); }
};

/// `facets` as in a mesh of `nodes` nodes; `threads` host threads, on which the result does not depend. Time:
/// linear.
Hinges find_hinges(const FacetBlock& facets, std::size_t nodes, int threads);

}  // namespace mortise::features
