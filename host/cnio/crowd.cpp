// Crowded cells: so many surfaces that cutting by each of them makes thousands of slivers, and no mesh that a
// solver could use (a screw's thread made of polyhedra narrower than a cell). The solid is their only
// surface: negative inside, with a root wherever that changes. It is active in all entities whose NIO leaves
// are crowded; in others all cells take the surfaces that the leaves have in common, as ever.
#include <algorithm>
#include <cmath>

#include "host/cnio/certificate.hpp"
#include "host/cnio/extract.hpp"
#include "host/common/parallel.hpp"

namespace mortise::cnio {
namespace {

constexpr std::size_t kFewSurfaces = 4;       ///< never too many
constexpr std::size_t kMostSurfaces = 16;     ///< more are always too many
constexpr std::size_t kManyTetrahedra = 400;  ///< of a cell that is not cut as it should be; usually 80
constexpr std::size_t kMostTetrahedra = 700;  ///< of any
constexpr int kRootHalvings = 30;

/// Whether the tape tells one region from the outside.
bool has_one_region(const std::uint32_t* words, std::size_t length) {
    const std::uint32_t last = words[length - 1];
    return tape_operation(last) == kTapeSelectConst && tape_otherwise(last) == 0 &&
           std::none_of(words, words + length - 1, [](std::uint32_t word) {
               return tape_operation(word) == kTapeSelect || tape_operation(word) == kTapeSelectConst;
           });
}

/// Whether the certificate makes too many elements of a leaf.
bool is_overcut(Certificate& certificate, const TreeNode& leaf) {
    CellArena arena;
    const CellCounters before = certificate.counters();
    const CellRecord record = certificate.run(leaf, arena);
    const CellCounters& after = certificate.counters();
    const bool in_trouble = after.refused != before.refused || after.unresolved != before.unresolved;
    return record.element_count[static_cast<std::size_t>(ElementType::kTetrahedron)] >
           (in_trouble ? kManyTetrahedra : kMostTetrahedra);
}

}  // namespace

std::vector<std::uint64_t> find_crowded(const tape::BoundModel& model, const octree::Octree& tree,
                                        const std::vector<std::uint32_t>& leaves, int threads) {
    constexpr std::size_t kChunk = 64;
    std::vector<std::uint8_t> is_crowded(leaves.size(), 0);
    parallel_chunks(leaves.size(), kChunk, thread_count(threads),
                    [&](std::size_t begin, std::size_t end, int) {
                        std::vector<std::uint32_t> surfaces;
                        Certificate certificate(model, tree);
                        for (std::size_t i = begin; i < end; ++i) {
                            const TreeNode& leaf = tree.nio[leaves[i]];
                            const std::uint32_t* words = tree.tapes.data() + leaf.tape_offset;
                            if (leaf.tape_length <= kFewSurfaces || !has_one_region(words, leaf.tape_length))
                                continue;
                            if (tree.joint_in(leaf.morton) != nullptr) continue;
                            tape::list_surfaces(words, leaf.tape_length, surfaces);
                            if (surfaces.size() <= kFewSurfaces) continue;
                            is_crowded[i] = surfaces.size() > kMostSurfaces || is_overcut(certificate, leaf);
                        }
                    });
    std::vector<std::uint64_t> crowded;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (is_crowded[i] != 0) crowded.push_back(tree.nio[leaves[i]].morton);
    }
    return crowded;
}

/// Adds the solid to the surfaces; the cell's tape then asks for it alone.
void Cell::load_crowd() {
    const std::uint32_t* words = tree_.tapes.data() + leaf_.tape_offset;
    surfaces_.push_back(kSolidSurface);
    plain_tape_.load(words, leaf_.tape_length, surfaces_);
    crowd_tape_ = {make_literal(kSolidSurface, 0),
                   make_operation(kTapeSelectConst, tape_region(words[leaf_.tape_length - 1]), 0)};
    local_tape_.load(crowd_tape_.data(), crowd_tape_.size(), surfaces_);
}

