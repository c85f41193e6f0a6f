#include "host/octree/octree.hpp"

#include <algorithm>
#include <string>

#include "mortise/error.hpp"

namespace mortise::octree {
namespace {

using device::Buffer;
using device::Device;

/// Words that the tape arena starts with for each node of a level; it grows when a level needs more.
constexpr std::size_t kWordsPerNode = 4;

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
        in_nodes_ = device.allocate(sizeof(InNode));
    }

    void run(int levels, const Buffer& ops, Octree& tree) {
        used_ = device_.allocate(sizeof(std::uint32_t));
        for (int level = 1; level <= levels && count_ > 0; ++level) {
            step(level, ops);
            tree.cells_evaluated += 8 * evaluated_;
        }
    }

    Buffer take_nodes() { return std::move(nodes_); }
    Buffer take_tapes() { return std::move(tapes_); }
    Buffer take_in_nodes() { return std::move(in_nodes_); }
    std::size_t node_count() const { return count_; }
    std::size_t in_count() const { return in_count_; }
    std::size_t used_words() const { return used_words_; }

  private:
    void step(int level, const Buffer& ops) {
        evaluated_ = count_;
        Buffer children = device_.allocate(8 * count_ * sizeof(TreeNode));
        Buffer states = device_.allocate(8 * count_ * sizeof(std::int32_t));
        Buffer unknown = device_.allocate((count_ + 1) * sizeof(std::uint32_t));
        Buffer in = device_.allocate((count_ + 1) * sizeof(std::uint32_t));
        reserve(used_words_ + kWordsPerNode * count_);
        for (;;) {
            const auto before = static_cast<std::uint32_t>(used_words_);
            device_.upload(used_, &before, 1);
            device_.launch(descend_, count_, nodes_, tapes_, bounds_, ops, spatial_, children, states,
                           unknown, in, used_, static_cast<std::uint32_t>(capacity_),
                           static_cast<std::int32_t>(level));
            std::uint32_t after = 0;
            device_.download(used_, &after, 1);
            if (after <= capacity_ && after >= before) {
                used_words_ = after;
                break;
            }
            if (after < before || capacity_ >= 0x80000000u) {
                throw Error(ExitCode::kDevice, "the tapes of level " + std::to_string(level) +
                                                   " need more than 2^32 words; use a lower --level");
            }
            reserve(after);
        }
        const std::uint64_t next_count = device_.exclusive_scan_u32(unknown, unknown, count_);
        const std::uint64_t new_in = device_.exclusive_scan_u32(in, in, count_);
        Buffer next = device_.allocate(next_count * sizeof(TreeNode));
        grow(in_nodes_, in_count_ * sizeof(InNode), (in_count_ + new_in) * sizeof(InNode));
        device_.launch(gather_, count_, children, states, unknown, in, next, in_nodes_,
                       static_cast<std::uint32_t>(in_count_), static_cast<std::int32_t>(level));
        device_.finish();
        in_count_ += new_in;
        count_ = next_count;
        nodes_ = std::move(next);
    }

    void reserve(std::size_t words) {
        if (words <= capacity_) return;
        const std::size_t capacity = std::min<std::size_t>(std::max(words, 2 * capacity_), 0xfffffff0u);
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
    std::size_t capacity_ = 0;
    std::size_t used_words_ = 0;
    std::size_t count_ = 0;
    std::size_t in_count_ = 0;
    std::uint64_t evaluated_ = 0;
};

}  // namespace

std::uint64_t make_rank(Device& device, const Buffer& bits, std::size_t words, Buffer& rank) {
    rank = device.allocate((words + 1) * sizeof(std::uint32_t));
    device.launch(device.kernel("octree/leaves.cl", "count_word"), words, bits, rank);
    return device.exclusive_scan_u32(rank, rank, words);
}

