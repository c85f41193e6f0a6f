// Graded trees: which nodes are split, then the leaves that follow.
//
// The descent runs twice: the first pass finds the nodes that must be split by what they hold, then balance
// adds its own, and the second pass splits exactly these. Both passes are those of a uniform tree, on fewer
// nodes.
#include <algorithm>

#include "host/common/parallel.hpp"
#include "host/octree/descent.hpp"
#include "host/octree/octree.hpp"

namespace mortise::octree {
namespace {

constexpr std::size_t kLeafChunk = 4096;
constexpr std::uint64_t kMostSplit = 1u << 25;  ///< split nodes: eight times as many leaves
constexpr int kDirectoryLevel = 6;              ///< finest, of the cells of the directory: 1 MB

/// One leaf before the bitmaps are made.
struct Entry {
    std::uint64_t code;
    std::uint8_t level;
    bool is_in;
    std::uint32_t node;  ///< NIO: index into the list of NIO leaves as found
};

bool holds(const std::vector<std::uint64_t>& codes, std::uint64_t code) {
    return std::binary_search(codes.begin(), codes.end(), code);
}

/// Calls visit(morton, level) for IN nodes below and at one, parents first; true: its children, too.
template <class Visit>
void visit_in(const InNode& root, const Visit& visit) {
    struct Item {
        std::uint64_t morton;
        int level;
    };
    std::vector<Item> stack = {{root.morton, static_cast<int>(root.level)}};
    while (!stack.empty()) {
        const Item item = stack.back();
        stack.pop_back();
        if (!visit(item.morton, item.level)) continue;
        for (std::uint64_t c = 8; c-- > 0;) stack.push_back({(item.morton << 3) | c, item.level + 1});
    }
}

class Builder {
  public:
    Builder(Device& device, const tape::BoundModel& model, const Grading& grading, int threads,
            DeviceTree& view)
        : device_(device), model_(model), grading_(grading), threads_(threads), on_device_(view) {}

    Octree run() {
        find_split_nodes();
        balance(split_, undecided_, threads_);
        undecided_.clear();
        while (!split_.empty() && split_.back().empty()) split_.pop_back();
        tree_.level = std::max<int>(1, static_cast<int>(split_.size()));
        tree_.graded = true;
        find_leaves();
        make_bitmaps();
        mark_transitions();
        drop_unused_tapes(tree_);
        upload();
        return std::move(tree_);
    }

  private:
    /// First pass: nodes that are too large, and the IN nodes that are.
    void find_split_nodes() {
        Descent descent(device_, model_);
        std::vector<std::uint32_t> tapes;
        split_.assign(static_cast<std::size_t>(grading_.finest), {});
        split_[0] = {0};
        undecided_.assign(static_cast<std::size_t>(grading_.finest) + 1, {});
        for (int level = 1; level <= grading_.finest && descent.node_count() > 0; ++level) {
            descent.step(level, on_device_.ops);
            std::vector<TreeNode> nodes = descent.nodes();
            if (level >= grading_.coarsest) {
                std::vector<std::uint8_t> wanted(nodes.size(), 0);
                if (grading_.split_undecided && level < grading_.finest) {
                    descent.fetch_tapes(tapes);
                    wanted = grading_.split_undecided(nodes, tapes, level);
                }
                std::size_t kept = 0;
                auto& leaves = undecided_[static_cast<std::size_t>(level)];
                for (std::size_t i = 0; i < nodes.size(); ++i) {
                    if (wanted[i] != 0)
                        nodes[kept++] = nodes[i];
                    else
                        leaves.push_back(nodes[i].morton);
                }
                nodes.resize(kept);
                descent.set_nodes(nodes);
            }
            for (const TreeNode& node : nodes) split_[static_cast<std::size_t>(level)].push_back(node.morton);
            count_split(nodes.size(), level);
        }
        tree_.cells_evaluated += descent.cells_evaluated();
        const std::size_t in_count = descent.in_count();
        const Buffer in = descent.take_in_nodes();
        for (const InNode& root : device_.download<InNode>(in, in_count)) {
            visit_in(root, [&](std::uint64_t morton, int level) {
                const bool wanted =
                    level < grading_.finest &&
                    (level < grading_.coarsest_in ||
                     (grading_.split_in &&
                      grading_.split_in(morton, level, static_cast<std::uint16_t>(root.region))));
                if (wanted) {
                    split_[static_cast<std::size_t>(level)].push_back(morton);
                    count_split(1, level);
                }
                return wanted;
            });
        }
    }

