// A grid vertex beside complex leaves that counts as on surfaces, and moves onto them once cells are meshed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/shared/lattice.h"

namespace mortise::octree {

struct SnappedVertex {
    std::uint64_t code = 0;               ///< Morton code of its coordinates, in finest cells
    std::uint8_t level = 0;               ///< of all leaves around it
    std::array<std::int32_t, 3> moved{};  ///< lattice units of these
    std::array<std::uint32_t, 3> surface{};
    std::uint8_t surface_count = 0;

    /// Where it moves to, box-local; `finest_edge`: of the tree's finest cells.
    std::array<double, 3> target(double finest_edge) const {
        const double unit = 1.0 / static_cast<double>(std::uint64_t{kCellUnits} << level);
        std::array<double, 3> at{};
        for (std::size_t j = 0; j < 3; ++j) at[j] = gather_bits(code >> j) * finest_edge + moved[j] * unit;
        return at;
    }
    bool is_on(std::uint32_t wanted) const {
        for (std::size_t i = 0; i < surface_count; ++i) {
            if (surface[i] == wanted) return true;
        }
        return false;
    }
};

}  // namespace mortise::octree
