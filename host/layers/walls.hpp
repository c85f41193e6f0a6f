// Where layers of elements go: walls, the nodes on them, and the edges at which they end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::layers {

/// What a thread takes at a time, of elements and facets, and of nodes.
inline constexpr std::size_t kElementChunk = 8192, kNodeChunk = 4096;

/// A facet that gets layers, counter-clockwise seen from beyond the wall; a triangle repeats its last node.
struct WallFacet {
    std::array<NodeId, 4> node{};
    std::uint32_t facet = 0;   ///< in Mesh::facets
    std::uint16_t region = 0;  ///< on the layers' side

    std::size_t corners() const { return corner_count(node.data()); }
};

/// An edge of the walls where a facet of another kind begins: on an open boundary (an inlet) or between two
/// regions. The layers' sides become facets that continue it.
struct Rim {
    NodeId a = 0, b = 0;  ///< in that facet's order
    std::uint32_t facet = 0;
};

/// What a facet is to the regions that get layers.
enum class FacetRole : std::uint8_t {
    kAway,    ///< of none of them
    kWall,    ///< gets layers
    kOpen,    ///< on the outer boundary, without
    kInner,   ///< between two of them
    kClosed,  ///< between one and a region that gets none, and no wall
};

inline constexpr std::uint32_t kNoWallNode = 0xffffffffu;

struct Walls {
    std::vector<std::uint8_t> has_layers;  ///< by region
    std::vector<FacetRole> role;           ///< by facet
    std::vector<WallFacet> facets;         ///< in their order in the mesh
    std::vector<NodeId> nodes;             ///< ascending
    std::vector<std::uint32_t> place;      ///< by node of the mesh: its place in `nodes`, or kNoWallNode
    std::vector<std::uint8_t> is_bare;     ///< by place: no layers can leave the wall here
    std::vector<Rim> rims;
    std::vector<std::string> unused;  ///< names that no facet of a wall has
};

/// The walls called by `names`, surfaces or regions: of regions all their boundary, from inside, of surfaces
/// their facets, of both these of those; of none the outer boundary. A node is bare where parts of the
/// boundary touch, where a wall meets a region without layers, or other than two of its facets an edge.
Walls find_walls(const Mesh& mesh, const std::vector<std::string>& names, int threads);

}  // namespace mortise::layers
