// Meshes of a cell's faces, or of quarters of those that are split: whole (F0), cut by one chord (F1), or a
// fan bisected by each surface in turn (F2).
#include <algorithm>

#include "host/cnio/cell.hpp"
#include "host/common/cube_grid.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/watch.hpp"
#include "host/tape/reference.hpp"

namespace mortise::cnio {
namespace {

// A face that holds too many surfaces stays as it is then, from both sides.
constexpr std::size_t kMostFaceWork = 1u << 14;  ///< triangles times surfaces
constexpr std::size_t kFewestTriangles = 64;

/// Height of a triangle over its longest side, relative to it, squared. The arithmetic is that of templates
/// (triangle_shape in kernels/shared/cell_boundary.h), which meet undisplaced faces.
double shape(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
    const double longest = std::max({squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)});
    return squared_normal(a, b, c) / (longest * longest);
}

/// Order of a patch's corners by u + 2 v.
constexpr std::array<std::uint8_t, 4> kCornerRank = {0, 1, 3, 2};

/// Place of a node among the corners of a patch; 4 if it is none.
std::size_t corner_of(const Patch& patch, LocalNode node) {
    return static_cast<std::size_t>(std::find(patch.corner.begin(), patch.corner.end(), node) -
                                    patch.corner.begin());
}

/// The same for any node, for comparison: corners first, by their rank.
std::size_t rank_in(const Patch& patch, LocalNode node) {
    const std::size_t corner = corner_of(patch, node);
    return corner < 4 ? kCornerRank[corner] : 4 + std::size_t{node};
}

void append(std::vector<LocalNode>& loop, const std::vector<LocalNode>& nodes, bool forward) {
    if (forward)
        loop.insert(loop.end(), nodes.begin(), nodes.end());
    else
        loop.insert(loop.end(), nodes.rbegin(), nodes.rend());
}

}  // namespace

std::size_t Cell::patch_corner(int p, LocalNode node) const {
    const auto& corners = patch_corners_[p];
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), node) - corners.begin());
}

bool Cell::has_whole_faces() const {
    for (int f = 0; f < 6; ++f) {
        if (is_face_split(f) || modes_[4 * f] != FaceMode::kWhole) return false;
    }
    return true;
}

void Cell::partition_face(int f) {
    for (int p = 4 * f; p < 4 * f + 4; ++p) patches_[p].clear();
    if (is_face_split(f)) {
        // In the order of the leaves beyond.
        for (int q = 0; q < 4; ++q) partition_quarter(f, q & 1, q >> 1);
        return;
    }
    const auto axis = static_cast<std::size_t>(f / 2);
    Patch patch;
    patch.face = f;
    patch.middle = centre();
    patch.middle[axis] = (f & 1) * units_;
    int half[3] = {0, 0, 0};
    half[axis] = (f & 1) != 0 ? 2 : -1;
    const auto h = static_cast<std::size_t>(half_index(half[0], half[1], half[2]));
    patch.row = half_.row[h];
    patch.beyond = half_.nio[h];
    patch.scale = whole_scale();
    std::vector<LocalNode> loop;
    for (std::size_t i = 0; i < 4; ++i) {
        const int e = kFaceEdges[f][i];
        patch.corner[i] = kFaceCorners[f][i];
        loop.push_back(patch.corner[i]);
        // The loop runs along the first two edges and against the last two.
        append(loop, edge_nodes_[e], i < 2);
        // Nodes of a split edge are on the finer lattice, for both cells.
        for (const LocalNode node : edge_nodes_[e]) {
            if (nodes_[node].middles != 0) patch.scale.step = 1;
        }
    }
    partition_patch(patch, loop, 4 * f);
}

