// The model's region at any point of its root box, by the tape of the leaf that holds it.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/local_tape.hpp"
#include "host/tape/surface_batch.hpp"
#include "mortise/model.hpp"

namespace mortise::probe {

/// One for each thread: it remembers the tapes of the leaves asked last.
class Regions {
  public:
    Regions(const tape::BoundModel& model, const octree::Octree& tree)
        : model_(model), tree_(tree), view_(tree.view()), batch_(model) {}

    Leaf leaf_at_point(const Vec3& x) const;
    /// 0: outside.
    std::int32_t at(const Vec3& x);
    /// How many surfaces of the leaf that holds a, or of that of b nearby, have different signs at a and b.
    std::size_t crossings(const Vec3& a, const Vec3& b);
    /// The same as at() at many points near each other: formulas take a fraction of the time.
    void at(const std::vector<Vec3>& points, std::vector<std::int32_t>& regions);

  private:
    /// Points come in the neighbourhood of facet after facet, so few leaves are asked again and again.
    struct Known {
        std::uint32_t leaf = std::numeric_limits<std::uint32_t>::max();
        std::vector<std::uint32_t> surfaces;
        tape::LocalTape tape;
    };
    const Known& load(std::uint32_t leaf, const TreeNode& node);

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    const Tree view_;
    std::array<Known, 64> known_;
    std::vector<std::int8_t> signs_;
    // Scratch of at() for many points.
    tape::SurfaceBatch batch_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> by_leaf_;  ///< leaf, point
    std::vector<Vec3> leaf_points_;
    std::vector<std::vector<double>> values_;  ///< of the leaf's surfaces at its points
};

}  // namespace mortise::probe
