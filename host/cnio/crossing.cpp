// Points of a face where three surfaces meet, out of reach of the fan's own edges: the first of the surfaces
// leaves the face through an edge of the cell where it is not active, so no node of that edge ends its cut.
// Without the point, the surfaces it parts (a cylinder and the sphere that caps it) both cut the triangles
// there, and the film between them stays.
#include <algorithm>

#include "host/cnio/cell.hpp"

namespace mortise::cnio {
namespace {

constexpr double kInside = 1e-9;  ///< of a triangle's area: what its parts may be larger

}  // namespace

/// In place of the point where surface p cuts an edge that is a chord of several others: where it cuts the
/// first of these. In a face where two solids meet, their sections are one curve, and on its chord the node
/// would be on the one that has been cut, and beside the other.
LatticePoint Cell::on_shared_curve(const Patch& patch, std::size_t k,
                                   const std::array<std::uint16_t, 2>& edge, const LatticePoint& at,
                                   int round) {
    const LocalNode a = fan_nodes_[edge[0]];
    const LocalNode b = fan_nodes_[edge[1]];
    const std::size_t done = round == 0 ? k : patch_order_.size();
    std::size_t first = surfaces_.size();
    int through = 0;
    for (std::size_t i = 0; i < patch_order_.size(); ++i) {
        const std::size_t s = patch_order_[i];
        if (sign(a, s) != 0 || sign(b, s) != 0) continue;
        const bool holds_face = std::all_of(patch.corner.begin(), patch.corner.end(),
                                            [&](LocalNode corner) { return sign(corner, s) == 0; });
        if (holds_face) continue;
        ++through;
        if (i < done && first == surfaces_.size()) first = s;
    }
    LatticePoint settled;
    if (through < 2 || first == surfaces_.size()) return at;
    if (!apex_on({at, patch.face / 2, patch.scale}, {patch_order_[k], first}, settled)) return at;
    double whole = 0;
    double parts = 0;
    for (const auto& t : fan_) {
        const std::size_t i = side_of(t, edge[0], edge[1]);
        if (i == 3) continue;
        const LatticePoint &u = nodes_[fan_nodes_[t[i]]].point, &v = nodes_[fan_nodes_[t[(i + 1) % 3]]].point;
        const LatticePoint& tip = nodes_[fan_nodes_[t[(i + 2) % 3]]].point;
        whole += twice_area(u, v, tip);
        parts += twice_area(u, settled, tip) + twice_area(settled, v, tip);
    }
    return parts <= (1 + kInside) * whole ? settled : at;
}

/// Puts such points into triangles one of whose corners is on surface p.
bool Cell::insert_crossings(const Patch& patch, std::size_t k) {
    const std::size_t p = patch_order_[k];
    bool any = false;
    const std::size_t count = fan_.size();
    for (std::size_t t = 0; t < count; ++t) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::array<std::uint16_t, 3> turned = {fan_[t][i], fan_[t][(i + 1) % 3],
                                                         fan_[t][(i + 2) % 3]};
            const LocalNode u = fan_nodes_[turned[0]];
            const LocalNode v = fan_nodes_[turned[1]];
            if (sign(u, p) * sign(v, p) >= 0 || sign(fan_nodes_[turned[2]], p) != 0) continue;
            if (is_inner(patch, u, v)) continue;
            if (!insert_crossing(patch, p, turned)) continue;
            const auto local = static_cast<std::uint16_t>(fan_nodes_.size() - 1);
            fan_[t] = {turned[0], turned[1], local};
            fan_.push_back({turned[1], turned[2], local});
            fan_.push_back({turned[2], turned[0], local});
            any = true;
            break;
        }
    }
    return any;
}

/// Adds the point of one triangle, on p between its third corner and the opposite edge, where p first meets
/// another surface, and a third one: two by themselves leave no film, and the point would be as close to the
/// border as they happen to be.
bool Cell::insert_crossing(const Patch& patch, std::size_t p, const std::array<std::uint16_t, 3>& corner) {
    const std::uint8_t* active = patch_active_.data();
    load_certain_signs(corner.data(), 3, active);
    if (is_resolved() || !matters(p)) return false;
    const std::vector<std::int8_t> certain = certain_signs_;
    const LocalNode u = fan_nodes_[std::min(corner[0], corner[1])];
    const LocalNode v = fan_nodes_[std::max(corner[0], corner[1])];
    const LocalNode w = fan_nodes_[corner[2]];
    const LatticePoint end = root(p, nodes_[u].point, nodes_[v].point);
    LatticePoint at{};
    std::size_t other = surfaces_.size();
    double nearest = distance(nodes_[w].point, end);
    for (const std::size_t q : patch_order_) {
        if (q == p || sign(w, q) * pure_sign(q, end, patch.scale.size) >= 0) continue;
        const LatticePoint candidate = root(q, nodes_[w].point, end);
        const double from = distance(nodes_[w].point, candidate);
        if (from >= nearest || !matters_at(patch, q, candidate)) continue;
        nearest = from;
        at = candidate;
        other = q;
    }
    if (other == surfaces_.size()) return false;
    if (LatticePoint settled; apex_on({at, patch.face / 2, patch.scale}, {p, other}, settled)) at = settled;
    if (!meets_third(patch, p, other, at)) return false;
    const double whole = twice_area(nodes_[u].point, nodes_[v].point, nodes_[w].point);
    const double parts = twice_area(nodes_[u].point, nodes_[v].point, at) +
                         twice_area(nodes_[v].point, nodes_[w].point, at) +
                         twice_area(nodes_[w].point, nodes_[u].point, at);
    if (parts > (1 + kInside) * whole) return false;
    const LocalNode m = add_node(at, static_cast<std::uint8_t>(1u << patch.face));
    if (is_flat(u, v, m) || is_flat(v, w, m) || is_flat(w, u, m)) {
        remove_last_node();
        return false;
    }
    for (const std::size_t s : patch_order_) {
        if (certain[s] != 0) set_sign(m, s, certain[s]);
    }
    set_sign(m, p, 0);
    set_sign(m, other, 0);
    fan_nodes_.push_back(m);
    return true;
}

/// Whether another surface passes through the point of two.
bool Cell::meets_third(const Patch& patch, std::size_t p, std::size_t q, const LatticePoint& at) const {
    return std::any_of(patch_order_.begin(), patch_order_.end(), [&](std::size_t s) {
        return s != p && s != q && pure_sign(s, at, kTogether * patch.scale.size) == 0;
    });
}

/// Whether the region changes at a surface there, on either side of surfaces that are no farther.
bool Cell::matters_at(const Patch& patch, std::size_t surface, const LatticePoint& at) {
    load_signs(patch_active_.data(), [&](std::size_t s) {
        return s == surface ? 0 : pure_sign(s, at, kTogether * patch.scale.size);
    });
    return matters(surface);
}

}  // namespace mortise::cnio