/// Quarter (u, v) of a split face.
void Cell::partition_quarter(int f, int u, int v) {
    const auto axis = static_cast<std::size_t>(f / 2);
    const auto u_axis = static_cast<std::size_t>(first_other(f / 2));
    const auto v_axis = static_cast<std::size_t>(second_other(f / 2));
    Patch patch;
    patch.face = f;
    patch.quarter = true;
    patch.middle[axis] = (f & 1) * units_;
    patch.middle[u_axis] = (1 + 2 * u) * (units_ / 4);
    patch.middle[v_axis] = (1 + 2 * v) * (units_ / 4);
    int half[3];
    half[axis] = (f & 1) != 0 ? 2 : -1;
    half[u_axis] = u;
    half[v_axis] = v;
    const auto h = static_cast<std::size_t>(half_index(half[0], half[1], half[2]));
    patch.row = half_.row[h];
    patch.beyond = half_.nio[h];
    patch.scale = half_scale();
    for (std::size_t i = 0; i < 4; ++i) {
        int at[3];
        at[axis] = (f & 1) * 2;
        at[u_axis] = u + (i == 1 || i == 2 ? 1 : 0);
        at[v_axis] = v + (i >= 2 ? 1 : 0);
        patch.corner[i] = grid_vertex(at[0], at[1], at[2]);
    }
    // Sides of the quarter: halves of two edges of the cell, and two of the face's cross lines. Side i of the
    // face: 0 at v = 0, 1 at u = 1, 2 at v = 1, 3 at u = 0.
    const auto edge_half = [&](int i, bool upper) {
        const auto& nodes = edge_nodes_[kFaceEdges[f][i]];
        const auto split =
            std::find_if(nodes.begin(), nodes.end(), [this](LocalNode node) { return is_grid_vertex(node); });
        return upper ? std::vector<LocalNode>(split + 1, nodes.end())
                     : std::vector<LocalNode>(nodes.begin(), split);
    };
    const auto cross = [&](int i, bool towards_low) {
        std::vector<LocalNode> nodes = cross_nodes_[f][i];
        // Sides 0 and 3 are at the low end of their cross line.
        if ((i == 0 || i == 3) == towards_low) std::reverse(nodes.begin(), nodes.end());
        return nodes;
    };
    std::vector<LocalNode> loop;
    loop.push_back(patch.corner[0]);  // along u, at the quarter's low v
    append(loop, v == 0 ? edge_half(0, u == 1) : cross(u == 0 ? 3 : 1, false), true);
    loop.push_back(patch.corner[1]);  // along v, at its high u
    append(loop, u == 1 ? edge_half(1, v == 1) : cross(v == 0 ? 0 : 2, false), true);
    loop.push_back(patch.corner[2]);  // against u, at its high v
    append(loop, v == 1 ? edge_half(2, u == 1) : cross(u == 0 ? 3 : 1, false), false);
    loop.push_back(patch.corner[3]);  // against v, at its low u
    append(loop, u == 0 ? edge_half(3, v == 1) : cross(v == 0 ? 0 : 2, false), false);
    partition_patch(patch, loop, 4 * f + u + 2 * v);
}

void Cell::partition_patch(const Patch& patch, const std::vector<LocalNode>& loop, int p) {
    auto& facets = patches_[p];
    patch_corners_[p] = patch.corner;
    patch_active_.assign(row(patch.row), row(patch.row) + surfaces_.size());
    settle_stand_in(patch_active_.data());
    scale_ = patch.scale;
    modes_[p] = patch_mode(loop, patch);
    if (modes_[p] == FaceMode::kWhole) {
        facets.push_back({{loop[0], loop[1], loop[2], loop[3]}, 4});
    } else if (modes_[p] == FaceMode::kSplit) {
        const std::size_t odd = odd_corner(patch);
        const auto at = [&](std::size_t k) { return loop[(odd + k) % 4]; };
        facets.push_back({{at(0), at(1), at(2), at(2)}, 3});
        facets.push_back({{at(0), at(2), at(3), at(3)}, 3});
    } else if (modes_[p] == FaceMode::kHanging) {
        divide_hanging(loop, patch, facets);
    } else if (modes_[p] == FaceMode::kCut) {
        cut_patch(loop, patch, facets);
    } else {
        fan_patch(loop, patch, facets);
    }
}