Octree build(Device& device, const tape::BoundModel& model, int level, DeviceTree* on_device) {
    if (level < 1 || level > kMaxUniformLevel) {
        throw Error(ExitCode::kUsage, "level " + std::to_string(level) +
                                          " is out of range; a uniform tree has levels 1 to " +
                                          std::to_string(kMaxUniformLevel));
    }
    Octree tree;
    DeviceTree local;
    DeviceTree& view = on_device != nullptr ? *on_device : local;
    tree.level = level;
    view.surfaces = device.upload(model.surfaces);
    view.ops = device.upload(model.expression_ops);
    view.local_formulas = !model.polyhedra.empty();
    Descent descent(device, model);
    descent.run(level, view.ops, tree);
    view.nio = descent.take_nodes();
    view.tapes = descent.take_tapes();
    view.in_nodes = descent.take_in_nodes();

    const std::size_t words = std::max<std::size_t>(1, (std::size_t{1} << (3 * level)) / 32);
    view.in_bits = device.allocate(words * sizeof(std::uint32_t));
    view.nio_bits = device.allocate(words * sizeof(std::uint32_t));
    device.fill_zero(view.in_bits);
    device.fill_zero(view.nio_bits);
    device.launch(device.kernel("octree/leaves.cl", "mark_in"), descent.in_count(), view.in_nodes,
                  view.in_bits, static_cast<std::int32_t>(level));
    device.launch(device.kernel("octree/leaves.cl", "mark_nio"), descent.node_count(), view.nio,
                  view.nio_bits);
    tree.in_count = make_rank(device, view.in_bits, words, view.in_rank);
    make_rank(device, view.nio_bits, words, view.nio_rank);

    tree.nio = device.download<TreeNode>(view.nio, descent.node_count());
    tree.tapes = device.download<std::uint32_t>(view.tapes, descent.used_words());
    tree.in_nodes = device.download<InNode>(view.in_nodes, descent.in_count());
    tree.in_bits = device.download<std::uint32_t>(view.in_bits, words);
    tree.nio_bits = device.download<std::uint32_t>(view.nio_bits, words);
    tree.in_rank = device.download<std::uint32_t>(view.in_rank, words + 1);
    tree.nio_rank = device.download<std::uint32_t>(view.nio_rank, words + 1);
    return tree;
}

std::uint16_t in_region(const Octree& tree, std::uint64_t morton) {
    const auto before = [](const InNode& a, const InNode& b) {
        return a.level != b.level ? a.level < b.level : a.morton < b.morton;
    };
    for (int level = 1; level <= tree.level; ++level) {
        InNode wanted{};
        wanted.level = static_cast<std::uint32_t>(level);
        wanted.morton = morton >> (3 * (tree.level - level));
        const auto found = std::lower_bound(tree.in_nodes.begin(), tree.in_nodes.end(), wanted, before);
        if (found != tree.in_nodes.end() && !before(wanted, *found)) {
            return static_cast<std::uint16_t>(found->region);
        }
    }
    return 1;
}

std::vector<std::uint16_t> in_regions(const Octree& tree, std::uint16_t* single) {
    *single = tree.in_nodes.empty() ? 1 : static_cast<std::uint16_t>(tree.in_nodes[0].region);
    const bool uniform = std::all_of(tree.in_nodes.begin(), tree.in_nodes.end(),
                                     [single](const InNode& node) { return node.region == *single; });
    if (uniform) return {};
    std::vector<std::uint16_t> regions(tree.in_count);
    for (const InNode& node : tree.in_nodes) {
        const int depth = tree.level - static_cast<int>(node.level);
        // Leaves below the node may have left the IN leaves since.
        const std::uint64_t last = ((node.morton + 1) << (3 * depth)) - 1;
        const std::uint32_t first = tree.in_index(node.morton << (3 * depth));
        const std::uint32_t end = tree.in_index(last) + (tree.is_in(last) ? 1 : 0);
        std::fill(regions.begin() + first, regions.begin() + end, static_cast<std::uint16_t>(node.region));
    }
    return regions;
}

}  // namespace mortise::octree
