#include "host/octree/octree.hpp"

#include <algorithm>
#include <string>

#include "host/octree/descent.hpp"

namespace mortise::octree {

std::uint64_t make_rank(Device& device, const Buffer& bits, std::size_t words, Buffer& rank) {
    rank = device.allocate((words + 1) * sizeof(std::uint32_t));
    device.launch(device.kernel("octree/leaves.cl", "count_word"), words, bits, rank);
    return device.exclusive_scan_u32(rank, rank, words);
}

bool drop_unused_tapes(Octree& tree) {
    constexpr std::size_t kFewWords = 4;  // a leaf: not worth the pass
    constexpr std::uint32_t kNowhere = 0xffffffffu;
    if (tree.tapes.size() <= kFewWords * tree.nio.size()) return false;
    std::vector<std::uint32_t> place(tree.tapes.size(), kNowhere);  // where the tape that begins here went
    std::vector<std::uint32_t> words;
    for (TreeNode& leaf : tree.nio) {
        if (leaf.tape_length == 0) continue;
        std::uint32_t& to = place[leaf.tape_offset];
        if (to == kNowhere) {
            to = static_cast<std::uint32_t>(words.size());
            const auto begin = tree.tapes.begin() + leaf.tape_offset;
            words.insert(words.end(), begin, begin + leaf.tape_length);
        }
        leaf.tape_offset = to;
    }
    words.shrink_to_fit();
    tree.tapes = std::move(words);
    return true;
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
    send_surfaces(device, model, view);
    Descent descent(device, model);
    for (int l = 1; l <= level && descent.node_count() > 0; ++l) descent.step(l, view.ops);
    tree.cells_evaluated = descent.cells_evaluated();
    view.nio = descent.take_nodes();
    view.tapes = descent.take_tapes();
    view.in_nodes = descent.take_in_nodes();

    const std::size_t words = std::max<std::size_t>(1, (std::size_t{1} << (3 * level)) / 32);
    view.word_codes = device.allocate(0);
    view.directory = device.allocate(0);
    view.leaf_marks = device.allocate(0);
    view.shape = {level, 0, static_cast<u32>(words), 0};
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
    if (drop_unused_tapes(tree)) {
        view.nio = device.upload(tree.nio);
        view.tapes = device.upload(tree.tapes);
    }
    tree.in_nodes = device.download<InNode>(view.in_nodes, descent.in_count());
    tree.in_bits = device.download<std::uint32_t>(view.in_bits, words);
    tree.nio_bits = device.download<std::uint32_t>(view.nio_bits, words);
    tree.in_rank = device.download<std::uint32_t>(view.in_rank, words + 1);
    tree.nio_rank = device.download<std::uint32_t>(view.nio_rank, words + 1);
    return tree;
}

std::uint16_t in_region(const Octree& tree, std::uint64_t code) {
    const auto before = [](const InNode& a, const InNode& b) {
        return a.level != b.level ? a.level < b.level : a.morton < b.morton;
    };
    for (int level = 1; level <= tree.level; ++level) {
        InNode wanted{};
        wanted.level = static_cast<std::uint32_t>(level);
        wanted.morton = code >> (3 * (tree.level - level));
        const auto found = std::lower_bound(tree.in_nodes.begin(), tree.in_nodes.end(), wanted, before);
        if (found != tree.in_nodes.end() && !before(wanted, *found)) {
            return static_cast<std::uint16_t>(found->region);
        }
    }
    return 1;
}

void send_surfaces(device::Device& device, const tape::BoundModel& model, DeviceTree& on_device) {
    on_device.surfaces = device.upload(model.surfaces);
    on_device.ops = device.upload(model.expression_ops);
    on_device.has_formulas =
        std::any_of(model.surfaces.begin(), model.surfaces.end(),
                    [](const Surface& surface) { return surface.kind == kSurfaceExpression; });
    on_device.local_formulas = !model.polyhedra.empty();
}

void share_memory(device::Device& device, Octree& tree, DeviceTree& on_device) {
    if (device.info().is_gpu) return;
    const auto share = [&device](auto& values, device::Buffer& buffer) {
        if (values.empty()) return;
        buffer = device.wrap(values.data(), values.size() * sizeof values[0]);
        device.sync_to_device(buffer);
    };
    device.finish();
    share(tree.nio, on_device.nio);
    share(tree.tapes, on_device.tapes);
    share(tree.in_bits, on_device.in_bits);
    share(tree.nio_bits, on_device.nio_bits);
    share(tree.in_rank, on_device.in_rank);
    share(tree.nio_rank, on_device.nio_rank);
}

InRegions::InRegions(const Octree& tree) {
    std::vector<std::pair<std::uint64_t, std::uint16_t>> nodes;  // by the code of their first cell
    for (const InNode& node : tree.in_nodes) {
        const int depth = tree.level - static_cast<int>(node.level);
        nodes.push_back({node.morton << (3 * depth), static_cast<std::uint16_t>(node.region)});
    }
    // Levels follow one another, each in Morton order.
    for (auto sorted = std::is_sorted_until(nodes.begin(), nodes.end()); sorted != nodes.end();) {
        const auto next = std::is_sorted_until(sorted, nodes.end());
        std::inplace_merge(nodes.begin(), sorted, next);
        sorted = next;
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const auto end = i + 1 < nodes.size() ? tree.in_index(nodes[i + 1].first)
                                              : static_cast<std::uint32_t>(tree.in_count);
        // A node's leaves may all have left the IN leaves since.
        if (end == (runs_.empty() ? 0 : runs_.back().end)) continue;
        if (runs_.empty() || runs_.back().region != nodes[i].second) {
            runs_.push_back({end, nodes[i].second});
        } else {
            runs_.back().end = end;
        }
    }
}

}  // namespace mortise::octree
