// A set of cells of the tree, and which cell a point belongs to.
//
// Uniform trees: bits over the cells of the root box, and one ring around it for elements whose nodes have
// moved out. Graded trees: bits over the meshed leaves. Elements whose nodes have moved into space without
// leaves get a cell there too: the cube, of the size of the smallest leaf nearby, that holds their centroid.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "host/common/leaf_grid.hpp"
#include "host/improve/quality.hpp"

namespace mortise::improve {

/// A cell: of a uniform tree its place in the bits; of a graded one the number of its leaf, or with kOutside
/// a cube without a leaf.
using CellId = std::uint64_t;

class CellSet {
  public:
    /// `leaves` may be null: a uniform tree. `reach`: how far is near, in cells.
    CellSet(int level, const LeafGrid* leaves, std::int64_t reach = kReach);

    /// The cell that a point belongs to. `hint`: an earlier result for a point that may be near.
    CellId index(const Point& p, CellId hint = 0) const {
        if (leaves_ != nullptr) return index_graded(p, hint);
        const auto at = place(p);
        return static_cast<CellId>((at[2] * size_ + at[1]) * size_ + at[0]);
    }
    /// Uniform trees: false only if all cells of the set are at least `reach` cells from p.
    bool is_near(const Point& p) const { return (near_at(p) & kNear) != 0; }
    /// Uniform trees: false only if is_near() is, for all points within kNearby cells of p along each axis.
    bool is_nearby(const Point& p) const { return near_at(p) != 0; }
    /// Uniform trees: Morton codes, ascending, of the bricks in the root box that hold such points: cubes of
    /// 2^kBrickLevels cells along an edge.
    std::vector<std::uint64_t> near_bricks() const;
    bool test(CellId i) const {
        if (is_outside(i)) return test_outside(i);
        return ((bits_[i >> 6] >> (i & 63)) & 1) != 0;
    }
    void reset(CellId i) {
        if (is_outside(i)) {
            left_out_.insert(i);
        } else {
            bits_[i >> 6] &= ~(std::uint64_t{1} << (i & 63));
        }
    }
    /// Puts a cell and all that touch it into the set.
    void set_ring(CellId i);

    /// The same, with one more ring.
    void set_two_rings(CellId i);

    /// Uniform trees: puts all cells within `reach` cells of this one into the set, without marking bricks.
    void set_cube(CellId i, std::int64_t reach);
    /// Uniform trees: a cell of the root box or of the ring around it, which begins at -1.
    std::array<std::int64_t, 3> cell_of(CellId i) const {
        const auto cell = static_cast<std::int64_t>(i);
        return {cell % size_ - 1, cell / size_ % size_ - 1, cell / size_ / size_ - 1};
    }

    bool is_graded() const { return leaves_ != nullptr; }
    /// Edge of a cell: 2^size_class finest cells.
    int size_class(CellId i) const { return leaves_ == nullptr ? 0 : cube(i).size_class; }

    static bool is_outside(CellId i) { return (i & kOutside) != 0; }

    static constexpr int kBrickLevels = 2;
    static constexpr std::int64_t kNearby = std::int64_t{1} << kBrickLevels;
    static constexpr std::int64_t kReach = 2 * kNearby;  ///< the reaches to choose from
    static constexpr std::int64_t kShortReach = kNearby;

  private:
    static constexpr std::int64_t kBrick = std::int64_t{1} << kBrickLevels;  ///< edge of the bricks of near_
    static constexpr CellId kOutside = CellId{1} << 63;
    static constexpr int kClassBits = 5;

    static CellId outside_id(const GridCube& c) {
        return kOutside | (c.code << kClassBits) | static_cast<CellId>(c.size_class);
    }
    GridCube cube(CellId i) const {
        if (!is_outside(i)) return cube_of(*leaves_, i);
        return {(i & ~kOutside) >> kClassBits, static_cast<int>(i & ((1 << kClassBits) - 1))};
    }
    /// Cells from the corner of the ring around the root box. Cutting off instead of rounding down is the
    /// same after clamping.
    std::array<std::int64_t, 3> place(const Point& p) const {
        std::array<std::int64_t, 3> at;
        for (std::size_t j = 0; j < 3; ++j)
            at[j] = std::clamp<std::int64_t>(static_cast<std::int64_t>(p[j] + 1), 0, size_ - 1);
        return at;
    }
    /// The brick of a place. The ring lies in bricks of its own, so that the others are octants.
    static std::array<std::int64_t, 3> brick_at(const std::array<std::int64_t, 3>& at) {
        return {(at[0] + kBrick - 1) / kBrick, (at[1] + kBrick - 1) / kBrick, (at[2] + kBrick - 1) / kBrick};
    }
    std::size_t brick(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>((z * bricks_ + y) * bricks_ + x);
    }
    std::uint8_t near_at(const Point& p) const {
        const auto at = brick_at(place(p));
        return near_[brick(at[0], at[1], at[2])];
    }
    void mark_near(const std::array<std::int64_t, 3>& at);
    CellId index_graded(const Point& p, CellId hint) const;
    bool test_outside(CellId i) const;
    std::vector<GridCube> cubes_around(const GridCube& centre) const;

    const LeafGrid* leaves_;
    std::vector<std::uint64_t> bits_;
    static constexpr std::uint8_t kNear = 1, kBeside = 2;
    // Uniform trees: cells along an edge; bricks near cells of the set, or beside such ones; bricks that hold
    // some.
    std::int64_t size_ = 0;
    std::int64_t reach_ = kReach;
    std::int64_t bricks_ = 0;
    std::vector<std::uint8_t> near_;
    std::vector<std::uint8_t> holds_;
    // Graded trees: cells whose ring is in the set, as bits and as cubes; cubes taken out again.
    std::vector<std::uint64_t> rings_;
    std::set<CellId> outer_rings_;
    std::set<CellId> left_out_;
};

}  // namespace mortise::improve