    void count_split(std::uint64_t nodes, int level) {
        split_count_ += nodes;
        if (split_count_ <= kMostSplit) return;
        throw Error(ExitCode::kUsage, "the sizes that are asked for need more than " +
                                          std::to_string(8 * kMostSplit / 1000000) +
                                          " million cells, at level " + std::to_string(level + 1) +
                                          " already; ask for larger cells, or set --size-min");
    }

    bool is_split(std::uint64_t morton, int level) const {
        return static_cast<std::size_t>(level) < split_.size() &&
               holds(split_[static_cast<std::size_t>(level)], morton);
    }

    /// Second pass: exactly the nodes of split_ are split.
    void find_leaves() {
        Descent descent(device_, model_);
        std::vector<TreeNode> found;
        for (int level = 1; level <= tree_.level && descent.node_count() > 0; ++level) {
            descent.step(level, on_device_.ops);
            std::vector<TreeNode> nodes = descent.nodes();
            std::size_t kept = 0;
            for (const TreeNode& node : nodes) {
                if (is_split(node.morton, level)) {
                    nodes[kept++] = node;
                } else {
                    add_leaf(node.morton, level, false, static_cast<std::uint32_t>(found.size()));
                    found.push_back(node);
                }
            }
            nodes.resize(kept);
            descent.set_nodes(nodes);
        }
        descent.fetch_tapes(tree_.tapes);
        tree_.cells_evaluated += descent.cells_evaluated();
        const std::size_t in_count = descent.in_count();
        const Buffer in = descent.take_in_nodes();
        tree_.in_nodes = device_.download<InNode>(in, in_count);
        for (const InNode& root : tree_.in_nodes) {
            visit_in(root, [&](std::uint64_t morton, int level) {
                if (is_split(morton, level)) return true;
                add_leaf(morton, level, true, 0);
                return false;
            });
        }
        std::sort(entries_.begin(), entries_.end(),
                  [](const Entry& a, const Entry& b) { return a.code < b.code; });
        found_ = std::move(found);
    }

    void add_leaf(std::uint64_t morton, int level, bool is_in, std::uint32_t node) {
        entries_.push_back(
            {morton << (3 * (tree_.level - level)), static_cast<std::uint8_t>(level), is_in, node});
    }

    void make_bitmaps() {
        tree_.leaf_marks.reserve(entries_.size());
        for (const Entry& entry : entries_) {
            const std::uint64_t word = entry.code >> 5;
            if (tree_.page_codes.empty() || tree_.page_codes.back() != word) {
                tree_.page_codes.push_back(word);
                tree_.in_bits.push_back(0);
                tree_.nio_bits.push_back(0);
            }
            auto& bits = entry.is_in ? tree_.in_bits : tree_.nio_bits;
            bits.back() |= 1u << (entry.code & 31);
            tree_.leaf_marks.push_back(entry.level);
        }
        if (tree_.page_codes.empty()) {  // nothing is meshed
            tree_.page_codes = {0};
            tree_.in_bits = {0};
            tree_.nio_bits = {0};
        }
        make_directory();
        make_ranks();
    }

    void make_directory() {
        const int level = std::clamp(tree_.level - 2, 0, kDirectoryLevel);
        tree_.directory_shift = static_cast<std::uint32_t>(3 * (tree_.level - level));
        const std::size_t cells = std::size_t{1} << (3 * level);
        // One more for the end, and one for the code behind the last cell.
        tree_.directory.assign(cells + 2, 0);
        for (const std::uint64_t word : tree_.page_codes)
            ++tree_.directory[((word << 5) >> tree_.directory_shift) + 1];
        for (std::size_t i = 1; i < tree_.directory.size(); ++i) tree_.directory[i] += tree_.directory[i - 1];
    }

    void make_ranks() {
        const auto rank = [](const std::vector<std::uint32_t>& bits, std::vector<std::uint32_t>& out) {
            out.assign(1, 0);
            for (const std::uint32_t word : bits) out.push_back(out.back() + count_bits(word));
        };
        rank(tree_.in_bits, tree_.in_rank);
        rank(tree_.nio_bits, tree_.nio_rank);
        tree_.in_count = tree_.in_rank.back();
    }

    enum Mark : std::uint8_t { kTouched = 1, kBeside = 2 };

