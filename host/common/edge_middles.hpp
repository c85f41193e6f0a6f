// Hanging nodes in the middles of edges, found by the edges' ends.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise {

class EdgeMiddles {
  public:
    EdgeMiddles() = default;
    explicit EdgeMiddles(const HangingNodes& nodes) {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (nodes.in_edge(i))
                middles_.emplace_back(key(nodes.masters[4 * i], nodes.masters[4 * i + 1]), nodes.node[i]);
        }
        std::sort(middles_.begin(), middles_.end());
    }

    /// The node that hangs between two others, in any order.
    std::optional<NodeId> between(NodeId a, NodeId b) const {
        const auto found =
            std::lower_bound(middles_.begin(), middles_.end(), std::make_pair(key(a, b), NodeId{0}));
        if (found == middles_.end() || found->first != key(a, b)) return std::nullopt;
        return found->second;
    }

  private:
    static std::uint64_t key(NodeId a, NodeId b) {
        return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    }

    std::vector<std::pair<std::uint64_t, NodeId>> middles_;
};

}  // namespace mortise
