// A grid vertex beside complex leaves that counts as on surfaces, and moves onto them once cells are meshed.
#pragma once

#include <array>
#include <cstdint>

namespace mortise::octree {

struct SnappedVertex {
    std::uint64_t code = 0;               ///< Morton code of its coordinates, in finest cells
    std::uint8_t level = 0;               ///< of all leaves around it
    std::array<std::int32_t, 3> moved{};  ///< lattice units of these
    bool is_merged = false;               ///< surfaces that pass close to each other are one there
    std::array<std::uint32_t, 4> surface{};
    std::uint8_t surface_count = 0;

    bool is_on(std::uint32_t wanted) const {
        for (std::size_t i = 0; i < surface_count; ++i) {
            if (surface[i] == wanted) return true;
        }
        return false;
    }
};

}  // namespace mortise::octree
