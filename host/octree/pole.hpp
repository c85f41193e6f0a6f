// A pole (host/tape/pole.hpp) as a point of a leaf's mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace mortise::octree {

struct LeafPole {
    static constexpr int kInside = 6;

    std::uint64_t morton = 0;
    using Point = std::array<std::int32_t, 3>;  ///< lattice units from the leaf's minimum corner

    int face = kInside;  ///< the pole stands for the middle of this face, too
    Point at{};          ///< on the face; the apex if there is none
    bool has_apex = true;
    Point apex{};                        ///< it stands for the leaf's apex
    std::vector<std::uint32_t> through;  ///< surfaces of the leaf that pass there, ascending
};

}  // namespace mortise::octree