FaceMode Cell::patch_mode(const std::vector<LocalNode>& loop, const Patch& patch) {
    const std::size_t n = surfaces_.size();
    const std::uint8_t* active = patch_active_.data();
    std::size_t crossing = n;
    for (std::size_t s = 0; s < n; ++s) {
        if (active[s] == 0) continue;
        const Sides around = sides(loop.data(), loop.size(), s);
        if (around.are_mixed()) {
            if (crossing != n) return FaceMode::kFan;
            crossing = s;
            continue;
        }
        const int at_middle = middle_sign(s, patch);
        if (around.sign() * at_middle < 0) return FaceMode::kFan;
    }
    if (crossing == n) {
        if (loop.size() == 4) return odd_corner(patch) < 4 ? FaceMode::kSplit : FaceMode::kWhole;
        const bool plain = std::all_of(loop.begin(), loop.end(), [&](LocalNode node) {
            return corner_of(patch, node) < 4 || is_grid_vertex(node);
        });
        return plain ? FaceMode::kHanging : FaceMode::kFan;
    }
    crossing_ = crossing;
    // One surface: two zero nodes that part the loop into one negative and one positive run.
    int zeros = 0;
    int changes = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const int here = sign(loop[i], crossing);
        const int next = sign(loop[(i + 1) % loop.size()], crossing);
        if (here * next < 0) return FaceMode::kFan;
        const bool is_corner = corner_of(patch, loop[i]) < 4;
        if (here == 0) {
            ++zeros;
            const int before = sign(loop[(i + loop.size() - 1) % loop.size()], crossing);
            if (before * next < 0) ++changes;
        } else if (!is_corner) {
            return FaceMode::kFan;  // a node of another surface, or of finer leaves
        }
        if (!is_corner && is_grid_vertex(loop[i])) return FaceMode::kFan;
    }
    if (zeros != 2 || changes != 2) return FaceMode::kFan;
    // Where a joint parts the face, its point there becomes a node.
    LatticePoint centre;
    const bool parted = is_joint(crossing) &&
                        apex_on({patch.middle, patch.face / 2, patch.scale}, {joined_[0], crossing}, centre);
    return parted ? FaceMode::kFan : FaceMode::kCut;
}

/// A whole face some of whose edges are split: the face rule of host/common/cube_grid.hpp.
void Cell::divide_hanging(const std::vector<LocalNode>& loop, const Patch& patch,
                          std::vector<Facet>& facets) {
    std::array<LocalNode, 8> at{};
    std::copy(patch.corner.begin(), patch.corner.end(), at.begin());
    unsigned sides = 0;
    std::size_t side = 3;
    for (const LocalNode node : loop) {
        const std::size_t c = corner_of(patch, node);
        if (c < 4) {
            side = c;
            continue;
        }
        at[4 + side] = node;
        sides |= 1u << side;
    }
    for (const SplitFacet& facet : split_face(sides)) {
        const auto node = [&](std::size_t k) { return at[facet.place[k]]; };
        facets.push_back({{node(0), node(1), node(2), node(facet.count == 4 ? 3 : 2)}, facet.count});
    }
}

void Cell::cut_patch(const std::vector<LocalNode>& loop, const Patch& patch, std::vector<Facet>& facets) {
    std::vector<std::size_t> ends;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        if (sign(loop[i], crossing_) == 0) ends.push_back(i);
    }
    for (int side = 0; side < 2; ++side) {
        std::vector<LocalNode> polygon;
        const std::size_t from = ends[static_cast<std::size_t>(side)];
        const std::size_t to = ends[static_cast<std::size_t>(1 - side)];
        for (std::size_t i = from;; i = (i + 1) % loop.size()) {
            polygon.push_back(loop[i]);
            if (i == to) break;
        }
        add_polygon(polygon, patch, facets);
    }
}

