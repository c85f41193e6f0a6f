// The descent on the device, one level at a time (kernels/octree/descend.cl).
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "host/common/watch.hpp"
#include "host/octree/octree.hpp"
#include "mortise/error.hpp"

namespace mortise::octree {

using device::Buffer;
using device::Device;

/// Words that the tape arena starts with for each node of a level; it grows when a level needs more.
constexpr std::size_t kWordsPerNode = 4;
/// A level rarely adds more than twice what the one before did; room for so much is not made beyond this.
constexpr std::size_t kMostAhead = std::size_t{1} << 26;
/// Scratch for what children keep of the nodes' tapes; a level that needs more is split in several launches.
/// On a CPU what fits into the cores' caches.
constexpr std::size_t kScratchBytesPerCore = 1u << 20;
constexpr std::size_t kGpuScratchBytes = 128u << 20;

/// Runs kernels/octree/descend.cl level by level.
class Descent {
  public:
    Descent(Device& device, const tape::BoundModel& model) : device_(device) {
        descend_ = device.kernel("octree/descend.cl", "descend");
        gather_ = device.kernel("octree/descend.cl", "gather_children");
        bounds_ = device.upload(model.bounds);
        spatial_ = device.upload(model.spatial.empty() ? std::vector<std::uint32_t>(1) : model.spatial);
        capacity_ = model.tape.size() + (1u << 16);
        tapes_ = device.allocate(capacity_ * sizeof(std::uint32_t));
        device.upload(tapes_, model.tape.data(), model.tape.size());
        used_words_ = model.tape.size();
        const std::vector<TreeNode> root = {{0, 0, static_cast<std::uint32_t>(model.tape.size())}};
        nodes_ = device.upload(root);
        count_ = 1;
        longest_ = added_words_ = model.tape.size();
        in_nodes_ = device.allocate(sizeof(InNode));
    }

    /// Splits the nodes at hand, which are of level - 1; then those are their undecided children.
    void step(int level, const Buffer& ops) {
        keep_watch();
        if (!used_) used_ = device_.allocate(2 * sizeof(std::uint32_t));
        split(level, ops);
        cells_evaluated_ += 8 * evaluated_;
    }

    /// The nodes at hand, ascending.
    std::vector<TreeNode> nodes() { return device_.download<TreeNode>(nodes_, count_); }
    /// Replaces them.
    void set_nodes(const std::vector<TreeNode>& nodes) {
        nodes_ = device_.upload(nodes);
        count_ = nodes.size();
    }
    /// Appends the words of tapes that were made since the last call.
    void fetch_tapes(std::vector<std::uint32_t>& words) {
        const std::size_t before = words.size();
        words.resize(used_words_);
        if (used_words_ > before)
            device_.download(tapes_, words.data() + before, used_words_ - before, before);
    }
    std::uint64_t cells_evaluated() const { return cells_evaluated_; }

    Buffer take_nodes() { return std::move(nodes_); }
    Buffer take_tapes() { return std::move(tapes_); }
    Buffer take_in_nodes() { return std::move(in_nodes_); }
    std::size_t node_count() const { return count_; }
    std::size_t in_count() const { return in_count_; }
    std::size_t used_words() const { return used_words_; }

  private:
    void split(int level, const Buffer& ops) {
        evaluated_ = count_;
        Buffer children = device_.allocate(8 * count_ * sizeof(ChildNode));
        Buffer unknown = device_.allocate((count_ + 1) * sizeof(std::uint32_t));
        Buffer in = device_.allocate((count_ + 1) * sizeof(std::uint32_t));
        reserve(used_words_ + kWordsPerNode * count_ + std::min(2 * added_words_, kMostAhead));
        const std::size_t batch = reserve_scratch();
        for (;;) {
            const std::uint32_t before[2] = {static_cast<std::uint32_t>(used_words_), 0};
            device_.upload(used_, before, 2);
            for (std::size_t first = 0; first < count_; first += batch) {
                device_.launch(descend_, std::min(batch, count_ - first), nodes_, tapes_, bounds_, ops,
                               spatial_, children, unknown, in, used_, scratch_,
                               static_cast<std::uint32_t>(capacity_), static_cast<std::uint32_t>(first),
                               static_cast<std::uint32_t>(longest_), static_cast<std::int32_t>(level));
            }
            std::uint32_t after[2] = {};
            device_.download(used_, after, 2);
            if (after[0] <= capacity_) {
                added_words_ = after[0] - before[0];
                used_words_ = after[0];
                longest_ = after[1];
                break;
            }
            if (after[0] >= kMostTapeWords) {
                throw Error(ExitCode::kDevice, "the tapes of level " + std::to_string(level) +
                                                   " need more than 12 GB; use a lower --level");
            }
            reserve(after[0]);
        }
        const std::uint64_t next_count = device_.exclusive_scan_u32(unknown, unknown, count_);
        const std::uint64_t new_in = device_.exclusive_scan_u32(in, in, count_);
        Buffer next = device_.allocate(next_count * sizeof(TreeNode));
        grow(in_nodes_, in_count_ * sizeof(InNode), (in_count_ + new_in) * sizeof(InNode));
        device_.launch(gather_, count_, nodes_, children, unknown, in, next, in_nodes_,
                       static_cast<std::uint32_t>(in_count_), static_cast<std::int32_t>(level));
        device_.finish();
        in_count_ += new_in;
        count_ = next_count;
        nodes_ = std::move(next);
    }

    /// Scratch for the nodes that are split at once; returns their number.
    std::size_t reserve_scratch() {
        const device::DeviceInfo& info = device_.info();
        const std::size_t bytes =
            info.is_gpu ? kGpuScratchBytes : kScratchBytesPerCore * std::max(1u, info.compute_units);
        const std::size_t slot = std::max<std::size_t>(1, longest_) *
                                 static_cast<std::size_t>(1 + device_.lanes()) * sizeof(std::uint16_t);
        const std::size_t batch = std::clamp<std::size_t>(bytes / slot, 1, std::max<std::size_t>(1, count_));
        if (batch * slot > scratch_.bytes()) scratch_ = device_.allocate(batch * slot);
        return batch;
    }

    void reserve(std::size_t words) {
        if (words <= capacity_) return;
        const std::size_t capacity = std::min<std::size_t>(std::max(words, 2 * capacity_), kMostTapeWords);
        grow(tapes_, used_words_ * sizeof(std::uint32_t), capacity * sizeof(std::uint32_t));
        capacity_ = capacity;
    }

    void grow(Buffer& buffer, std::size_t kept, std::size_t bytes) {
        if (bytes <= buffer.bytes()) return;
        Buffer larger = device_.allocate(std::max(bytes, buffer.bytes() + buffer.bytes() / 2));
        if (kept > 0) device_.copy(buffer, larger, kept);
        buffer = std::move(larger);
    }

    Device& device_;
    device::Kernel descend_;
    device::Kernel gather_;
    Buffer bounds_;
    Buffer spatial_;
    Buffer tapes_;
    Buffer nodes_;
    Buffer in_nodes_;
    Buffer used_;
    Buffer scratch_;
    std::size_t capacity_ = 0;
    std::size_t used_words_ = 0;
    std::size_t added_words_ = 0;  ///< by the last level
    std::size_t longest_ = 0;      ///< words of the longest tape of the nodes at hand, or more
    std::size_t count_ = 0;
    std::size_t in_count_ = 0;
    std::uint64_t evaluated_ = 0;
    std::uint64_t cells_evaluated_ = 0;
};

}  // namespace mortise::octree