    /// Leaves with finer ones in a place around them, from the place's side: a split node that holds meshed
    /// leaves. Whether these touch the leaf does not matter: the places around an edge or face decide about
    /// it.
    std::vector<std::uint8_t> find_marks() const {
        const Tree view = tree_.view();
        std::vector<std::uint8_t> marks(entries_.size(), 0);
        for (std::size_t level = 1; level < split_.size(); ++level) {
            const auto& nodes = split_[level];
            std::vector<std::vector<std::pair<std::uint32_t, std::uint8_t>>> parts(
                chunk_count(nodes.size(), kLeafChunk));
            parallel_chunks(nodes.size(), kLeafChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    mark_around(view, nodes[i], static_cast<int>(level), parts[begin / kLeafChunk]);
                }
            });
            for (const auto& part : parts) {
                for (const auto& [rank, mark] : part) marks[rank] |= mark;
            }
        }
        return marks;
    }

    static void mark_around(const Tree& view, std::uint64_t morton, int level,
                            std::vector<std::pair<std::uint32_t, std::uint8_t>>& out) {
        const int depth = 3 * (view.shape.level - level);
        const std::uint64_t begin = morton << depth;
        if (meshed_rank(&view, begin) == meshed_rank(&view, begin + (std::uint64_t{1} << depth))) return;
        for (int k = 0; k < 27; ++k) {
            const i32 direction[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
            const Leaf leaf = leaf_beside(&view, begin, level, direction);
            if (leaf.kind == kLeafNone || leaf.level != level) continue;
            const bool beside = direction[0] == 0 || direction[1] == 0 || direction[2] == 0;
            out.push_back({meshed_rank(&view, leaf.code),
                           static_cast<std::uint8_t>(beside ? kTouched | kBeside : kTouched)});
        }
    }

    /// IN leaves with finer ones beside them join the NIO leaves; then the lists are made.
    void mark_transitions() {
        const std::vector<std::uint8_t> marks = find_marks();
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            Entry& entry = entries_[i];
            const bool joins = entry.is_in && (marks[i] & kBeside) != 0;
            if (marks[i] != 0) tree_.leaf_marks[i] |= kFinerAround;
            if (entry.is_in && !joins) continue;
            if (marks[i] != 0) tree_.transitions.push_back(static_cast<std::uint32_t>(tree_.nio.size()));
            if (joins) {
                const auto word = static_cast<std::size_t>(
                    std::lower_bound(tree_.page_codes.begin(), tree_.page_codes.end(), entry.code >> 5) -
                    tree_.page_codes.begin());
                tree_.in_bits[word] &= ~(1u << (entry.code & 31));
                tree_.nio_bits[word] |= 1u << (entry.code & 31);
                tree_.nio.push_back({entry.code, 0, 0});
            } else {
                TreeNode node = found_[entry.node];
                node.morton = entry.code;
                tree_.nio.push_back(node);
            }
        }
        make_ranks();
    }

    void upload() {
        on_device_.nio = device_.upload(tree_.nio);
        on_device_.tapes = device_.upload(tree_.tapes);
        on_device_.in_bits = device_.upload(tree_.in_bits);
        on_device_.nio_bits = device_.upload(tree_.nio_bits);
        on_device_.in_rank = device_.upload(tree_.in_rank);
        on_device_.nio_rank = device_.upload(tree_.nio_rank);
        on_device_.page_codes = device_.upload(tree_.page_codes);
        on_device_.directory = device_.upload(tree_.directory);
        on_device_.leaf_marks = device_.upload(tree_.leaf_marks);
        on_device_.shape = tree_.shape();
    }

    Device& device_;
    const tape::BoundModel& model_;
    const Grading& grading_;
    int threads_;
    DeviceTree& on_device_;
    Octree tree_;
    SplitNodes split_;
    SplitNodes undecided_;  ///< leaves of the first pass: what touches them is not larger, as far as possible
    std::vector<Entry> entries_;
    std::vector<TreeNode> found_;  ///< NIO leaves as found
    std::uint64_t split_count_ = 0;
};

}  // namespace

Octree build_graded(Device& device, const tape::BoundModel& model, const Grading& grading, int threads,
                    DeviceTree* on_device) {
    DeviceTree local;
    DeviceTree& view = on_device != nullptr ? *on_device : local;
    send_surfaces(device, model, view);
    return Builder(device, model, grading, threads, view).run();
}

}  // namespace mortise::octree
