// Which cells hold poor elements.
//
// Which cell an element belongs to is told by its centroid.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Bits over the cells of the root box, and one ring around it for elements whose nodes have moved out.
class CellSet {
  public:
    explicit CellSet(int level)
        : size_((std::int64_t{1} << level) + 2),
          bits_(static_cast<std::size_t>((size_ * size_ * size_ + 63) / 64)) {}
    std::size_t index(const Point& p) const {
        std::int64_t at[3];
        for (std::size_t j = 0; j < 3; ++j) {
            at[j] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(p[j])) + 1, 0, size_ - 1);
        }
        return static_cast<std::size_t>((at[2] * size_ + at[1]) * size_ + at[0]);
    }
    bool test(std::size_t i) const { return ((bits_[i >> 6] >> (i & 63)) & 1) != 0; }
    void set(std::size_t i) { bits_[i >> 6] |= std::uint64_t{1} << (i & 63); }
    void reset(std::size_t i) { bits_[i >> 6] &= ~(std::uint64_t{1} << (i & 63)); }
    void set_ring(std::size_t i) {
        const std::int64_t at[3] = {static_cast<std::int64_t>(i) % size_,
                                    static_cast<std::int64_t>(i) / size_ % size_,
                                    static_cast<std::int64_t>(i) / size_ / size_};
        for (int k = 0; k < 27; ++k) {
            const std::int64_t x = at[0] + k % 3 - 1;
            const std::int64_t y = at[1] + k / 3 % 3 - 1;
            const std::int64_t z = at[2] + k / 9 - 1;
            if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= size_) continue;
            set(static_cast<std::size_t>((z * size_ + y) * size_ + x));
        }
    }

  private:
    std::int64_t size_;
    std::vector<std::uint64_t> bits_;
};

/// One element of a mesh.
struct Element {
    ElementType type;
    const NodeId* node;
    std::size_t count;
};

Element element(const Mesh& mesh, int type, std::size_t i);

/// Position of a node, in cells.
Point in_cells(const Mesh& mesh, const CellFrame& frame, NodeId node);

Point centroid(const Mesh& mesh, const CellFrame& frame, const Element& element);

/// A point in the cell that an element belongs to: its centroid, for cubes without looking at all nodes.
Point place_of(const Mesh& mesh, const CellFrame& frame, int type, std::size_t i);

/// Below this an element's neighbourhood is improved.
inline constexpr double kPoorQuality = kGoodQuality;

/// Cells of the elements that are not good enough, ascending. `threads` host threads; the result does not
/// depend on them.
std::vector<std::size_t> poor_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                                    int threads);

}  // namespace mortise::improve
