// The leaves of the tree that made a mesh: which leaf holds a point, and which leaves touch a cube.
//
// Coordinates are in finest cells, from the root box's minimum corner.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/shared/lattice.h"

namespace mortise {

/// Uniform trees: arrays empty.
struct LeafGrid {
    int level = 0;                    ///< of the finest leaves
    std::vector<std::uint64_t> code;  ///< ascending: Morton code, at `level`, of a leaf's first finest cell
    std::vector<std::uint8_t> leaf_level;  ///< parallel to `code`

    bool is_uniform() const { return code.empty(); }
    std::size_t size() const { return code.size(); }
    /// Size classes: an edge of 2^size_class finest cells.
    int size_class(std::size_t leaf) const { return level - leaf_level[leaf]; }
};

/// A cube of an octree: its first finest cell, and its size class.
struct GridCube {
    std::uint64_t code = 0;
    int size_class = 0;

    /// The Morton code after its last finest cell.
    std::uint64_t end() const { return code + (std::uint64_t{1} << (3 * size_class)); }
    std::array<std::int64_t, 3> low() const {
        return {gather_bits(code), gather_bits(code >> 1), gather_bits(code >> 2)};
    }
};

/// Edge of a cube in finest cells.
inline double edge_of(int size_class) { return static_cast<double>(std::uint64_t{1} << size_class); }

inline constexpr std::size_t kNoLeaf = ~std::size_t{0};

/// Whether two closed cubes have a point in common.
inline bool touch(const GridCube& a, const GridCube& b) {
    const auto p = a.low(), q = b.low();
    for (std::size_t j = 0; j < 3; ++j) {
        if (p[j] > q[j] + (std::int64_t{1} << b.size_class)) return false;
        if (q[j] > p[j] + (std::int64_t{1} << a.size_class)) return false;
    }
    return true;
}

/// The cube of a size class that holds a finest cell.
inline GridCube cube_of(std::uint64_t finest_cell, int size_class) {
    return {finest_cell >> (3 * size_class) << (3 * size_class), size_class};
}

inline GridCube cube_of(const LeafGrid& grid, std::size_t leaf) {
    return {grid.code[leaf], grid.size_class(leaf)};
}

/// Morton code of the finest cell at a point; points outside the root box count as on its boundary.
inline std::uint64_t finest_cell(const LeafGrid& grid, const std::array<double, 3>& point) {
    std::uint32_t at[3];
    const double last = std::ldexp(1.0, grid.level) - 1;
    for (std::size_t j = 0; j < 3; ++j) {
        at[j] = static_cast<std::uint32_t>(std::clamp(std::floor(point[j]), 0.0, last));
    }
    return morton_encode(at[0], at[1], at[2]);
}

/// The leaf that holds a finest cell, or kNoLeaf. `hint`: a leaf that is near in Morton order, or kNoLeaf.
inline std::size_t find_leaf(const LeafGrid& grid, std::uint64_t finest_cell, std::size_t hint = kNoLeaf) {
    if (hint < grid.size() && grid.code[hint] <= finest_cell) {
        for (std::size_t i = hint; i < grid.size() && i < hint + 2; ++i) {
            if (finest_cell >= grid.code[i] && finest_cell < cube_of(grid, i).end()) return i;
        }
    }
    const auto after = std::upper_bound(grid.code.begin(), grid.code.end(), finest_cell);
    if (after == grid.code.begin()) return kNoLeaf;
    const auto leaf = static_cast<std::size_t>(after - grid.code.begin()) - 1;
    return finest_cell < cube_of(grid, leaf).end() ? leaf : kNoLeaf;
}

/// Calls visit(leaf) for every leaf that touches the closed cube or lies in it; for one leaf perhaps several
/// times.
template <class Visit>
void for_touching_leaves(const LeafGrid& grid, const GridCube& cube, const Visit& visit) {
    const std::int64_t edge = std::int64_t{1} << cube.size_class;
    const std::int64_t side = std::int64_t{1} << grid.level;
    const auto low = cube.low();
    std::array<GridCube, 27 + 7 * (kMaxTreeLevel + 1)> open;  // each cube that is divided leaves seven more
    std::size_t count = 0;
    for (int k = 0; k < 27; ++k) {
        const std::int64_t x = low[0] + (k % 3 - 1) * edge;
        const std::int64_t y = low[1] + (k / 3 % 3 - 1) * edge;
        const std::int64_t z = low[2] + (k / 9 - 1) * edge;
        if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= side) continue;
        open[count++] = {morton_encode(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                       static_cast<std::uint32_t>(z)),
                         cube.size_class};
    }
    while (count > 0) {
        const GridCube part = open[--count];
        if (!touch(part, cube)) continue;
        const auto begin = std::upper_bound(grid.code.begin(), grid.code.end(), part.code);
        const auto next = static_cast<std::size_t>(begin - grid.code.begin());
        if (next > 0) {
            const GridCube leaf = cube_of(grid, next - 1);
            if (part.code < leaf.end() && leaf.size_class >= part.size_class) {
                visit(next - 1);
                continue;
            }
        }
        const bool starts_here = next > 0 && grid.code[next - 1] == part.code;
        if (!starts_here && (next == grid.size() || grid.code[next] >= part.end())) continue;
        for (std::uint64_t child = 0; child < 8; ++child) {
            const int size_class = part.size_class - 1;
            open[count++] = {part.code + (child << (3 * size_class)), size_class};
        }
    }
}

/// Size class of the finest leaves that there are.
inline int finest_class(const LeafGrid& grid) {
    const auto finest = std::max_element(grid.leaf_level.begin(), grid.leaf_level.end());
    return finest == grid.leaf_level.end() ? 0 : grid.level - *finest;
}

}  // namespace mortise
