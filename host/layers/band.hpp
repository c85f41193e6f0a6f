// The nodes behind the walls, which make room for layers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/common/small_groups.hpp"
#include "host/layers/growth.hpp"
#include "host/layers/walls.hpp"
#include "mortise/mesh.hpp"

namespace mortise::layers {

inline constexpr std::uint32_t kNoSlot = 0xffffffffu;

/// Slots are places in these arrays: first those of the wall's nodes, in their order, then the nodes behind
/// them, by rings, then by number.
struct Band {
    std::vector<NodeId> node;
    std::vector<std::uint32_t> slot;  ///< by node of the mesh; kNoSlot: it stays where it is
    std::vector<std::size_t> ring;    ///< where each ring begins in `node`, and the end
    std::array<std::vector<std::uint32_t>, kElementTypes> elements;  ///< that have a node of these, ascending
    SmallGroups neighbours;  ///< by slot: slots at the other ends of its edges, by their nodes' numbers
    std::vector<float> conductance;  ///< of these edges, 1/length
    std::vector<double> weight;      ///< by slot: the conductance of all its edges, to nodes that stay, too
};

/// Of `rings` rings, of nodes of elements in regions with layers.
Band find_band(const Mesh& mesh, const Walls& walls, int rings, int threads);

/// How many rings there should be for layers that reach so far.
int rings_for(const Growth& growth);

}  // namespace mortise::layers
