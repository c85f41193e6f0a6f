// The octree as plain data on the host, and the stage that makes it on the device.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/device/device.hpp"
#include "host/octree/joint.hpp"
#include "host/octree/pole.hpp"
#include "host/octree/snapped.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/pole.hpp"
#include "kernels/shared/tree.h"

namespace mortise::octree {

/// Leaves in Morton order of their codes. See kernels/shared/tree.h for codes, bitmaps and graded trees.
struct Octree {
    int level = 0;                        ///< of the finest leaves
    bool graded = false;                  ///< leaves of several levels
    std::vector<TreeNode> nio;            ///< NIO leaves, ascending code; IN leaves in disguise have no tape
    std::vector<std::uint32_t> tapes;     ///< words of all pruned tapes
    std::vector<std::uint32_t> in_bits;   ///< length: words()
    std::vector<std::uint32_t> nio_bits;  ///< length: words()
    std::vector<std::uint32_t> in_rank;   ///< length: words() + 1
    std::vector<std::uint32_t> nio_rank;  ///< length: words() + 1
    std::vector<std::uint64_t> page_codes;  ///< length: words() >> page_shift
    std::vector<std::uint32_t> directory;   ///< pages before each cell of a coarse level, and twice all
    std::uint32_t directory_shift = 0;
    std::uint32_t page_shift = 0;
    std::vector<std::uint8_t> leaf_marks;  ///< graded trees: per meshed leaf (shared/tree.h)
    std::vector<InNode> in_nodes;          ///< IN nodes of all levels as found, by level, then Morton code
    /// Graded trees: NIO leaves, by index, that touch a finer one, and IN leaves with a finer one at a face
    /// or edge, which join the NIO leaves without a tape. All go to the certificate.
    std::vector<std::uint32_t> transitions;
    std::vector<LeafJoint> joints;       ///< of NIO leaves, ascending code
    std::vector<std::uint64_t> crowded;  ///< codes of NIO leaves too full to be cut (host/cnio), ascending
    std::vector<tape::Pole> poles;       ///< of the solid, each once
    std::vector<LeafPole> leaf_poles;    ///< of NIO leaves, ascending code; one for a leaf
    std::vector<SnappedVertex> snapped;  ///< vertices of complex leaves, ascending code
    std::uint64_t in_count = 0;          ///< IN leaves
    std::uint64_t cells_evaluated = 0;

