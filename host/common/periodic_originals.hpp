// Mesh::periodic by node.
#pragma once

#include <cstddef>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise {

inline constexpr NodeId kNoOriginal = 0xffffffffu;

/// Per node of a mesh of so many its original in a pair, or kNoOriginal.
inline std::vector<NodeId> originals_of(const PeriodicNodes& pair, std::size_t nodes) {
    std::vector<NodeId> original(nodes, kNoOriginal);
    for (std::size_t i = 0; i < pair.size(); ++i) original[pair.node[i]] = pair.original[i];
    return original;
}

}  // namespace mortise
