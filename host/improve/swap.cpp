#include <algorithm>

#include "host/improve/block.hpp"

namespace mortise::improve {

/// Finds the triangulation of a polygon, counter-clockwise seen from b, whose worst tetrahedron with a or b
/// is as good as can be (Klincsek's dynamic programming); middle[i][j] is the third node of the triangle over
/// the diagonal from i to j. False if none is above `needed`.
bool Block::triangulate(const std::vector<Local>& polygon, Local a, Local b, double needed,
                        PolygonMiddles& middle) {
    const std::size_t n = polygon.size();
    double best[kLongestPolygon][kLongestPolygon];
    // Quality of the two tetrahedra over a triangle, or one not above `enough`.
    const auto quality_over = [&](std::size_t i, std::size_t k, std::size_t j, double enough) {
        const double value = quality({polygon[i], polygon[k], polygon[j], b});
        if (!(value > enough)) return value;
        return std::min(value, quality({polygon[k], polygon[i], polygon[j], a}));
    };
    // One triangle has the edge from the last node to the first: mostly none is good enough, and that is all.
    double closing[kLongestPolygon];
    bool any_closes = false;
    for (std::size_t k = 1; k + 1 < n; ++k) {
        closing[k] = quality_over(0, k, n - 1, needed);
        any_closes = any_closes || closing[k] > needed;
    }
    if (!any_closes) return false;
    for (std::size_t i = 0; i + 1 < n; ++i) best[i][i + 1] = 2;
    for (std::size_t span = 2; span < n; ++span) {
        for (std::size_t i = 0; i + span < n; ++i) {
            const std::size_t j = i + span;
            best[i][j] = needed;
            for (std::size_t k = i + 1; k < j; ++k) {
                const double bound = std::min(best[i][k], best[k][j]);
                if (!(bound > best[i][j])) continue;
                const double over = span + 1 == n ? closing[k] : quality_over(i, k, j, best[i][j]);
                const double value = std::min(bound, over);
                if (!(value > best[i][j])) continue;
                best[i][j] = value;
                middle[i][j] = k;
            }
            if (span + 1 == n && !(best[i][j] > needed)) return false;
        }
    }
    return true;
}

/// Appends the two tetrahedra over each triangle of a polygon.
void Block::add_over_triangles(const std::vector<Local>& polygon, const PolygonMiddles& middle, Local a,
                               Local b, std::uint16_t region, Change& change) {
    std::size_t open[kLongestPolygon][2];
    std::size_t count = 0;
    open[count][0] = 0;
    open[count++][1] = polygon.size() - 1;
    while (count > 0) {
        --count;
        const std::size_t i = open[count][0];
        const std::size_t j = open[count][1];
        if (j - i < 2) continue;
        const std::size_t k = middle[i][j];
        for (int side = 0; side < 2; ++side) {
            Tetrahedron t;
            t.node = side == 0 ? std::array<Local, 4>{polygon[i], polygon[k], polygon[j], b}
                               : std::array<Local, 4>{polygon[k], polygon[i], polygon[j], a};
            t.region = region;
            t.kind = static_cast<std::uint8_t>(ElementKind::kCnio);
            t.quality = quality(t.node);
            change.after = std::min(change.after, t.quality);
            change.added.push_back(t);
        }
        open[count][0] = i;
        open[count++][1] = k;
        open[count][0] = k;
        open[count++][1] = j;
    }
}

/// Whether none of the polygon's diagonals that tetrahedra from `first` on have is an edge already.
bool Block::diagonals_are_new(const std::vector<Local>& polygon, const Change& change,
                              std::size_t first) const {
    for (std::size_t c = first; c < change.added.size(); ++c) {
        const auto& node = change.added[c].node;
        for (std::size_t k = 0; k < 3; ++k) {
            const Local x = node[k];
            const Local y = node[(k + 1) % 3];
            for (const std::uint32_t i : star_[x]) {
                const auto& other = tetrahedra_[i].node;
                if (std::find(other.begin(), other.end(), y) == other.end()) continue;
                const bool goes =
                    std::find(change.removed.begin(), change.removed.end(), i) != change.removed.end();
                const auto ix = std::find(polygon.begin(), polygon.end(), x) - polygon.begin();
                const auto iy = std::find(polygon.begin(), polygon.end(), y) - polygon.begin();
                const auto apart = static_cast<std::size_t>(ix > iy ? ix - iy : iy - ix);
                if (!goes && apart != 1 && apart + 1 != polygon.size()) return false;
            }
        }
    }
    return true;
}

/// Triangulates the polygon, counter-clockwise seen from b, and joins it to a and b. False if that is not
/// good enough, or would make an edge twice.
bool Block::fill_polygon(const std::vector<Local>& polygon, Local a, Local b, std::uint16_t region,
                         Change& change) {
    const std::size_t n = polygon.size();
    if (n < 3 || n > kLongestPolygon) return n == 2;
    PolygonMiddles middle = {};
    if (!triangulate(polygon, a, b, change.needed, middle)) return false;
    const std::size_t first_added = change.added.size();
    add_over_triangles(polygon, middle, a, b, region, change);
    return diagonals_are_new(polygon, change, first_added);
}

/// Enters the ring's tetrahedra as removed, their outer facets as entries_, and where the tagged faces at the
/// edge are. False if these are not of one surface, more than two, or at the block's border.
bool Block::read_ring(Local a, Local b, Change& change, RingCuts& cuts) {
    const std::size_t count = ring_.tetrahedra.size();
    const std::size_t nodes = ring_.nodes.size();
    const auto note = [&](FaceTag tag, std::size_t at) {
        if (cuts.count == 2 || (tag & kTagBorder) != 0) return false;
        if (cuts.count == 1 && tag_surface(tag) != cuts.surface) return false;
        cuts.surface = tag_surface(tag);
        cuts.on_interface = cuts.on_interface || (tag & kTagInterface) != 0;
        cuts.at[cuts.count++] = at;
        return true;
    };
    for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t i = ring_.tetrahedra[k];
        const Tetrahedron& t = tetrahedra_[i];
        change.removed.push_back(i);
        change.before = std::min(change.before, t.quality);
        const Local c = ring_.nodes[k];
        const Local d = ring_.nodes[(k + 1) % nodes];
        const FaceTag first = tag_of(i, a, b, c);
        const FaceTag last = tag_of(i, a, b, d);
        if (first != 0 && !note(first, k)) return false;
        if (last != 0 && !ring_.closed && k + 1 == count && !note(last, k + 1)) return false;
        for (const Local apex : {a, b}) {
            const FaceTag tag = tag_of(i, apex, c, d);
            if (tag != 0) entries_.push_back({sorted_face({apex, c, d}), t.region, tag});
        }
    }
    return true;
}

