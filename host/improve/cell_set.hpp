// A set of cells of the tree, and which cell a point belongs to.
//
// Uniform trees: bits over the cells of the root box, and one ring around it for elements whose nodes have
// moved out; only where cells of the set are near. Graded trees: bits over the meshed leaves. Elements whose
// nodes have moved into space without leaves get a cell there too: the cube, of the size of the smallest leaf
// nearby, that holds their centroid.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "host/common/leaf_grid.hpp"
#include "host/improve/quality.hpp"

namespace mortise::improve {

/// A cell: of a uniform tree its coordinates, x lowest; of a graded one the number of its leaf, or with
/// kOutside a cube without a leaf.
using CellId = std::uint64_t;

class CellSet {
  public:
    /// `leaves` may be null: a uniform tree. `reach`: how far is near, in cells.
    CellSet(int level, const LeafGrid* leaves, std::int64_t reach = kShortReach);

    /// The cell that a point belongs to. `hint`: an earlier result for a point that may be near.
    CellId index(const Point& p, CellId hint = 0) const {
        if (leaves_ != nullptr) return index_graded(p, hint);
        return id_of(place(p));
    }
    /// Uniform trees: false only if all cells of the set are at least `reach` cells from p.
    bool is_near(const Point& p) const { return brick_of(place(p)).is_near; }
    /// Uniform trees: whether is_near() is true of any point in the cells from `low` to `high`.
    bool any_is_near(const std::array<std::int32_t, 3>& low, const std::array<std::int32_t, 3>& high) const;
    /// Uniform trees: Morton codes, ascending, of the bricks in the root box that hold such points: cubes of
    /// 2^kBrickLevels cells along an edge.
    std::vector<std::uint64_t> near_bricks() const;
    bool test(CellId i) const {
        if (leaves_ == nullptr) {
            const auto at = place_of(i);
            return (brick_of(at).cells & cell_bit(at)) != 0;
        }
        if (is_outside(i)) return test_outside(i);
        return ((bits_[i >> 6] >> (i & 63)) & 1) != 0;
    }
    void reset(CellId i) {
        if (leaves_ == nullptr) {
            if (test(i)) make_brick(brick_at(place_of(i))).cells &= ~cell_bit(place_of(i));
        } else if (is_outside(i)) {
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
        const auto at = place_of(i);
        return {at[0] - 1, at[1] - 1, at[2] - 1};
    }

    /// Uniform trees: what is within so many cells is near from now on.
    void extend_reach(std::int64_t reach);

    bool is_graded() const { return leaves_ != nullptr; }
    /// Edge of a cell: 2^size_class finest cells.
    int size_class(CellId i) const { return leaves_ == nullptr ? 0 : cube(i).size_class; }

    static bool is_outside(CellId i) { return (i & kOutside) != 0; }

    static constexpr int kBrickLevels = 2;
    /// The reaches to choose from.
    static constexpr std::int64_t kShortReach = std::int64_t{1} << kBrickLevels;
    static constexpr std::int64_t kReach = 2 * kShortReach;

  private:
    static constexpr std::int64_t kBrick = std::int64_t{1} << kBrickLevels;  ///< its edge, in cells
    static constexpr int kBlockLevels = 3;
    static constexpr std::int64_t kBlock = std::int64_t{1} << kBlockLevels;  ///< edge of a block, in bricks
    static constexpr std::size_t kBlockBricks = kBlock * kBlock * kBlock;
    struct Brick {
        std::uint64_t cells = 0;  ///< those of the set: 4 x 4 x 4 bits
        bool is_near = false;     ///< to cells of the set
        bool holds = false;       ///< what is near cells in it has been marked
    };
    static_assert(kBrick * kBrick * kBrick == 64);
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
        return {(at[0] + kBrick - 1) >> kBrickLevels, (at[1] + kBrick - 1) >> kBrickLevels,
                (at[2] + kBrick - 1) >> kBrickLevels};
    }
    CellId id_of(const std::array<std::int64_t, 3>& at) const {
        return static_cast<CellId>((((at[2] << bits_of_axis_) | at[1]) << bits_of_axis_) | at[0]);
    }
    std::array<std::int64_t, 3> place_of(CellId i) const {
        const auto cell = static_cast<std::int64_t>(i);
        const std::int64_t mask = (std::int64_t{1} << bits_of_axis_) - 1;
        return {cell & mask, (cell >> bits_of_axis_) & mask, cell >> (2 * bits_of_axis_)};
    }
    static std::uint64_t cell_bit(const std::array<std::int64_t, 3>& at) {
        const auto step = [&](std::size_t j) { return (at[j] + kBrick - 1) & (kBrick - 1); };
        return std::uint64_t{1} << ((((step(2) << kBrickLevels) | step(1)) << kBrickLevels) | step(0));
    }
    std::size_t block_of(const std::array<std::int64_t, 3>& brick) const {
        return static_cast<std::size_t>(((brick[2] >> kBlockLevels) * blocks_ + (brick[1] >> kBlockLevels)) *
                                            blocks_ +
                                        (brick[0] >> kBlockLevels));
    }
    static std::size_t place_in_block(const std::array<std::int64_t, 3>& brick) {
        const auto step = [&](std::size_t j) { return brick[j] & (kBlock - 1); };
        return static_cast<std::size_t>((((step(2) << kBlockLevels) | step(1)) << kBlockLevels) | step(0));
    }
    const Brick& brick_of(const std::array<std::int64_t, 3>& at) const {
        const auto brick = brick_at(at);
        return stored_[directory_[block_of(brick)] + place_in_block(brick)];
    }
    Brick& make_brick(const std::array<std::int64_t, 3>& brick);
    void mark_near(const std::array<std::int64_t, 3>& centre);
    /// visit(brick's place, brick) for all that are stored.
    template <class Visit>
    void for_bricks(const Visit& visit) const;
    CellId index_graded(const Point& p, CellId hint) const;
    bool test_outside(CellId i) const;
    std::vector<GridCube> cubes_around(const GridCube& centre) const;

    const LeafGrid* leaves_;
    std::vector<std::uint64_t> bits_;
    // Uniform trees: cells along an edge, and bits for one; bricks along an edge; blocks of kBlock^3 bricks,
    // of which those with anything in them are stored behind an empty one, and where in stored_ each begins.
    std::int64_t size_ = 0;
    int bits_of_axis_ = 0;
    std::int64_t reach_ = kShortReach;
    std::int64_t bricks_ = 0;
    std::int64_t blocks_ = 0;
    std::vector<std::uint32_t> directory_;
    std::vector<Brick> stored_;
    // Graded trees: cells whose ring is in the set, as bits and as cubes; cubes taken out again.
    std::vector<std::uint64_t> rings_;
    std::set<CellId> outer_rings_;
    std::set<CellId> left_out_;
};

}  // namespace mortise::improve
