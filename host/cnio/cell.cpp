#include "host/cnio/cell.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mortise::cnio {
namespace {

/// Faces and middle planes of the cell that a vertex in halves lies on.
std::uint8_t faces_of(const int* at) {
    std::uint8_t faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (at[axis] != 1) faces |= static_cast<std::uint8_t>(1u << (2 * axis + at[axis] / 2));
    }
    return faces;
}
std::uint8_t middles_of(const int* at) {
    std::uint8_t middles = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (at[axis] == 1) middles |= static_cast<std::uint8_t>(1u << axis);
    }
    return middles;
}

/// The place (-1 … 1) that a half-cell (-1 … 2) lies in.
int place_of(int half) { return half < 0 ? -1 : half > 1 ? 1 : 0; }

}  // namespace

void Cell::position(const LatticePoint& p, double* x) const {
    const double unit = std::ldexp(1.0, -(tree_.level + kCellUnitBits));
    for (int j = 0; j < 3; ++j) x[j] = static_cast<double>(key(j, p[static_cast<std::size_t>(j)])) * unit;
}

int Cell::pure_sign(std::size_t surface, const LatticePoint& p, double size) const {
    double x[3];
    bool negated = false;
    position(p, x);
    if (is_solid(surface)) return solid_sign(x);
    const std::uint32_t at = surface_at(surface, x, &negated);
    const int sign = surface_sign(&model_.surfaces[at], model_.expression_ops.data(), x[0], x[1], x[2], size);
    return negated ? -sign : sign;
}

int Cell::value_sign(std::size_t surface, const LatticePoint& p) const {
    double x[3];
    position(p, x);
    if (is_solid(surface)) return solid_sign(x);
    bool negated = false;
    const std::uint32_t at = surface_at(surface, x, &negated);
    return (model_value(at, x) < 0) != negated ? -1 : 1;
}

LocalNode Cell::add_node(const LatticePoint& p, std::uint8_t faces, std::uint16_t code,
                         std::uint8_t middles) {
    return append_node(p, faces, code, middles, kTogether * scale_.size);
}

/// `size`: of the cells whose tolerance the signs have.
LocalNode Cell::append_node(const LatticePoint& p, std::uint8_t faces, std::uint16_t code,
                            std::uint8_t middles, double size) {
    Node node;
    node.point = node.target = p;
    node.faces = faces;
    node.middles = middles;
    node.code = code;
    nodes_.push_back(node);
    for (std::size_t s = 0; s < surfaces_.size(); ++s)
        signs_.push_back(static_cast<std::int8_t>(pure_sign(s, p, size)));
    return static_cast<LocalNode>(nodes_.size() - 1);
}

LatticePoint Cell::turning_point(std::size_t surface, const LatticePoint& from,
                                 const LatticePoint& to) const {
    constexpr double kLeast = 1.0 / 16;  ///< of the edge, from an end
    double low[3], high[3], middle[3];
    position(from, low);
    position(to, high);
    for (int j = 0; j < 3; ++j) middle[j] = 0.5 * (low[j] + high[j]);
    const std::uint32_t at = surfaces_[surface];
    const double first = model_value(at, low), last = model_value(at, high);
    const double bend = first - 2 * model_value(at, middle) + last;
    const double t = 0.5 + 0.25 * (first - last) / bend;
    return between(from, to, std::isfinite(t) ? std::clamp(t, kLeast, 1 - kLeast) : 0.5);
}

LatticePoint Cell::root(std::size_t surface, const LatticePoint& from, const LatticePoint& to) const {
    double low[3];
    double high[3];
    position(from, low);
    position(to, high);
    return between(from, to, root_between(surface, low, high));
}

LatticePoint Cell::between(const LatticePoint& from, const LatticePoint& to, double t) const {
    LatticePoint result;
    for (std::size_t j = 0; j < 3; ++j) {
        // Both ends are on the lattice of the entity at hand.
        const double steps = static_cast<double>((to[j] - from[j]) / scale_.step);
        result[j] = from[j] + scale_.step * static_cast<std::int32_t>(std::rint(t * steps));
    }
    return result;
}

