// Which hexahedra of IN cells may have nodes in common with a few nodes of a large mesh.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

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
        const std::uint8_t* const kinds = mesh_.elements[0].kind.data();
        for (std::size_t i = begin; i < end;) {
            const std::size_t row_end = std::min(end, (i / kRow + 1) * kRow);
            const bool is_near = is_near_.empty() || is_near_[i / kRow] != 0;
            for (; i < row_end; ++i) {
                std::uint64_t eight = 1;
                if (!is_near && i + sizeof eight <= row_end) std::memcpy(&eight, kinds + i, sizeof eight);
                if (eight == 0) {  // cubes
                    i += sizeof eight - 1;
                } else if (is_near || !is_cube(i)) {
                    visit(i);
                }
            }
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
