// Edges of a mesh, numbered: the nodes in their middles come after all others, in this order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::second_order {

/// All edges of the elements, each once, in order of their lower node, then of the other.
class Edges {
  public:
    /// Throws Error(kMeshing) if nodes and edges together are more than a NodeId counts.
    Edges(const Mesh& mesh, int threads);

    std::size_t size() const { return upper_.size(); }
    /// The number of the edge between two nodes, which must be one.
    std::size_t number(NodeId a, NodeId b) const;
    /// The same, or size() if it is none.
    std::size_t find(NodeId a, NodeId b) const;
    /// Calls visit(edge, lower node, upper node) for the edges of lower nodes [begin, end).
    template <class Visit>
    void visit(std::size_t begin, std::size_t end, const Visit& visit) const {
        for (std::size_t node = begin; node < end; ++node) {
            for (std::size_t e = first_[node]; e < first_[node + 1]; ++e)
                visit(e, static_cast<NodeId>(node), upper_[e]);
        }
    }

  private:
    std::vector<std::size_t> first_;  ///< by lower node: its first edge; and the end
    std::vector<NodeId> upper_;       ///< by edge: the other node
};

/// Calls visit(k, a, b) for the sides of a facet, k from 0 to 3 as in FacetBlock::middles: the last one of a
/// triangle comes twice.
template <class Visit>
void for_sides(const FacetBlock& facets, std::size_t facet, const Visit& visit) {
    const FacetNodes node = facets.facet(facet);
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t side = std::min(k, node.size() - 1);
        visit(k, node[side], node.after(side));
    }
}

}  // namespace mortise::second_order
