#include "host/improve/cell_set.hpp"

#include <cstdlib>

namespace mortise::improve {

CellSet::CellSet(int level, const LeafGrid* leaves, std::int64_t reach) : leaves_(leaves), reach_(reach) {
    if (leaves_ != nullptr && leaves_->is_uniform()) leaves_ = nullptr;
    if (leaves_ != nullptr) {
        bits_.resize((leaves_->size() + 63) / 64);
        rings_.resize(bits_.size());
        return;
    }
    size_ = (std::int64_t{1} << level) + 2;
    while (std::int64_t{1} << bits_of_axis_ < size_) ++bits_of_axis_;
    bricks_ = brick_at({size_ - 1, 0, 0})[0] + 1;
    blocks_ = (bricks_ + kBlock - 1) / kBlock;
    directory_.resize(static_cast<std::size_t>(blocks_ * blocks_ * blocks_), 0);
    stored_.resize(kBlockBricks);
}

CellSet::Brick& CellSet::make_brick(const std::array<std::int64_t, 3>& brick) {
    std::uint32_t& begin = directory_[block_of(brick)];
    if (begin == 0) {
        begin = static_cast<std::uint32_t>(stored_.size());
        stored_.resize(stored_.size() + kBlockBricks);
    }
    return stored_[begin + place_in_block(brick)];
}

void CellSet::mark_near(const std::array<std::int64_t, 3>& centre) {
    bool& holds = make_brick(centre).holds;
    if (holds) return;
    holds = true;
    // The next brick but `bricks` begins reach_ + 1 cells away at least; the ring is one cell wide.
    const std::int64_t bricks = reach_ / kBrick;
    std::int64_t low[3], high[3];
    for (std::size_t j = 0; j < 3; ++j) {
        low[j] = std::max<std::int64_t>(centre[j] - bricks, 0);
        high[j] = std::min(centre[j] + bricks, bricks_ - 1);
    }
    for (std::int64_t z = low[2]; z <= high[2]; ++z) {
        for (std::int64_t y = low[1]; y <= high[1]; ++y) {
            for (std::int64_t x = low[0]; x <= high[0]; ++x) make_brick({x, y, z}).is_near = true;
        }
    }
}

template <class Visit>
void CellSet::for_bricks(const Visit& visit) const {
    for (std::size_t block = 0; block < directory_.size(); ++block) {
        if (directory_[block] == 0) continue;
        const auto number = static_cast<std::int64_t>(block);
        const std::int64_t low[3] = {number % blocks_ * kBlock, number / blocks_ % blocks_ * kBlock,
                                     number / blocks_ / blocks_ * kBlock};
        for (std::size_t k = 0; k < kBlockBricks; ++k) {
            const auto step = static_cast<std::int64_t>(k);
            visit({low[0] + step % kBlock, low[1] + step / kBlock % kBlock, low[2] + step / kBlock / kBlock},
                  stored_[directory_[block] + k]);
        }
    }
}

std::vector<std::uint64_t> CellSet::near_bricks() const {
    std::vector<std::uint64_t> codes;
    for_bricks([&](const std::array<std::int64_t, 3>& at, const Brick& brick) {
        // The ring ends in bricks with none in the box.
        if (!brick.is_near || at[0] == 0 || at[1] == 0 || at[2] == 0) return;
        codes.push_back(morton_encode(static_cast<u32>(at[0] - 1), static_cast<u32>(at[1] - 1),
                                      static_cast<u32>(at[2] - 1)));
    });
    std::sort(codes.begin(), codes.end());
    return codes;
}

void CellSet::extend_reach(std::int64_t reach) {
    reach_ = reach;
    std::vector<std::array<std::int64_t, 3>> centres;
    for_bricks([&](const std::array<std::int64_t, 3>& at, const Brick& brick) {
        if (brick.holds) centres.push_back(at);
    });
    for (const auto& centre : centres) {
        make_brick(centre).holds = false;
        mark_near(centre);
    }
}

bool CellSet::any_is_near(const std::array<std::int32_t, 3>& low,
                          const std::array<std::int32_t, 3>& high) const {
    std::array<std::int64_t, 3> first, last;
    for (std::size_t j = 0; j < 3; ++j) {
        first[j] = std::clamp<std::int64_t>(std::int64_t{low[j]} + 1, 0, size_ - 1);
        last[j] = std::clamp<std::int64_t>(std::int64_t{high[j]} + 1, 0, size_ - 1);
    }
    first = brick_at(first);
    last = brick_at(last);
    for (std::int64_t z = first[2]; z <= last[2]; ++z) {
        for (std::int64_t y = first[1]; y <= last[1]; ++y) {
            for (std::int64_t x = first[0]; x <= last[0]; ++x) {
                const std::array<std::int64_t, 3> brick = {x, y, z};
                const std::uint32_t block = directory_[block_of(brick)];
                if (block == 0)
                    x |= kBlock - 1;  // nothing in this block
                else if (stored_[block + place_in_block(brick)].is_near)
                    return true;
            }
        }
    }
    return false;
}

CellId CellSet::index_graded(const Point& p, CellId hint) const {
    const std::uint64_t finest = finest_cell(*leaves_, p);
    const std::size_t leaf = find_leaf(*leaves_, finest, is_outside(hint) ? kNoLeaf : hint);
    if (leaf != kNoLeaf) return leaf;
    for (int size_class = 0; size_class < leaves_->level; ++size_class) {
        int smallest = leaves_->level + 1;
        for_touching_leaves(*leaves_, cube_of(finest, size_class), [&](std::size_t near) {
            smallest = std::min(smallest, leaves_->size_class(near));
        });
        if (smallest <= leaves_->level) return outside_id(cube_of(finest, std::max(size_class, smallest)));
    }
    return outside_id(cube_of(finest, leaves_->level));
}

void CellSet::set_ring(CellId i) {
    if (leaves_ == nullptr) {
        const auto at = cell_of(i);
        mark_near(brick_at({at[0] + 1, at[1] + 1, at[2] + 1}));
        set_cube(i, 1);
        return;
    }
    const GridCube centre = cube(i);
    for_touching_leaves(*leaves_, centre,
                        [&](std::size_t leaf) { bits_[leaf >> 6] |= std::uint64_t{1} << (leaf & 63); });
    if (is_outside(i)) {
        outer_rings_.insert(i);
    } else {
        rings_[i >> 6] |= std::uint64_t{1} << (i & 63);
    }
    for (auto at = left_out_.begin(); at != left_out_.end();) {
        at = touch(cube(*at), centre) ? left_out_.erase(at) : std::next(at);
    }
}

void CellSet::set_two_rings(CellId i) {
    if (leaves_ != nullptr) {
        set_ring(i);
        const GridCube centre = cube(i);
        for_touching_leaves(*leaves_, centre, [&](std::size_t leaf) { set_ring(leaf); });
        for (const GridCube& beside : cubes_around(centre)) {
            const auto low = beside.low();
            const double half = 0.5 * static_cast<double>(std::int64_t{1} << beside.size_class);
            const CellId there =
                index_graded({static_cast<double>(low[0]) + half, static_cast<double>(low[1]) + half,
                              static_cast<double>(low[2]) + half},
                             i);
            if (is_outside(there)) set_ring(there);
        }
        return;
    }
    const auto at = cell_of(i);
    for (std::int64_t k = 0; k < 27; ++k) {
        const std::array<std::int64_t, 3> beside = {at[0] + k % 3, at[1] + k / 3 % 3, at[2] + k / 9};
        if (std::any_of(beside.begin(), beside.end(), [&](std::int64_t x) { return x < 0 || x >= size_; }))
            continue;
        set_ring(id_of(beside));
    }
}

void CellSet::set_cube(CellId i, std::int64_t reach) {
    std::array<std::int64_t, 3> low = cell_of(i), high = low;
    for (std::size_t j = 0; j < 3; ++j) {
        low[j] = std::max<std::int64_t>(low[j] + 1 - reach, 0);
        high[j] = std::min(high[j] + 1 + reach, size_ - 1);
    }
    for (std::int64_t z = low[2]; z <= high[2]; ++z) {
        for (std::int64_t y = low[1]; y <= high[1]; ++y) {
            for (std::int64_t x = low[0]; x <= high[0]; ++x) {
                make_brick(brick_at({x, y, z})).cells |= cell_bit({x, y, z});
            }
        }
    }
}

/// Of cubes without leaves only those of the same size count as neighbours of each other.
bool CellSet::test_outside(CellId i) const {
    if (left_out_.count(i) != 0) return false;
    const GridCube centre = cube(i);
    bool found = outer_rings_.count(i) != 0;
    for_touching_leaves(*leaves_, centre, [&](std::size_t leaf) {
        found = found || ((rings_[leaf >> 6] >> (leaf & 63)) & 1) != 0;
    });
    if (found || outer_rings_.empty()) return found;
    const std::vector<GridCube> around = cubes_around(centre);
    return std::any_of(around.begin(), around.end(),
                       [&](const GridCube& beside) { return outer_rings_.count(outside_id(beside)) != 0; });
}

/// A cube and those of its size that touch it, in the root box.
std::vector<GridCube> CellSet::cubes_around(const GridCube& centre) const {
    const auto low = centre.low();
    const std::int64_t edge = std::int64_t{1} << centre.size_class;
    std::vector<GridCube> result;
    for (int k = 0; k < 27; ++k) {
        std::uint32_t at[3];
        bool is_in_box = true;
        const int step[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        for (std::size_t j = 0; j < 3; ++j) {
            const std::int64_t x = low[j] + step[j] * edge;
            is_in_box = is_in_box && x >= 0 && x < (std::int64_t{1} << leaves_->level);
            at[j] = static_cast<std::uint32_t>(x);
        }
        if (is_in_box) result.push_back({morton_encode(at[0], at[1], at[2]), centre.size_class});
    }
    return result;
}

}  // namespace mortise::improve