void Cell::add_polygon(const std::vector<LocalNode>& polygon, const Patch& patch,
                       std::vector<Facet>& facets) {
    const auto point = [&](std::size_t i) -> const LatticePoint& { return nodes_[polygon[i]].point; };
    if (polygon.size() == 3) {
        facets.push_back({{polygon[0], polygon[1], polygon[2], polygon[2]}, 3});
        return;
    }
    if (polygon.size() == 4) {
        // Two corners and two cuts stay a quadrilateral; with a corner on the surface the better diagonal
        // splits it.
        if (corner_of(patch, polygon[0]) == 4 && corner_of(patch, polygon[3]) == 4) {
            facets.push_back({{polygon[0], polygon[1], polygon[2], polygon[3]}, 4});
            return;
        }
        const double first =
            std::min(shape(point(0), point(1), point(2)), shape(point(0), point(2), point(3)));
        const double second =
            std::min(shape(point(0), point(1), point(3)), shape(point(1), point(2), point(3)));
        // Ties go to the diagonal through the patch's lowest corner, whichever way the polygon starts.
        const LocalNode lowest = *std::min_element(
            polygon.begin(), polygon.end(),
            [&patch](LocalNode a, LocalNode b) { return rank_in(patch, a) < rank_in(patch, b); });
        const bool through_first =
            first != second ? first > second : (lowest == polygon[0] || lowest == polygon[2]);
        if (through_first) {
            facets.push_back({{polygon[0], polygon[1], polygon[2], polygon[2]}, 3});
            facets.push_back({{polygon[0], polygon[2], polygon[3], polygon[3]}, 3});
        } else {
            facets.push_back({{polygon[0], polygon[1], polygon[3], polygon[3]}, 3});
            facets.push_back({{polygon[1], polygon[2], polygon[3], polygon[3]}, 3});
        }
        return;
    }
    // Three corners between two cuts: a fan from the middle corner.
    for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
        if (i == 2 || i + 1 == 2) continue;
        facets.push_back({{polygon[2], polygon[i], polygon[i + 1], polygon[i + 1]}, 3});
    }
    facets.push_back({{polygon[2], polygon[4], polygon[0], polygon[0]}, 3});
}

void Cell::fan_patch(const std::vector<LocalNode>& loop, const Patch& patch, std::vector<Facet>& facets) {
    const std::size_t n = surfaces_.size();
    fan_nodes_ = loop;
    const std::size_t first = nodes_.size();
    fan_nodes_.push_back(add_node(fan_centre(loop, patch), static_cast<std::uint8_t>(1u << patch.face)));
    if (!patch.quarter) settle_pole(fan_nodes_.back(), patch.face);
    fan_.clear();
    const auto centre = static_cast<std::uint16_t>(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
        fan_.push_back(
            {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>((i + 1) % loop.size()), centre});
    }
    const std::uint8_t* active = patch_active_.data();
    // A leaf beyond that shares an active surface is an NIO leaf.
    if (std::any_of(active, active + n, [](std::uint8_t is) { return is != 0; })) load_patch_tapes(patch);
    order_patch(active);
    bool again = true;
    for (int round = 0; round < kBisectionRounds && again; ++round) {
        again = false;
        for (std::size_t k = 0; k < patch_order_.size(); ++k) {
            again = split_patch(patch, k, round) || again;
            again = insert_crossings(patch, k) || again;
        }
    }
    for (const auto& t : fan_) {
        const LocalNode c = fan_nodes_[t[2]];
        facets.push_back({{fan_nodes_[t[0]], fan_nodes_[t[1]], c, c}, 3});
    }
    if (snaps(patch)) settle_targets(first, active);
    if (!has_stand_in() || active[n - 1] != 0) return;
    for (std::size_t i = first; i < nodes_.size(); ++i) {
        const auto node = static_cast<LocalNode>(i);
        crowded_ ? sync_solid(node) : sync_joint(node);
    }
}

