// Crowded cells: so many surfaces that cutting by each of them makes thousands of slivers, and no mesh that a
// solver could use (a screw's thread made of polyhedra narrower than a cell). The solid is their only
// surface: negative inside, with a root wherever that changes. It is active in all entities whose NIO leaves
// are crowded; in others all cells take the surfaces that the leaves have in common, as ever.
#include <algorithm>
#include <cmath>

#include "host/cnio/cell.hpp"
#include "host/tape/reference.hpp"

namespace mortise::cnio {
namespace {

constexpr int kRootHalvings = 30;

}  // namespace

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
    const std::uint32_t* words = tree_.tapes.data() + leaf.tape_offset;
    tape::list_surfaces(words, leaf.tape_length, around_surfaces_);
    around_signs_.clear();
    for (const std::uint32_t surface : around_surfaces_)
        around_signs_.push_back(model_value(surface, x) < 0 ? -1 : 1);
    return tape::evaluate_signs(words, leaf.tape_length, around_surfaces_.data(), around_surfaces_.size(),
                                around_signs_.data()) > 0;
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
