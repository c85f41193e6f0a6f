// Which hexahedra of IN cells may have nodes in common with a few nodes of a large mesh.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/common/cubes.hpp"
#include "host/common/index_set.hpp"
#include "host/reposition/stars.hpp"

namespace mortise::reposition {

/// Most hexahedra of a large mesh are cubes far from its surface. In a uniform tree they are in the order of
/// their cells' Morton codes, so that the first and last of a row tell for all between them.
class NearCubes {
  public:
    NearCubes(const Mesh& mesh, const Frame& frame, const IndexSet& nodes, const Options& options);

    /// Calls visit(i) for hexahedra from `begin` to `end`, but for some without a node of the set.
    template <class Visit>
    void for_near(std::size_t begin, std::size_t end, const Visit& visit) const {
        const ElementBlock& hexahedra = mesh_.elements[0];
        for (std::size_t row = begin; row < end; row = (row / kRow + 1) * kRow) {
            const std::size_t row_end = std::min(end, (row / kRow + 1) * kRow);
            const bool are_near = is_near_.empty() || is_near_[row / kRow] != 0;
            const auto next = [&](std::size_t i) {
                return are_near ? i : next_no_cube(hexahedra, i, row_end);
            };
            for (std::size_t i = next(row); i < row_end; i = next(i + 1)) visit(i);
        }
    }

  private:
    static constexpr std::size_t kRow = 64;
    static constexpr int kBrickLevels = 2;  ///< a brick is a cube of 4 × 4 × 4 cells

    bool is_cube(std::size_t hexahedron) const;
    std::uint64_t brick_of(std::size_t hexahedron) const;
    void find_bricks(const IndexSet& nodes);
    void mark_rows(std::size_t begin, std::size_t end);
    bool are_near(std::size_t begin, std::size_t end) const;
    std::array<std::int64_t, 3> cell_at(NodeId node, double offset) const;

    const Mesh& mesh_;
    const Frame& frame_;
    std::vector<std::uint64_t> bricks_;  ///< Morton codes, ascending: with a cell next to a node of the set
    std::vector<std::uint8_t> is_near_;  ///< per row; graded trees: empty
};

}  // namespace mortise::reposition