bool Cell::is_flat(LocalNode a, LocalNode b, LocalNode c) const {
    const LatticePoint& p = nodes_[a].point;
    const LatticePoint& q = nodes_[b].point;
    const LatticePoint& r = nodes_[c].point;
    const double longest = std::max({distance(p, q), distance(q, r), distance(r, p)});
    return twice_area(p, q, r) < longest * std::max(kMinHeight * scale_.step, kMinRelativeArea * longest);
}

/// The face's active surfaces in the order in which they cut it: as cutting_order(), by the tapes of both
/// cells.
void Cell::order_patch(const std::uint8_t* active) {
    const std::size_t n = surfaces_.size();
    std::vector<std::uint8_t> other_active(other_surfaces_.size(), 0);
    std::vector<std::size_t> settled(n, 0);
    patch_order_.clear();
    for (std::size_t i = 0; i < other_surfaces_.size(); ++i) {
        other_active[i] = other_to_own_[i] < n ? active[other_to_own_[i]] : std::uint8_t{0};
    }
    for (std::size_t s = 0; s < n; ++s) {
        if (active[s] == 0) continue;
        patch_order_.push_back(s);
        settled[s] += patch_tape_->settled_by(s, active);
    }
    for (std::size_t i = 0; i < other_surfaces_.size() && patch_order_.size() > 1; ++i) {
        if (other_active[i] != 0) settled[other_to_own_[i]] += other_tape_.settled_by(i, other_active.data());
    }
    std::stable_sort(patch_order_.begin(), patch_order_.end(),
                     [&settled](std::size_t a, std::size_t b) { return settled[a] > settled[b]; });
}

/// The certain signs of a triangle or an edge for the face's active surfaces, in the order of both cells'
/// tapes.
void Cell::load_certain_signs(const std::uint16_t* corners, std::size_t count, const std::uint8_t* active) {
    load_signs(active, [&](std::size_t s) {
        Sides all;
        for (std::size_t i = 0; i < count; ++i) all.add(sign(fan_nodes_[corners[i]], s));
        return all.sign();
    });
}

/// Whether these signs tell the region, by the tape of either cell: both cells ask both tapes, so
/// they agree.
bool Cell::is_resolved() const {
    return patch_tape_->resolve(certain_signs_.data()) != kUnknown ||
           other_tape_.resolve(other_signs_.data()) != kUnknown;
}

/// Whether a surface changes the region for what these signs leave open, by the tape of either
/// cell.
bool Cell::matters(std::size_t surface) const {
    if (patch_tape_->depends_on(surface, certain_signs_.data())) return true;
    const auto other = std::find(other_to_own_.begin(), other_to_own_.end(), surface);
    return other != other_to_own_.end() &&
           other_tape_.depends_on(static_cast<std::size_t>(other - other_to_own_.begin()),
                                  other_signs_.data());
}

/// Whether an edge lies on two surfaces, so that a crease of the solid may lie in the face, and surface p
/// ends it. Triangles on both sides of it may be outside all the same: the edge of a wedge.
bool Cell::ends_crease(std::size_t p, const std::array<std::uint16_t, 2>& edge, const std::uint8_t* active) {
    int through = 0;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        if (active[s] != 0 && sign(fan_nodes_[edge[0]], s) == 0 && sign(fan_nodes_[edge[1]], s) == 0)
            ++through;
    }
    if (through < 2) return false;
    load_certain_signs(edge.data(), 2, active);
    return matters(p);
}