/// Whether no facet has the edge pq, and no tetrahedron but those that go, unless the edge is there already
/// since a single tetrahedron between two facets goes.
bool Block::is_new_on_surface(Local p, Local q, bool peels, const Change& change) const {
    for (const std::uint32_t i : star_[free_[p] != 0 ? p : q]) {
        const Tetrahedron& t = tetrahedra_[i];
        const auto ip = static_cast<std::size_t>(std::find(t.node.begin(), t.node.end(), p) - t.node.begin());
        const auto iq = static_cast<std::size_t>(std::find(t.node.begin(), t.node.end(), q) - t.node.begin());
        if (ip == 4 || iq == 4) continue;
        const bool goes = std::find(change.removed.begin(), change.removed.end(), i) != change.removed.end();
        if (!peels && !goes) return false;
        for (std::size_t f = 0; f < 4; ++f) {
            if (f != ip && f != iq && t.tag[f] != 0) return false;
        }
    }
    return true;
}

/// Whether the facets apq and bpq lie as well on the surface as abp and abq do.
bool Block::flip_fits(std::uint32_t surface, Local a, Local b, Local p, Local q) const {
    const auto on = [&](Local n) {
        return std::find(strata_[n].begin(), strata_[n].end(), surface) != strata_[n].end();
    };
    if (!on(p) || !on(q) || !on(a) || !on(b)) return false;
    const Fit old_first = fit(surface, points_[a], points_[b], points_[p]);
    const Fit old_last = fit(surface, points_[b], points_[a], points_[q]);
    const double sign = old_first.alignment < 0 ? -1 : 1;
    const double limit =
        std::min(kLeastAlignment, std::min(sign * old_first.alignment, sign * old_last.alignment));
    const double most_sag = std::max({most_sag_ * std::min(size_[a], size_[b]), old_first.sag, old_last.sag});
    const auto fits = [&](const Fit& f) { return sign * f.alignment >= limit && f.sag <= most_sag; };
    return fits(fit(surface, points_[a], points_[q], points_[p])) &&
           fits(fit(surface, points_[b], points_[p], points_[q]));
}

/// A single tetrahedron abpq with both facets at ab goes: its other faces become facets of what is beyond.
bool Block::peel(std::uint32_t tetrahedron, Local a, Local b, Local p, Local q, FaceTag tag,
                 Change& change) const {
    for (const Local apex : {a, b}) {
        if (tag_of(tetrahedron, apex, p, q) != 0) return false;
        const Local away = apex == a ? b : a;
        const auto& n = tetrahedra_[tetrahedron].node;
        const auto f = static_cast<std::size_t>(std::find(n.begin(), n.end(), away) - n.begin());
        const std::uint32_t other = across(tetrahedron, f);
        if (other == kNone) return false;
        for (std::uint32_t k = 0; k < 4; ++k) {
            const Local m = tetrahedra_[other].node[k];
            if (m != apex && m != p && m != q) change.retagged.push_back({other, k, tag});
        }
    }
    return true;
}

