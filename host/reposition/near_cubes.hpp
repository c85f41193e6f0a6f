// Which hexahedra of IN cells may have nodes in common with a few nodes of a large mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "host/common/index_set.hpp"
#include "host/reposition/stars.hpp"

namespace mortise::reposition {

/// Most hexahedra of a large mesh are cubes far from its surface. In a uniform tree they are in the order of
/// their cells' Morton codes, so that the first and last of a row tell for all between them.
class NearCubes {
  public:
    NearCubes(const Mesh& mesh, const Frame& frame, const IndexSet& nodes, const Options& options);

    /// False only for a hexahedron without a node of the set.
    bool may_hold(std::size_t hexahedron) const {
        return is_near_.empty() || is_near_[hexahedron / kRow] != 0 || !is_cube(hexahedron);
    }

  private:
    static constexpr std::size_t kRow = 64;
    static constexpr int kBrickLevels = 2;  ///< a brick is a cube of 4 × 4 × 4 cells

    bool is_cube(std::size_t hexahedron) const;
    std::uint64_t brick_of(std::size_t hexahedron) const;
    void find_bricks(const IndexSet& nodes);
    bool is_row_near(std::size_t begin, std::size_t end) const;
    std::array<std::int64_t, 3> cell_at(NodeId node, double offset) const;

    const Mesh& mesh_;
    const Frame& frame_;
    std::vector<std::uint64_t> bricks_;  ///< Morton codes, ascending: with a cell next to a node of the set
    std::vector<std::uint8_t> is_near_;  ///< per row; graded trees: empty
};

}  // namespace mortise::reposition