/// Fills mixed_ with the face's mixed inner edges that surface p has to cut. Only what matters is split: it
/// makes fewer triangles, and beside an edge of the cell where several surfaces are not active, the splits
/// would not end.
void Cell::list_mixed_edges(const Patch& patch, std::size_t p) {
    const std::uint8_t* active = patch_active_.data();
    mixed_.clear();
    for (const auto& t : fan_) {
        const std::size_t before = mixed_.size();
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint16_t a = std::min(t[i], t[(i + 1) % 3]);
            const std::uint16_t b = std::max(t[i], t[(i + 1) % 3]);
            if (is_inner(patch, fan_nodes_[a], fan_nodes_[b]) &&
                sign(fan_nodes_[a], p) * sign(fan_nodes_[b], p) < 0)
                mixed_.push_back({a, b});
        }
        if (mixed_.size() == before) continue;
        load_certain_signs(t.data(), 3, active);
        if (!is_resolved() && matters(p)) continue;
        const auto first = mixed_.begin() + static_cast<std::ptrdiff_t>(before);
        mixed_.erase(std::remove_if(first, mixed_.end(),
                                    [&](const auto& edge) {
                                        return !ends_crease(p, {edge.first, edge.second}, active);
                                    }),
                     mixed_.end());
    }
    sort_unique(mixed_);
}

/// Whether a node on an edge of the fan makes one of the triangles there flat.
bool Cell::splits_flat(std::uint16_t a, std::uint16_t b, LocalNode middle) const {
    for (const auto& t : fan_) {
        const std::size_t i = side_of(t, a, b);
        if (i == 3) continue;
        const LocalNode u = fan_nodes_[t[i]], v = fan_nodes_[t[(i + 1) % 3]], w = fan_nodes_[t[(i + 2) % 3]];
        if (is_flat(u, middle, w) || is_flat(middle, v, w)) return true;
    }
    return false;
}

/// Divides the triangles at an edge of the fan by the fan's last node.
void Cell::split_fan(std::uint16_t a, std::uint16_t b) {
    const auto middle = static_cast<std::uint16_t>(fan_nodes_.size() - 1);
    const std::size_t count = fan_.size();
    for (std::size_t t = 0; t < count; ++t) {
        const std::size_t i = side_of(fan_[t], a, b);
        if (i == 3) continue;
        const std::uint16_t u = fan_[t][i], v = fan_[t][(i + 1) % 3], w = fan_[t][(i + 2) % 3];
        fan_[t] = {u, middle, w};
        fan_.push_back({middle, v, w});
    }
}

/// Splits the face's mixed inner edges for surface p; tells whether there were any.
bool Cell::split_patch(const Patch& patch, std::size_t k, int round) {
    keep_watch();
    bool any = false;
    const std::size_t p = patch_order_[k];
    // Of the face, not of the cell: both sides must stop at the same triangle.
    const std::size_t on_face = patch_order_.size();
    list_mixed_edges(patch, p);
    for (const auto& [a, b] : mixed_) {
        const LocalNode na = fan_nodes_[a];
        const LocalNode nb = fan_nodes_[b];
        if (sign(na, p) * sign(nb, p) >= 0) continue;  // an end was snapped
        if (fan_.size() >= std::max(kFewestTriangles, kMostFaceWork / on_face)) {
            ++counters.limited;
            return false;
        }
        LatticePoint at = root(p, nodes_[na].point, nodes_[nb].point);
        if (snap_end(p, na, nb, at, kMergeDistance, true)) {
            any = true;
            continue;
        }
        at = on_shared_curve(patch, k, {a, b}, at, round);
        const LocalNode m = split_node(patch_order_, k, na, nb, at, round, patch_active_.data());
        if (splits_flat(a, b, m)) {
            remove_last_node();
            if (!snap_end(p, na, nb, at, kSnapDistance, true)) ++counters.refused;
            continue;
        }
        fan_nodes_.push_back(m);
        split_fan(a, b);
        any = true;
    }
    return any;
}

}  // namespace mortise::cnio