const std::vector<std::size_t>& Cell::cutting_order() {
    const std::size_t n = surfaces_.size();
    const std::vector<std::uint8_t> all(n, 1);
    std::vector<std::size_t> settled(n);
    for (std::size_t s = 0; s < n; ++s) settled[s] = local_tape_.settled_by(s, all.data());
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    order_.erase(std::remove_if(order_.begin(), order_.end(), [this](std::size_t s) { return !is_named(s); }),
                 order_.end());
    std::stable_sort(order_.begin(), order_.end(),
                     [&settled](std::size_t a, std::size_t b) { return settled[a] > settled[b]; });
    return order_;
}

LocalNode Cell::split_node(const std::vector<std::size_t>& order, std::size_t k, LocalNode a, LocalNode b,
                           const LatticePoint& at, int round, const std::uint8_t* active) {
    const std::size_t p = order[k];
    const LocalNode m = add_node(at, nodes_[a].faces & nodes_[b].faces);
    const std::size_t done = round == 0 ? k : order.size();
    for (std::size_t i = 0; i < done; ++i) {
        const std::size_t q = order[i];
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
    const Node& node = nodes_[near];
    const bool shared = (node.faces & (node.faces - 1)) != 0 || (node.faces != 0 && node.middles != 0);
    if (std::min(to_a, to_b) > reach * scale_.step || (inner_only && shared)) return false;
    set_sign(near, p, 0);
    ++counters.snapped;
    return true;
}

void Cell::load(const TreeNode& leaf) {
    leaf_ = leaf;
    level_ = tree_.level_of(leaf.morton);
    pole_ = tree_.pole_in(leaf.morton);
    size_ = octree::Octree::edge_of(level_);
    for (int j = 0; j < 3; ++j) xyz_[j] = gather_bits(leaf.morton >> j);
    nodes_.clear();
    signs_.clear();
    load_tape();
    load_surroundings();
    load_corners();
    load_edges();
    for (int f = 0; f < 6; ++f) partition_face(f);
    border_nodes_ = nodes_.size();
    border_misplaced_ = misplaced_;
    scale_ = {1, size_};
}

void Cell::load_tape() {
    surfaces_.clear();
    joint_ = nullptr;
    crowded_ = tree_.is_crowded(leaf_.morton);
    if (leaf_.tape_length == 0) {
        local_tape_.load_constant(octree::in_region(tree_, leaf_.morton));
        return;
    }
    const std::uint32_t* words = tree_.tapes.data() + leaf_.tape_offset;
    tape::list_surfaces(words, leaf_.tape_length, surfaces_);
    if (crowded_) {
        load_crowd();
        return;
    }
    load_joint();
    if (joint_ == nullptr) {
        local_tape_.load(words, leaf_.tape_length, surfaces_);
        return;
    }
    plain_tape_.load(words, leaf_.tape_length, surfaces_);
    local_tape_.load(joint_->tape.data(), joint_->tape.size(), surfaces_);
}

/// Which leaves touch the cell, and the active sets of those that share more than a vertex with it.
/// Enters the half-cells of the place in direction d that touch the cell: those of leaf `nio`, or, if that is
/// kNoNio, the smaller leaves there, each with a row of its own.
void Cell::mark_half_cells(const Tree& tree, const i32* d, std::uint32_t nio) {
    int low[3];
    int high[3];
    for (int j = 0; j < 3; ++j) {
        low[j] = d[j] < 0 ? -1 : d[j] > 0 ? 2 : 0;
        high[j] = d[j] < 0 ? -1 : d[j] > 0 ? 2 : 1;
    }
    const u32 half = leaf_edge(&tree, level_) / 2;
    for (int z = low[2]; z <= high[2]; ++z) {
        for (int y = low[1]; y <= high[1]; ++y) {
            for (int x = low[0]; x <= high[0]; ++x) {
                const auto h = static_cast<std::size_t>(half_index(x, y, z));
                if (nio != kNoNio) {
                    half_.nio[h] = nio;
                    half_.row[h] = static_cast<std::uint8_t>(rows_);
                    continue;
                }
                const Leaf fine = leaf_at(&tree, morton_encode(xyz_[0] + half * static_cast<u32>(x),
                                                               xyz_[1] + half * static_cast<u32>(y),
                                                               xyz_[2] + half * static_cast<u32>(z)));
                if (fine.kind != kLeafNio || fine.level != level_ + 1) continue;
                half_.nio[h] = fine.index;
                half_.row[h] = static_cast<std::uint8_t>(rows_);
                load_row(rows_++, fine.index);
            }
        }
    }
}

void Cell::load_surroundings() {
    const std::size_t n = surfaces_.size();
    const Tree tree = tree_.view();
    const u32 edge = leaf_edge(&tree, level_);
    half_.subdivided = 0;
    half_.nio.fill(kNoNio);
    half_.row.fill(0);
    active_.assign(n, 0);
    rows_ = 1;
    for (int k = 0; k < 27; ++k) {
        const i32 d[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const Leaf leaf = leaf_beside(&tree, leaf_.morton, level_, d);
        const bool at_vertex = d[0] * d[1] * d[2] != 0;
        std::uint32_t nio = kNoNio;
        if (leaf.kind != kLeafNone && leaf.level <= level_) {
            if (at_vertex || leaf.kind != kLeafNio) continue;
            nio = leaf.index;
            load_row(rows_, nio);
        } else if (level_ < tree_.level && leaf.code != kNoOwner) {
            const u64 begin =
                code_at(&tree, xyz_[0] + edge * static_cast<u32>(d[0]),
                        xyz_[1] + edge * static_cast<u32>(d[1]), xyz_[2] + edge * static_cast<u32>(d[2]));
            const u64 end = begin + (u64{1} << (3 * (tree_.level - level_)));
            if (meshed_rank(&tree, begin) == meshed_rank(&tree, end)) continue;
            half_.subdivided |= 1u << k;
            if (at_vertex) continue;
        } else {
            continue;
        }
        mark_half_cells(tree, d, nio);
        if (nio != kNoNio) ++rows_;
    }
    units_ = half_.subdivided != 0 ? 2 * kCellUnits : kCellUnits;
    key_shift_ = tree_.level - level_ - (half_.subdivided != 0 ? 1 : 0);
}

/// Which of the cell's surfaces are active in another leaf.
void Cell::load_row(std::size_t row, std::uint32_t nio) {
    const std::size_t n = surfaces_.size();
    active_.resize((row + 1) * n, 0);
    const TreeNode& node = tree_.nio[nio];
    for (std::uint32_t i = 0; i < node.tape_length; ++i) {
        const std::uint32_t word = tree_.tapes[node.tape_offset + i];
        if (tape_operation(word) != kTapeLiteral) continue;
        const std::size_t place = surface_place(tape_surface(word));
        if (place < n) active_[row * n + place] = 1;
    }
    if (crowded_) active_[row * n + n - 1] = tree_.is_crowded(node.morton) ? 1 : 0;
    if (joint_ == nullptr) return;
    const octree::LeafJoint* other = tree_.joint_in(node.morton);
    active_[row * n + n - 1] = other != nullptr && other->joint == joint_->joint ? 1 : 0;
}

/// Whether finer leaves lie in one of the places around a vertex.
bool Cell::is_vertex_fine(int x, int y, int z) const {
    if (half_.subdivided == 0) return false;
    for (int d = 0; d < 8; ++d) {
        if (is_subdivided(place_of(x - 1 + (d & 1)), place_of(y - 1 + ((d >> 1) & 1)),
                          place_of(z - 1 + (d >> 2)))) {
            return true;
        }
    }
    return false;
}

bool Cell::is_face_split(int f) const {
    int d[3] = {0, 0, 0};
    d[f / 2] = (f & 1) != 0 ? 1 : -1;
    return is_subdivided(d[0], d[1], d[2]);
}

/// Whether a node is a corner of the cell, or of a finer leaf, on its edges or faces.
bool Cell::is_grid_vertex(LocalNode node) const {
    return std::find(vertex_.begin(), vertex_.end(), node) != vertex_.end();
}

void Cell::load_corners() {
    vertex_.fill(kNoNode);
    snapped_ = 0;
    misplaced_ = false;
    for (int c = 0; c < 8; ++c) {
        const int at[3] = {2 * (c & 1), 2 * ((c >> 1) & 1), 2 * (c >> 2)};
        const LatticePoint p = {(c & 1) * units_, ((c >> 1) & 1) * units_, (c >> 2) * units_};
        scale_ = is_vertex_fine(at[0], at[1], at[2]) ? half_scale() : whole_scale();
        vertex_[static_cast<std::size_t>(at[0] + 3 * at[1] + 9 * at[2])] =
            append_node(p, faces_of(at), static_cast<std::uint16_t>(c), 0, scale_.size);
        if (!tree_.snapped.empty()) snap_corner(static_cast<LocalNode>(c));
    }
}

/// A vertex of finer leaves on the cell's edges or faces.
LocalNode Cell::grid_vertex(int x, int y, int z) {
    LocalNode& node = vertex_[static_cast<std::size_t>(x + 3 * y + 9 * z)];
    if (node != kNoNode) return node;
    const int at[3] = {x, y, z};
    const std::int32_t half = units_ / 2;
    scale_ = half_scale();
    node = append_node({x * half, y * half, z * half}, faces_of(at), kExtraCode, middles_of(at), scale_.size);
    return node;
}

void Cell::load_edges() {
    for (int e = 0; e < 12; ++e) load_edge(e);
    for (int f = 0; f < 6; ++f) {
        if (is_face_split(f)) load_cross(f);
    }
}

/// Active on an edge is what is active in all leaves around it.
void Cell::load_edge(int e) {
    const std::size_t n = surfaces_.size();
    const int axis = e / 4;
    const int first = first_other(axis);
    const int second = second_other(axis);
    int place[3] = {0, 0, 0};
    const int a = (e & 1) != 0 ? 1 : -1;
    const int b = (e & 2) != 0 ? 1 : -1;
    bool split = false;
    for (int k = 1; k < 4; ++k) {
        place[first] = (k & 1) != 0 ? a : 0;
        place[second] = (k & 2) != 0 ? b : 0;
        split = split || is_subdivided(place[0], place[1], place[2]);
    }
    edge_nodes_[e].clear();
    for (int part = 0; part < (split ? 2 : 1); ++part) {
        segment_active_.assign(n, 1);
        for (int k = 1; k < 4; ++k) {
            int at[3];
            at[axis] = part;
            at[first] = (k & 1) != 0 ? (a < 0 ? -1 : 2) : (a < 0 ? 0 : 1);
            at[second] = (k & 2) != 0 ? (b < 0 ? -1 : 2) : (b < 0 ? 0 : 1);
            const std::uint8_t* other =
                row(half_.row[static_cast<std::size_t>(half_index(at[0], at[1], at[2]))]);
            for (std::size_t s = 0; s < n; ++s) segment_active_[s] &= other[s];
        }
        settle_stand_in(segment_active_.data());
        LocalNode ends[2] = {kEdgeCorners[e][0], kEdgeCorners[e][1]};
        if (split) {
            int middle[3];
            middle[axis] = 1;
            middle[first] = a < 0 ? 0 : 2;
            middle[second] = b < 0 ? 0 : 2;
            const LocalNode m = grid_vertex(middle[0], middle[1], middle[2]);
            if (part == 1) edge_nodes_[e].push_back(m);
            ends[1 - part] = m;
        }
        load_segment(ends[0], ends[1], axis, segment_active_.data(), split ? half_scale() : whole_scale(),
                     split ? kExtraCode : static_cast<std::uint16_t>(8 + e), edge_nodes_[e]);
    }
}

/// The lines across a split face, from the middles of its sides to its centre.
void Cell::load_cross(int f) {
    const std::size_t n = surfaces_.size();
    const int axis = f / 2;
    const int side = (f & 1) != 0 ? 2 : 0;
    const int u = first_other(axis);
    const int v = second_other(axis);
    int at[3];
    at[axis] = side;
    at[u] = 1;
    at[v] = 1;
    const LocalNode centre = grid_vertex(at[0], at[1], at[2]);
    for (int i = 0; i < 4; ++i) {
        const int along = (i & 1) == 0 ? v : u;  // sides 0 and 2 run along u, the cross to them along v
        const int across = along == u ? v : u;
        const bool low = i == 0 || i == 3;
        at[u] = 1;
        at[v] = 1;
        at[along] = low ? 0 : 2;
        const LocalNode middle = grid_vertex(at[0], at[1], at[2]);
        segment_active_.assign(n, 1);
        for (int k = 0; k < 2; ++k) {
            int half[3];
            half[axis] = side == 0 ? -1 : 2;
            half[along] = low ? 0 : 1;
            half[across] = k;
            const std::uint8_t* other =
                row(half_.row[static_cast<std::size_t>(half_index(half[0], half[1], half[2]))]);
            for (std::size_t s = 0; s < n; ++s) segment_active_[s] &= other[s];
        }
        settle_stand_in(segment_active_.data());
        auto& nodes = cross_nodes_[f][i];
        nodes.clear();
        load_segment(low ? middle : centre, low ? centre : middle, along, segment_active_.data(),
                     half_scale(), kExtraCode, nodes);
        if (!low) std::reverse(nodes.begin(), nodes.end());
    }
}

/// Inner nodes of a line between two grid vertices: the roots of its active surfaces, from the low end.
void Cell::load_segment(LocalNode low, LocalNode high, int axis, const std::uint8_t* active,
                        const Scale& scale, std::uint16_t code, std::vector<LocalNode>& out) {
    const std::size_t n = surfaces_.size();
    std::vector<std::pair<std::int32_t, std::size_t>> roots;
    double a[3];
    double b[3];
    scale_ = scale;
    const std::size_t before = out.size();
    for (std::size_t s = 0; s < n; ++s) {
        if (active[s] == 0 || sign(low, s) * sign(high, s) >= 0) continue;
        position(nodes_[low].point, a);
        position(nodes_[high].point, b);
        roots.push_back({edge_units(root_between(s, a, b)), s});
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
        p[static_cast<std::size_t>(axis)] += scale.step * at[g];
        const LocalNode m = add_node(p, nodes_[low].faces & nodes_[high].faces, single ? code : kExtraCode,
                                     nodes_[low].middles & nodes_[high].middles);
        out.push_back(m);
        for (std::size_t s = 0; s < n; ++s) {
            // A surface that touches the line just there stays on the node.
            if (active[s] == 0 || sign(m, s) == 0) continue;
            const int sa = sign(low, s);
            const int sb = sign(high, s);
            if (sa * sb > 0 || (sa == 0) != (sb == 0)) set_sign(m, s, sa != 0 ? sa : sb);
        }
        for (std::size_t i = 0; i < roots.size(); ++i) {
            const std::size_t s = roots[i].second;
            set_sign(m, s, group[i] == g ? 0 : g < group[i] ? sign(low, s) : sign(high, s));
        }
    }
    if (!has_stand_in() || active[n - 1] != 0) return;
    if (crowded_) sync_solid(low, high, out.data() + before, out.size() - before);
    if (joint_ == nullptr) return;
    for (std::size_t i = before; i < out.size(); ++i) sync_joint(out[i]);
}

}  // namespace mortise::cnio