/// -1 in the solid, +1 outside, by values alone: in where any leaf around the point says so. Tapes of leaves
/// beside a polyhedron need not agree (host/triangles), and the cells of an entity must.
int Cell::solid_sign(const double* x) const {
    const Tree tree = tree_.view();
    const double cells = std::ldexp(1.0, tree_.level);
    std::uint32_t at[3];
    unsigned on_plane = 0;
    for (unsigned j = 0; j < 3; ++j) {
        const double place = x[j] * cells;
        at[j] = static_cast<std::uint32_t>(std::min(place, cells - 1));
        if (at[j] == place && at[j] != 0) on_plane |= 1u << j;
    }
    for (unsigned d = 0; d < 8; ++d) {
        if ((d & ~on_plane) != 0) continue;
        const Leaf leaf =
            leaf_at(&tree, code_at(&tree, at[0] - (d & 1), at[1] - ((d >> 1) & 1), at[2] - (d >> 2)));
        if (leaf.kind == kLeafIn) return -1;
        if (leaf.kind == kLeafNio && holds(tree_.nio[leaf.index], x)) return -1;
    }
    return 1;
}

/// Whether a leaf's tape has a point in the solid.
bool Cell::holds(const TreeNode& leaf, const double* x) const {
    if (leaf.tape_length == 0) return octree::in_region(tree_, leaf.morton) != 0;
    std::int32_t stack[kTapeStack];
    int top = -1;
    for (std::uint32_t i = 0; i < leaf.tape_length; ++i) {
        const std::uint32_t word = tree_.tapes[leaf.tape_offset + i];
        const std::uint32_t operation = tape_operation(word);
        if (operation == kTapeLiteral) {
            stack[++top] = (model_value(tape_surface(word), x) < 0) != (tape_negated(word) != 0) ? 1 : 0;
        } else if (operation == kTapeSelectConst) {
            stack[top] = combine_select(tape_otherwise(word), stack[top], tape_region(word));
        } else {
            const std::int32_t b = stack[top--];
            stack[top] = operation == kTapeAnd  ? combine_and(stack[top], b)
                         : operation == kTapeOr ? combine_or(stack[top], b)
                                                : combine_select(stack[top], b, tape_region(word));
        }
    }
    return stack[top] > 0;
}

/// Place of a change between two points of which one is in the solid.
double Cell::solid_root(const double* low, const double* high) const {
    const int at_low = solid_sign(low);
    double from = 0;
    double to = 1;
    for (int i = 0; i < kRootHalvings; ++i) {
        const double middle = 0.5 * (from + to);
        double x[3];
        for (int j = 0; j < 3; ++j) x[j] = low[j] + middle * (high[j] - low[j]);
        (solid_sign(x) == at_low ? from : to) = middle;
    }
    return 0.5 * (from + to);
}

/// The closest of the surfaces whose sign decides there whether a point is in the solid; of all, if none
/// does.
std::uint32_t Cell::surface_of_solid(const double* x) const {
    const std::size_t n = surfaces_.size() - 1;
    std::vector<std::int8_t> signs(n + 1, 1);
    for (std::size_t s = 0; s < n; ++s) signs[s] = model_value(surfaces_[s], x) < 0 ? -1 : 1;
    const bool inside = plain_tape_.resolve(signs.data()) > 0;
    std::uint32_t found = surfaces_[0];
    double closest = kMortiseInfinity;
    bool decides = false;
    for (std::size_t s = 0; s < n; ++s) {
        const double distance = distance_to(s, x);
        signs[s] = static_cast<std::int8_t>(-signs[s]);
        const bool flips = (plain_tape_.resolve(signs.data()) > 0) != inside;
        signs[s] = static_cast<std::int8_t>(-signs[s]);
        if (flips < decides || (flips == decides && !(distance < closest))) continue;
        decides = flips;
        closest = distance;
        found = surfaces_[s];
    }
    return found;
}

/// Gives the solid's sign, by those of the others, to a node in a face where they are active.
void Cell::sync_solid(LocalNode node) {
    const std::int32_t region = plain_tape_.resolve(signs(node));
    set_sign(node, surfaces_.size() - 1, region == kUnknown ? 0 : region > 0 ? -1 : 1);
}

/// Gives the solid's sign to nodes of a line where other surfaces are active: zero where it changes from one
/// side of the node to the other.
void Cell::sync_solid(LocalNode low, LocalNode high, const LocalNode* nodes, std::size_t count) {
    const auto between = [this](LocalNode a, LocalNode b) {
        double p[3];
        double q[3];
        position(nodes_[a].point, p);
        position(nodes_[b].point, q);
        for (int j = 0; j < 3; ++j) p[j] = 0.5 * (p[j] + q[j]);
        return solid_sign(p);
    };
    for (std::size_t i = 0; i < count; ++i) {
        const int before = between(i == 0 ? low : nodes[i - 1], nodes[i]);
        const int after = between(nodes[i], i + 1 == count ? high : nodes[i + 1]);
        set_sign(nodes[i], surfaces_.size() - 1, before == after ? before : 0);
    }
}

}  // namespace mortise::cnio