bool Block::examine_edge_removal(Local a, Local b, double better_than, Change& change) {
    if (!gather_ring(a, b, kLongestPolygon - 1, ring_)) return false;
    const std::size_t count = ring_.tetrahedra.size();
    const std::size_t nodes = ring_.nodes.size();
    change.clear();
    entries_.clear();
    RingCuts cuts;
    if (!read_ring(a, b, change, cuts)) return false;
    change.needed = std::max(std::max(change.before * least_gain_, kLowestQuality), better_than);
    if (ring_.closed && cuts.count == 0) {
        if (nodes < 3) return false;
        if (!fill_polygon(ring_.nodes, a, b, tetrahedra_[ring_.tetrahedra[0]].region, change)) return false;
        tag_added(change, entries_);
        return true;
    }
    if (cuts.count != 2 || !options_.change_boundary) return false;
    // An open ring must end at the outer boundary on both sides: at an interface, the rest of the ring
    // belongs to another block.
    if (!ring_.closed && (cuts.at[0] != 0 || cuts.at[1] != count || cuts.on_interface)) return false;
    const Local p = ring_.nodes[cuts.at[0]];
    const Local q = ring_.nodes[cuts.at[1] % nodes];
    if (free_[p] == 0 && free_[q] == 0) return false;
    const std::size_t between = cuts.at[1] - cuts.at[0];
    const bool peels = std::min(between, count - between) == 1 || count == 1;
    if (!is_new_on_surface(p, q, peels, change) || !flip_fits(cuts.surface, a, b, p, q)) return false;
    std::vector<Local> fan;
    for (int side = 0; side < (ring_.closed ? 2 : 1); ++side) {
        const std::size_t begin = cuts.at[side];
        const std::size_t end = side == 0 ? cuts.at[1] : cuts.at[0] + count;
        fan.clear();
        for (std::size_t k = begin; k <= end; ++k) fan.push_back(ring_.nodes[k % nodes]);
        const std::uint32_t first = ring_.tetrahedra[begin % count];
        const FaceTag tag = tag_of(first, a, b, p == fan.front() ? p : q);
        if (fan.size() == 2) {
            if (!peel(first, a, b, p, q, tag, change)) return false;
            continue;
        }
        const std::uint16_t region = tetrahedra_[first].region;
        entries_.push_back({sorted_face({a, p, q}), region, tag});
        entries_.push_back({sorted_face({b, p, q}), region, tag});
        if (!fill_polygon(fan, a, b, region, change)) return false;
    }
    tag_added(change, entries_);
    if (!is_plane(cuts.surface) && swells(change)) return false;
    return !crosses(change);
}

bool Block::examine_face_removal(std::uint32_t tetrahedron, std::size_t face, double better_than,
                                 Change& change) {
    const Tetrahedron& t = tetrahedra_[tetrahedron];
    if (t.tag[face] != 0) return false;
    const std::uint32_t other = across(tetrahedron, face);
    if (other == kNone) return false;
    const Tetrahedron& u = tetrahedra_[other];
    change.clear();
    entries_.clear();
    change.removed = {tetrahedron, other};
    change.before = std::min(t.quality, u.quality);
    change.needed = std::max(std::max(change.before * least_gain_, kLowestQuality), better_than);
    // Counter-clockwise seen from t's node: against the outward order.
    const Local x[3] = {t.node[kOpposite[face][0]], t.node[kOpposite[face][2]], t.node[kOpposite[face][1]]};
    const Local top = t.node[face];
    Local bottom = kNone;
    for (std::size_t f = 0; f < 4; ++f) {
        if (u.node[f] != x[0] && u.node[f] != x[1] && u.node[f] != x[2]) bottom = u.node[f];
    }
    for (const std::uint32_t i : star_[top]) {
        const auto& n = tetrahedra_[i].node;
        if (std::find(n.begin(), n.end(), bottom) != n.end()) return false;  // the edge exists already
    }
    for (std::size_t k = 0; k < 3; ++k) {
        Tetrahedron made;
        made.node = {bottom, top, x[k], x[(k + 1) % 3]};
        made.region = t.region;
        made.kind = t.kind;
        made.quality = quality(made.node);
        if (!(made.quality > change.needed)) return false;
        change.after = std::min(change.after, made.quality);
        change.added.push_back(made);
        for (const Local apex : {top, bottom}) {
            const std::uint32_t source = apex == top ? tetrahedron : other;
            const FaceTag tag = tag_of(source, apex, x[k], x[(k + 1) % 3]);
            if (tag != 0) entries_.push_back({sorted_face({apex, x[k], x[(k + 1) % 3]}), t.region, tag});
        }
    }
    tag_added(change, entries_);
    return true;
}

}  // namespace mortise::improve
