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

void check_leaf_count(const std::vector<InNode>& in_nodes, std::uint64_t nio, int level) {
    std::uint64_t leaves = nio;
    for (const InNode& node : in_nodes)
        leaves += std::uint64_t{1} << (3 * (static_cast<std::uint32_t>(level) - node.level));
    if (leaves > 0xffffffffu) {
        throw Error(ExitCode::kMeshing, "2^32 or more cells of level " + std::to_string(level) +
                                            " in this model; use a lower --level or a larger --size, or "
                                            "--interior-coarsening");
    }
}

namespace {

/// Makes room for the words of all leaves found, and tells which they are.
void make_pages(Device& device, int level, std::size_t in_nodes, std::size_t nio, DeviceTree& tree) {
    const u32 cells_shift = static_cast<u32>(3 * level);
    tree.shape = {level, 0, 0, 0, 0};
    tree.shape.page_shift = cells_shift < 5 ? 0 : std::min<u32>(kPageShift, cells_shift - 5);
    tree.shape.directory_shift = tree.shape.page_shift + 5;
    const std::size_t most =
        std::max<std::size_t>(1, (std::size_t{1} << cells_shift) >> tree.shape.directory_shift);

    // One more for the end, and one for the code behind the last cell.
    Buffer is_stored = device.allocate((most + 1) * sizeof(std::uint32_t));
    tree.directory = device.allocate((most + 2) * sizeof(std::uint32_t));
    device.fill_zero(is_stored);
    const std::uint32_t first = 1;  // a tree without leaves has words, too
    device.upload(is_stored, &first, 1);
    device.launch(device.kernel("octree/leaves.cl", "store_in"), in_nodes, tree.in_nodes, is_stored,
                  tree.shape);
    device.launch(device.kernel("octree/leaves.cl", "store_nio"), nio, tree.nio, is_stored, tree.shape);
    const std::uint64_t pages = device.exclusive_scan_u32(is_stored, tree.directory, most + 1);
    tree.page_codes = device.allocate(pages * sizeof(std::uint64_t));
    device.launch(device.kernel("octree/leaves.cl", "list_pages"), most, tree.directory, tree.page_codes);
    tree.leaf_marks = device.allocate(0);
    tree.shape.words = static_cast<u32>(pages << tree.shape.page_shift);
}

/// The bitmap of one kind of leaves, and its rank; returns how many there are.
std::uint64_t make_bitmap(Device& device, const char* kernel, const Buffer& nodes, std::size_t count,
                          const DeviceTree& tree, Buffer& bits, Buffer& rank) {
    bits = device.allocate(tree.shape.words * sizeof(std::uint32_t));
    device.fill_zero(bits);
    device.launch(device.kernel("octree/leaves.cl", kernel), count, nodes, tree.directory, bits, tree.shape);
    return make_rank(device, bits, tree.shape.words, rank);
}

}  // namespace

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

    tree.in_nodes = device.download<InNode>(view.in_nodes, descent.in_count());
    check_leaf_count(tree.in_nodes, descent.node_count(), level);
    make_pages(device, level, descent.in_count(), descent.node_count(), view);
    const std::size_t words = view.shape.words;
    tree.in_count =
        make_bitmap(device, "mark_in", view.in_nodes, descent.in_count(), view, view.in_bits, view.in_rank);
    make_bitmap(device, "mark_nio", view.nio, descent.node_count(), view, view.nio_bits, view.nio_rank);

    tree.nio = device.download<TreeNode>(view.nio, descent.node_count());
    tree.tapes = device.download<std::uint32_t>(view.tapes, descent.used_words());
    if (drop_unused_tapes(tree)) {
        view.nio = device.upload(tree.nio);
        view.tapes = device.upload(tree.tapes);
    }
    tree.page_shift = view.shape.page_shift;
    tree.directory_shift = view.shape.directory_shift;
    tree.page_codes = device.download<std::uint64_t>(view.page_codes, words >> tree.page_shift);
    tree.directory = device.download<std::uint32_t>(view.directory, view.directory.bytes() / sizeof(u32));
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
