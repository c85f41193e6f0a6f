// A pole (host/tape/pole.hpp) as a point of a leaf's mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace mortise::octree {

struct LeafPole {
    static constexpr int kInside = 6;

    std::uint64_t morton = 0;
    int face = kInside;                  ///< it stands for the middle of this face; else for the apex
    std::array<std::int32_t, 3> at{};    ///< lattice units from the leaf's minimum corner
    std::vector<std::uint32_t> through;  ///< surfaces of the leaf that pass there, ascending
};

}  // namespace mortise::octree