    std::size_t words() const { return in_bits.size(); }
    TreeShape shape() const {
        return {level, graded ? 1 : 0, static_cast<u32>(words()), directory_shift, page_shift};
    }
    Tree view() const {
        return make_tree(in_bits.data(), nio_bits.data(), in_rank.data(), nio_rank.data(), page_codes.data(),
                         directory.data(), leaf_marks.data(), shape());
    }
    /// Edge of a leaf of this level, box-local.
    static double edge_of(int leaf_level) { return 1.0 / static_cast<double>(1u << leaf_level); }
    double finest_edge() const { return edge_of(level); }
    /// Code of the first cell of a word; behind the last word, the number of finest cells.
    std::uint64_t code_of_word(std::size_t word) const {
        if (word >= words()) return std::uint64_t{1} << (3 * level);
        const Tree tree = view();
        return word_code(&tree, static_cast<u32>(word));
    }
    /// Number of words that hold only codes below this one.
    std::size_t words_below(std::uint64_t code) const {
        const Tree tree = view();
        u32 is_stored = 0;
        return find_word(&tree, code, &is_stored);
    }
    /// The meshed leaf that holds a finest cell.
    Leaf at(std::uint64_t code) const {
        const Tree tree = view();
        return leaf_at(&tree, code);
    }
    int level_of(std::uint64_t code) const {
        const Tree tree = view();
        return leaf_level(&tree, code);
    }
    /// Code of a corner's coordinates, in finest cells, of a cell of this level at `code`.
    std::uint64_t vertex_of(std::uint64_t code, int cell_level, u32 corner) const {
        const u32 edge = u32{1} << (level - cell_level);
        return morton_encode(gather_bits(code) + (corner & 1) * edge,
                             gather_bits(code >> 1) + ((corner >> 1) & 1) * edge,
                             gather_bits(code >> 2) + (corner >> 2) * edge);
    }
    /// Whether the solid stands for all surfaces of a leaf.
    bool is_crowded(std::uint64_t morton) const {
        return std::binary_search(crowded.begin(), crowded.end(), morton);
    }
    /// The joint in a leaf; null if it has none.
    const LeafJoint* joint_in(std::uint64_t morton) const {
        const auto found =
            std::lower_bound(joints.begin(), joints.end(), morton,
                             [](const LeafJoint& a, std::uint64_t code) { return a.morton < code; });
        return found != joints.end() && found->morton == morton ? &*found : nullptr;
    }
    /// The pole in a leaf; null if it has none.
    const LeafPole* pole_in(std::uint64_t morton) const {
        const auto found =
            std::lower_bound(leaf_poles.begin(), leaf_poles.end(), morton,
                             [](const LeafPole& a, std::uint64_t code) { return a.morton < code; });
        return found != leaf_poles.end() && found->morton == morton ? &*found : nullptr;
    }
    /// What is known of a grid vertex that snaps, by the code of its coordinates; null if it does not.
    const SnappedVertex* snapped_at(std::uint64_t vertex) const {
        const auto found =
            std::lower_bound(snapped.begin(), snapped.end(), vertex,
                             [](const SnappedVertex& a, std::uint64_t code) { return a.code < code; });
        return found != snapped.end() && found->code == vertex ? &*found : nullptr;
    }
    bool is_in(std::uint64_t code) const { return at(code).kind == kLeafIn; }
    bool is_nio(std::uint64_t code) const { return at(code).kind == kLeafNio; }
    /// Number of NIO leaves, of IN leaves, before a code.
    std::uint32_t nio_index(std::uint64_t code) const {
        const Tree tree = view();
        return count_before(&tree, nio_bits.data(), nio_rank.data(), code);
    }
    std::uint32_t in_index(std::uint64_t code) const {
        const Tree tree = view();
        return count_before(&tree, in_bits.data(), in_rank.data(), code);
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
    device::Buffer page_codes;
    device::Buffer directory;
    device::Buffer leaf_marks;
    TreeShape shape{};
    device::Buffer in_nodes;      ///< uniform trees only
    device::Buffer surfaces;      ///< Surface
    device::Buffer ops;           ///< ExpressionOp
    bool has_formulas = false;    ///< a surface is a formula
    bool local_formulas = false;  ///< tapes of neighbours may disagree (BoundModel::spatial)
};

/// Sends what kernels need of the model's surfaces.
void send_surfaces(device::Device& device, const tape::BoundModel& model, DeviceTree& on_device);

/// On a CPU device kernels use the host's arrays from now on, instead of copies: half the memory. They must
/// not change unless their buffers are replaced first, and must live until the device has finished.
void share_memory(device::Device& device, Octree& tree, DeviceTree& on_device);

/// Launches a kernel that begins with TREE_PARAMETERS.
template <class... Arguments>
device::Event launch_on(device::Device& device, const DeviceTree& tree, const device::Kernel& kernel,
                        std::size_t items, const Arguments&... arguments) {
    return device.launch(kernel, items, tree.in_bits, tree.nio_bits, tree.in_rank, tree.nio_rank,
                         tree.page_codes, tree.directory, tree.leaf_marks, tree.shape, arguments...);
}

/// Largest level of a uniform tree.
inline constexpr int kMaxUniformLevel = 11;

/// Leaf of the tree in a half-cell (-1 … 2 along each axis, 0 and 1 being the leaf's own) around a leaf.
inline Leaf leaf_at_half(const Tree& tree, std::uint64_t code, int level, int x, int y, int z) {
    const u32 half = leaf_edge(&tree, level) / 2;
    const u64 at = code_at(&tree, gather_bits(code) + half * static_cast<u32>(x),
                           gather_bits(code >> 1) + half * static_cast<u32>(y),
                           gather_bits(code >> 2) + half * static_cast<u32>(z));
    return at != kNoOwner ? leaf_at(&tree, at) : no_leaf(level);
}

/// Throws Error(kMeshing) if these IN nodes and NIO leaves make 2^32 leaves of this level or more.
void check_leaf_count(const std::vector<InNode>& in_nodes, std::uint64_t nio, int level);

/// Builds the tree breadth-first to `level` >= 1 (kernels/octree). Guarantees: IN and OUT leaves are decided
/// on their closed cells; NIO leaves carry the tape of what is undecided; order and content do not depend on
/// the device's scheduling.
Octree build(device::Device& device, const tape::BoundModel& model, int level, DeviceTree* on_device);

/// What a graded tree's leaves must be like. Nodes of level `finest` are never split.
struct Grading {
    int coarsest = 1;  ///< undecided nodes above this level are split
    int finest = 1;
    int coarsest_in = 1;  ///< the same for IN nodes
    /// For undecided nodes of a level from `coarsest` to `finest` - 1, with words of all tapes: not 0 for
    /// those to split. May be empty: none.
    std::function<std::vector<std::uint8_t>(const std::vector<TreeNode>& nodes,
                                            const std::vector<std::uint32_t>& tapes, int level)>
        split_undecided;
    /// Whether the IN node of this region, Morton code and level must be split. May be empty.
    std::function<bool(std::uint64_t morton, int level, std::uint16_t region)> split_in;
};

/// Codes of the nodes that are split, ascending, by their level.
using SplitNodes = std::vector<std::vector<std::uint64_t>>;

/// Adds the nodes that must be split for 2:1 balance across faces, edges and corners: the places around each
/// split node, of its own size, are nodes themselves (as in p4est; docs/design/graded.md). So are those
/// around each node of `ringed`, by level: no larger leaf touches them.
void balance(SplitNodes& split, const SplitNodes& ringed, int threads);

/// Builds a graded tree, 2:1 balanced. Its finest level may be less than Grading::finest. Guarantees as for
/// `build`.
Octree build_graded(device::Device& device, const tape::BoundModel& model, const Grading& grading,
                    int threads, DeviceTree* on_device);

/// Keeps only the words of the leaves' own tapes, in their order, if there are many others: those of nodes
/// that were split. Returns whether it did.
bool drop_unused_tapes(Octree& tree);

/// Ranks of a bitmap of `words` words into a new buffer of words + 1; returns the number of set bits.
std::uint64_t make_rank(device::Device& device, const device::Buffer& bits, std::size_t words,
                        device::Buffer& rank);

/// Region of an IN leaf, also of one among the NIO leaves, by its code.
std::uint16_t in_region(const Octree& tree, std::uint64_t code);

/// Regions of the IN leaves, as runs of IN indices: even a tree of a thousand million leaves has few.
class InRegions {
  public:
    explicit InRegions(const Octree& tree);

    struct Run {
        std::uint32_t end;  ///< behind its last IN leaf
        std::uint16_t region;
    };
    /// The run that holds the IN leaf of this index.
    const Run& run(std::uint32_t in) const {
        return *std::upper_bound(runs_.begin(), runs_.end(), in,
                                 [](std::uint32_t wanted, const Run& run) { return wanted < run.end; });
    }
    std::uint16_t of(std::uint32_t in) const { return run(in).region; }

  private:
    std::vector<Run> runs_;  ///< ascending; neighbours differ
};

}  // namespace mortise::octree
