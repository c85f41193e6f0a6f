// The octree as plain data on the host, and the stage that makes it on the device.
#pragma once

#include <cstdint>
#include <vector>

#include "host/device/device.hpp"
#include "host/tape/compile.hpp"
#include "kernels/shared/tree.h"

namespace mortise::octree {

/// Leaves of a uniform tree of one level, in Morton order. See kernels/shared/tree.h for the bitmaps.
struct Octree {
    int level = 0;
    std::vector<TreeNode> nio;            ///< NIO leaves, ascending Morton code
    std::vector<std::uint32_t> tapes;     ///< words of all pruned tapes
    std::vector<std::uint32_t> in_bits;   ///< length: words()
    std::vector<std::uint32_t> nio_bits;  ///< length: words()
    std::vector<std::uint32_t> in_rank;   ///< length: words() + 1
    std::vector<std::uint32_t> nio_rank;  ///< length: words() + 1
    std::vector<InNode> in_nodes;         ///< IN nodes of all levels as found, by level, then Morton code
    std::uint64_t in_count = 0;           ///< IN leaves at the finest level
    std::uint64_t cells_evaluated = 0;

    std::size_t words() const { return in_bits.size(); }
    double cell_size() const { return 1.0 / static_cast<double>(1u << level); }
    bool is_in(std::uint64_t morton) const { return test_bit(in_bits.data(), morton) != 0; }
    bool is_nio(std::uint64_t morton) const { return test_bit(nio_bits.data(), morton) != 0; }
    std::uint32_t nio_index(std::uint64_t morton) const {
        return rank_of(nio_bits.data(), nio_rank.data(), morton);
    }
    std::uint32_t in_index(std::uint64_t morton) const {
        return rank_of(in_bits.data(), in_rank.data(), morton);
    }
};

/// The same leaves in device memory.
struct DeviceTree {
    device::Buffer nio;
    device::Buffer tapes;
    device::Buffer in_bits;
    device::Buffer nio_bits;
    device::Buffer in_rank;
    device::Buffer nio_rank;
    device::Buffer in_nodes;
    device::Buffer surfaces;      ///< Surface
    device::Buffer ops;           ///< ExpressionOp
    bool local_formulas = false;  ///< tapes of neighbours may disagree (BoundModel::spatial)
};

/// Largest level of a uniform tree: its bitmaps hold one bit per cell.
inline constexpr int kMaxUniformLevel = 10;

/// Builds the tree breadth-first to `level` >= 1 (kernels/octree). Guarantees: IN and OUT leaves are decided
/// on their closed cells; NIO leaves carry the tape of what is undecided; order and content do not depend on
/// the device's scheduling.
Octree build(device::Device& device, const tape::BoundModel& model, int level, DeviceTree* on_device);

/// Ranks of a bitmap of `words` words into a new buffer of words + 1; returns the number of set bits.
std::uint64_t make_rank(device::Device& device, const device::Buffer& bits, std::size_t words,
                        device::Buffer& rank);

/// Region of a finest cell that was found IN (it may have been promoted since).
std::uint16_t in_region(const Octree& tree, std::uint64_t morton);

/// Region of each IN leaf, by IN index. Empty if there is one region only (then it is `single`).
std::vector<std::uint16_t> in_regions(const Octree& tree, std::uint16_t* single);

}  // namespace mortise::octree
