#include "host/cnio/cell.hpp"

#include <algorithm>
#include <cmath>

namespace mortise::cnio {
namespace {

constexpr int kCentre = 13;  ///< index of the cell itself among its 27 neighbours

int neighbour_index(int dx, int dy, int dz) { return (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1); }

/// Faces of the cell that corner c lies on.
std::uint8_t corner_faces(int c) {
    std::uint8_t faces = 0;
    for (int axis = 0; axis < 3; ++axis)
        faces |= static_cast<std::uint8_t>(1u << (2 * axis + ((c >> axis) & 1)));
    return faces;
}

}  // namespace

void Cell::position(const LatticePoint& p, double* x) const {
    const double unit = std::ldexp(1.0, -(tree_.level + kCellUnitBits));
    for (int j = 0; j < 3; ++j) {
        const std::int64_t whole =
            (static_cast<std::int64_t>(xyz_[j]) << kCellUnitBits) + p[static_cast<std::size_t>(j)];
        x[j] = static_cast<double>(whole) * unit;
    }
}

int Cell::pure_sign(std::size_t surface, const LatticePoint& p) const {
    double x[3];
    position(p, x);
    return surface_sign(&model_.surfaces[surfaces_[surface]], model_.expression_ops.data(), x[0], x[1], x[2],
                        tree_.cell_size());
}

int Cell::value_sign(std::size_t surface, const LatticePoint& p) const {
    double x[3];
    position(p, x);
    const double value =
        surface_value(&model_.surfaces[surfaces_[surface]], model_.expression_ops.data(), x[0], x[1], x[2]);
    return value < 0 ? -1 : 1;
}

LocalNode Cell::add_node(const LatticePoint& p, std::uint8_t faces, std::uint16_t code) {
    Node node;
    node.point = p;
    node.faces = faces;
    node.code = code;
    nodes_.push_back(node);
    for (std::size_t s = 0; s < surfaces_.size(); ++s)
        signs_.push_back(static_cast<std::int8_t>(pure_sign(s, p)));
    return static_cast<LocalNode>(nodes_.size() - 1);
}

LatticePoint Cell::root(std::size_t surface, LocalNode a, LocalNode b) const {
    double low[3];
    double high[3];
    const LatticePoint& from = nodes_[a].point;
    const LatticePoint& to = nodes_[b].point;
    position(from, low);
    position(to, high);
    const double t =
        segment_root(&model_.surfaces[surfaces_[surface]], model_.expression_ops.data(), low, high);
    LatticePoint result;
    for (std::size_t j = 0; j < 3; ++j) {
        result[j] = from[j] + static_cast<std::int32_t>(std::rint(t * static_cast<double>(to[j] - from[j])));
    }
    return result;
}

LocalNode Cell::split_node(std::size_t p, LocalNode a, LocalNode b, const LatticePoint& at, int round,
                           const std::uint8_t* active) {
    const LocalNode m = add_node(at, nodes_[a].faces & nodes_[b].faces);
    const std::size_t done = round == 0 ? p : surfaces_.size();
    for (std::size_t q = 0; q < done; ++q) {
        if (active != nullptr && active[q] == 0) continue;
        const int sa = sign(a, q);
        const int sb = sign(b, q);
        if (sa * sb < 0) continue;  // a split that was refused left the edge mixed: keep the value at m
        set_sign(m, q, sa != 0 ? sa : sb);
    }
    set_sign(m, p, 0);
    return m;
}

bool Cell::snap_end(std::size_t p, LocalNode a, LocalNode b, const LatticePoint& at, double reach,
                    bool inner_only) {
    const double to_a = distance(nodes_[a].point, at);
    const double to_b = distance(nodes_[b].point, at);
    const LocalNode near = to_a <= to_b ? a : b;
    const bool shared = (nodes_[near].faces & (nodes_[near].faces - 1)) != 0;
    if (std::min(to_a, to_b) > reach || (inner_only && shared)) return false;
    set_sign(near, p, 0);
    ++counters.snapped;
    return true;
}

void Cell::load(const TreeNode& leaf) {
    leaf_ = leaf;
    xyz_[0] = gather_bits(leaf.morton);
    xyz_[1] = gather_bits(leaf.morton >> 1);
    xyz_[2] = gather_bits(leaf.morton >> 2);
    nodes_.clear();
    signs_.clear();
    load_active_sets();
    for (int c = 0; c < 8; ++c) {
        const LatticePoint p = {(c & 1) * kCellUnits, ((c >> 1) & 1) * kCellUnits, (c >> 2) * kCellUnits};
        add_node(p, corner_faces(c), static_cast<std::uint16_t>(c));
    }
    load_edges();
    for (int f = 0; f < 6; ++f) partition_face(f);
}

void Cell::load_active_sets() {
    surfaces_.clear();
    const std::uint32_t* words = tree_.tapes.data() + leaf_.tape_offset;
    for (std::uint32_t i = 0; i < leaf_.tape_length; ++i) {
        if (tape_operation(words[i]) == kTapeLiteral) surfaces_.push_back(tape_surface(words[i]));
    }
    std::sort(surfaces_.begin(), surfaces_.end());
    surfaces_.erase(std::unique(surfaces_.begin(), surfaces_.end()), surfaces_.end());
    local_tape_.load(words, leaf_.tape_length, surfaces_);
    const std::size_t n = surfaces_.size();
    const std::int64_t size = std::int64_t{1} << tree_.level;
    neighbour_active_.assign(27 * n, 0);
    for (int k = 0; k < 27; ++k) {
        std::uint8_t* active = neighbour_active_.data() + static_cast<std::size_t>(k) * n;
        const int d[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        if (d[0] * d[1] * d[2] != 0) continue;  // only a vertex in common
        std::uint32_t at[3];
        bool inside = true;
        for (int j = 0; j < 3; ++j) {
            const std::int64_t x = static_cast<std::int64_t>(xyz_[j]) + d[j];
            inside = inside && x >= 0 && x < size;
            at[j] = static_cast<std::uint32_t>(x);
        }
        if (!inside) continue;
        const std::uint64_t code = morton_encode(at[0], at[1], at[2]);
        if (!tree_.is_nio(code)) continue;
        const TreeNode& node = tree_.nio[tree_.nio_index(code)];
        for (std::uint32_t i = 0; i < node.tape_length; ++i) {
            const std::uint32_t word = tree_.tapes[node.tape_offset + i];
            if (tape_operation(word) != kTapeLiteral) continue;
            const auto found = std::lower_bound(surfaces_.begin(), surfaces_.end(), tape_surface(word));
            if (found != surfaces_.end() && *found == tape_surface(word))
                active[found - surfaces_.begin()] = 1;
        }
    }
    edge_active_.assign(12 * n, 0);
    for (int e = 0; e < 12; ++e) {
        const int axis = e / 4;
        const int first = axis == 0 ? 1 : 0;
        const int second = axis == 2 ? 1 : 2;
        int d[3] = {0, 0, 0};
        d[first] = (e & 1) != 0 ? 1 : -1;
        d[second] = (e & 2) != 0 ? 1 : -1;
        const int both = neighbour_index(d[0], d[1], d[2]);
        int only_first[3] = {0, 0, 0};
        int only_second[3] = {0, 0, 0};
        only_first[first] = d[first];
        only_second[second] = d[second];
        const int one = neighbour_index(only_first[0], only_first[1], only_first[2]);
        const int two = neighbour_index(only_second[0], only_second[1], only_second[2]);
        for (std::size_t s = 0; s < n; ++s) {
            edge_active_[static_cast<std::size_t>(e) * n + s] =
                neighbour_active_[static_cast<std::size_t>(both) * n + s] &
                neighbour_active_[static_cast<std::size_t>(one) * n + s] &
                neighbour_active_[static_cast<std::size_t>(two) * n + s];
        }
    }
}

void Cell::load_edges() {
    const std::size_t n = surfaces_.size();
    std::vector<std::pair<std::int32_t, std::size_t>> roots;
    for (int e = 0; e < 12; ++e) {
        edge_nodes_[e].clear();
        const LocalNode low = kEdgeCorners[e][0];
        const LocalNode high = kEdgeCorners[e][1];
        const std::uint8_t* active = edge_active_.data() + static_cast<std::size_t>(e) * n;
        roots.clear();
        double a[3];
        double b[3];
        for (std::size_t s = 0; s < n; ++s) {
            if (active[s] == 0 || sign(low, s) * sign(high, s) >= 0) continue;
            position(nodes_[low].point, a);
            position(nodes_[high].point, b);
            roots.push_back(
                {edge_root(&model_.surfaces[surfaces_[s]], model_.expression_ops.data(), a, b), s});
        }
        std::sort(roots.begin(), roots.end());
        // Roots closer than the margin are one node on several surfaces.
        std::vector<std::size_t> group(roots.size(), 0);
        std::vector<std::int32_t> at;
        for (std::size_t i = 0; i < roots.size(); ++i) {
            if (at.empty() || roots[i].first - at.back() >= kRootMargin) at.push_back(roots[i].first);
            group[i] = at.size() - 1;
        }
        const bool single = roots.size() == 1;
        for (std::size_t g = 0; g < at.size(); ++g) {
            LatticePoint p = nodes_[low].point;
            p[static_cast<std::size_t>(e / 4)] = at[g];
            const LocalNode m = add_node(p, nodes_[low].faces & nodes_[high].faces,
                                         single ? static_cast<std::uint16_t>(8 + e) : kExtraCode);
            edge_nodes_[e].push_back(m);
            for (std::size_t s = 0; s < n; ++s) {
                if (active[s] == 0) continue;
                const int sa = sign(low, s);
                const int sb = sign(high, s);
                if (sa * sb > 0 || (sa == 0) != (sb == 0)) set_sign(m, s, sa != 0 ? sa : sb);
            }
            for (std::size_t i = 0; i < roots.size(); ++i) {
                const std::size_t s = roots[i].second;
                set_sign(m, s, group[i] == g ? 0 : g < group[i] ? sign(low, s) : sign(high, s));
            }
        }
    }
}

}  // namespace mortise::cnio
