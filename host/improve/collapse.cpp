#include <algorithm>

#include "host/common/sort_unique.hpp"
#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

// Lengths in cells; a cell at a node is the smallest leaf around it.
constexpr double kLongestEdge = 1.75;  ///< an edge that a collapse makes; longer ones may only shrink
/// The same where nodes are not repositioned: vertices of the grid, at ends of cells' diagonals (1.73), must
/// snap outward. From 2 on facets would grow across vertices just below them.
constexpr double kLongestStillEdge = 1.95;
constexpr double kOffSurface = 2e-5;  ///< nodes that could not be projected are closer than that
constexpr double kTinyFacet = 1e-3;   ///< a facet without a longer edge has no direction to speak of
constexpr double kHopeless = 1e-3;    ///< elements this flat justify that narrow facets fold
/// Tetrahedra at a node; more, around a needle of the model, would take more time than they are worth.
constexpr std::size_t kLargestStar = 512;
constexpr double kEqual = 0.999999;
constexpr double kChordError = 0.1;  ///< distance of a new crease edge's middle to its surfaces, per length

}  // namespace

/// Edges of the mesh at a node where facets of different surfaces meet: two along a crease, more at a corner.
std::size_t Block::count_feature_edges(Local node) {
    spokes_.clear();
    for (const std::uint32_t i : star_[node]) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || t.node[f] == node) continue;
            for (const std::uint8_t k : kOpposite[f]) {
                if (t.node[k] != node) spokes_.push_back({t.node[k], tag_surface(t.tag[f])});
            }
        }
    }
    sort_unique(spokes_);
    std::size_t count = 0;
    for (std::size_t i = 0; i < spokes_.size();) {
        std::size_t end = i + 1;
        while (end < spokes_.size() && spokes_[end].first == spokes_[i].first) ++end;
        count += end - i > 1 ? 1 : 0;
        i = end;
    }
    return count;
}

/// Whether a node may be merged with a neighbour: the star of `gone` is one piece with manifold boundary, and
/// whatever touches both ends touches their edge (Dey, Edelsbrunner, Guha, Nekhayev 1999). Positive
/// tetrahedra are not enough: where features are finer than the mesh shows them, sheets of the boundary may
/// cross.
bool Block::links_allow(Local gone, Local kept) {
    using Seen = LinkNode;
    std::vector<LinkNode>& seen = link_;
    seen.clear();
    // seen_at_[n]: 1 + place of node n in `seen`, 0 for all others; left so.
    const auto find = [&](Local n) -> Seen& {
        if (seen_at_[n] == 0) {
            seen.push_back({n, 0, false, false, false});
            seen_at_[n] = static_cast<std::uint32_t>(seen.size());
        }
        return seen[seen_at_[n] - 1];
    };
    std::size_t outer = 0;
    for (const std::uint32_t i : star_[gone]) {
        const Tetrahedron& t = tetrahedra_[i];
        const bool at_edge = has(t.node, kept);
        for (std::size_t f = 0; f < 4; ++f) {
            const Local n = t.node[f];
            if (n == gone) continue;
            Seen& s = find(n);
            s.at_edge = s.at_edge || at_edge;
            if (t.tag[f] == 0) continue;
            // The facet opposite n holds `gone`.
            const bool is_outer = (t.tag[f] & kTagInterface) == 0;
            outer += is_outer ? 1 : 0;
            for (const std::uint8_t k : kOpposite[f]) {
                const Local m = t.node[k];
                if (m == gone) continue;
                Seen& other = find(m);
                other.outer += is_outer ? 1 : 0;
                other.facet = true;
                if (at_edge && n != kept) other.facet_at_edge = true;
            }
        }
    }
    // Where two sheets touch along this very edge, the collapse may part them: then what counts is the
    // result.
    const bool is_pinched = find(kept).outer == 4;
    const bool allowed = (is_pinched || is_link_whole(outer, gone)) && is_link_shared(gone, kept) &&
                         !sheets_would_meet(kept) &&
                         (!is_pinched || (free_[kept] != 0 && is_joined_link_whole(gone, kept)));
    for (const Seen& s : seen) seen_at_[s.node] = 0;
    return allowed;
}

/// Whether the node that a collapse leaves would have a sphere or a disk with manifold boundary for its link.
bool Block::is_joined_link_whole(Local gone, Local kept) const {
    std::vector<Local> nodes;
    std::vector<Local> rim;  // every node once for each outer facet at the edge to it
    std::size_t tetrahedra = 0;
    std::size_t outer = 0;
    const auto add_facet = [&](FaceTag tag, const Tetrahedron& t, std::size_t face) {
        if (tag == 0 || (tag & kTagInterface) != 0) return;
        ++outer;
        for (const std::uint8_t k : kOpposite[face]) {
            if (t.node[k] != gone && t.node[k] != kept) rim.push_back(t.node[k]);
        }
    };
    for (const Local end : {gone, kept}) {
        for (const std::uint32_t i : star_[end]) {
            const Tetrahedron& t = tetrahedra_[i];
            const bool vanishes = has(t.node, gone) && has(t.node, kept);
            if (vanishes && end == kept) continue;
            tetrahedra += vanishes ? 0 : 1;
            for (std::size_t f = 0; f < 4; ++f) {
                const bool is_end = t.node[f] == gone || t.node[f] == kept;
                if (!vanishes && !is_end) nodes.push_back(t.node[f]);
                // Of an element that vanishes, the facets opposite the ends pass to its neighbours.
                if (vanishes == is_end) add_facet(t.tag[f], t, f);
            }
        }
    }
    sort_unique(nodes);
    std::sort(rim.begin(), rim.end());
    for (std::size_t i = 0; i < rim.size(); i += 2) {
        if (i + 1 == rim.size() || rim[i] != rim[i + 1] || (i + 2 < rim.size() && rim[i + 2] == rim[i]))
            return false;
    }
    return nodes.size() + tetrahedra == (3 * tetrahedra + outer) / 2 + (outer == 0 ? 2u : 1u);
}

bool Block::is_link_whole(std::size_t outer, Local gone) const {
    for (const LinkNode& s : link_) {
        if (s.outer != 0 && s.outer != 2) return false;
    }
    // Euler characteristic of the link: a sphere, or a disk on the outer boundary.
    const std::size_t tetrahedra = star_[gone].size();
    const std::size_t edges = (3 * tetrahedra + outer) / 2;
    return link_.size() + tetrahedra == edges + (outer == 0 ? 2u : 1u);
}

/// Whether sheets of facets at both ends of an edge would meet: at a node that has facets at both, but none
/// at the edge. Facets of elements that vanish pass to their neighbours, so they count, too.
bool Block::sheets_would_meet(Local kept) const {
    return std::any_of(star_[kept].begin(), star_[kept].end(), [&](std::uint32_t i) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || t.node[f] == kept) continue;
            for (const std::uint8_t k : kOpposite[f]) {
                const std::uint32_t place = t.node[k] == kept ? 0 : seen_at_[t.node[k]];
                if (place != 0 && link_[place - 1].facet && !link_[place - 1].facet_at_edge) return true;
            }
        }
        return false;
    });
}

bool Block::is_link_shared(Local gone, Local kept) const {
    const auto in_link = [&](Local n) { return seen_at_[n] == 0 ? nullptr : &link_[seen_at_[n] - 1]; };
    // Whether a tetrahedron holds both ends and both nodes.
    const auto shares = [&](Local n, Local m) {
        return std::any_of(star_[gone].begin(), star_[gone].end(), [&](std::uint32_t i) {
            const auto& node = tetrahedra_[i].node;
            return has(node, kept) && has(node, n) && has(node, m);
        });
    };
    if (free_[kept] == 0) {
        // Elements of `kept` in other blocks cannot be seen: no edge and no face that they might have either.
        for (const LinkNode& s : link_) {
            if (s.node != kept && !s.at_edge && free_[s.node] == 0) return false;
        }
        for (const std::uint32_t i : star_[gone]) {
            const auto& node = tetrahedra_[i].node;
            if (has(node, kept)) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                for (std::size_t l = k + 1; l < 4; ++l) {
                    if (node[k] == gone || node[l] == gone || free_[node[k]] != 0 || free_[node[l]] != 0)
                        continue;
                    if (!shares(node[k], node[l])) return false;
                }
            }
        }
    }
    for (const std::uint32_t i : star_[kept]) {
        const Tetrahedron& t = tetrahedra_[i];
        if (has(t.node, gone)) continue;
        for (std::size_t f = 0; f < 4; ++f) {
            const Local n = t.node[f];
            if (n == kept) continue;
            const LinkNode* s = in_link(n);
            if (s != nullptr && !s->at_edge) return false;
            // A triangle over the other two nodes that both ends have needs its tetrahedron at the edge.
            Local pair[2] = {kNone, kNone};
            std::size_t count = 0;
            for (const Local m : t.node) {
                if (m != kept && m != n) pair[count++] = m;
            }
            if (in_link(pair[0]) == nullptr || in_link(pair[1]) == nullptr) continue;
            const bool with_gone = std::any_of(star_[gone].begin(), star_[gone].end(), [&](std::uint32_t j) {
                return has(tetrahedra_[j].node, pair[0]) && has(tetrahedra_[j].node, pair[1]);
            });
            if (with_gone && !shares(pair[0], pair[1])) return false;
        }
    }
    return true;
}

/// Whether the facets that a collapse changes lie along their surfaces as well as they did. `any_narrow`:
/// those that are narrow before and after may be turned.
bool Block::facets_stay_aligned(Local gone, Local kept, bool any_narrow) const {
    const std::vector<std::uint32_t>& on = strata_[gone];
    const auto is_tiny = [&](const std::array<Local, 3>& face) {
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            longest = std::max(longest, squared_length(points_[face[k]] - points_[face[(k + 1) % 3]]));
        }
        const double tiny = kTinyFacet * size_[gone];
        return longest < tiny * tiny;
    };
    // First which way the facets of each surface look, then each facet.
    double way[kMostSurfaces] = {};
    double most_sag = most_sag_ * size_[gone];
    for (int pass = 0; pass < 2; ++pass) {
        for (const std::uint32_t i : star_[gone]) {
            const Tetrahedron& t = tetrahedra_[i];
            for (std::size_t f = 0; f < 4; ++f) {
                if (t.tag[f] == 0 || t.node[f] == gone) continue;
                const std::uint32_t surface = tag_surface(t.tag[f]);
                const auto place =
                    static_cast<std::size_t>(std::find(on.begin(), on.end(), surface) - on.begin());
                if (place == on.size()) return false;
                // Both sides of an interface have the facet: take the one that calls it inside.
                if ((t.tag[f] & kTagInside) == 0) continue;
                const auto& o = kOpposite[f];
                std::array<Local, 3> face = {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
                const Point& a = points_[face[0]];
                const Fit before = fit(surface, a, points_[face[1]], points_[face[2]]);
                if (pass == 0) {
                    way[place] +=
                        before.alignment * length(cross(points_[face[1]] - a, points_[face[2]] - a));
                    most_sag = std::max(most_sag, before.sag);
                    continue;
                }
                if (has(t.node, kept) && t.node[f] != kept) continue;  // the facet vanishes
                const bool was_tiny = is_tiny(face);
                const bool may_turn = any_narrow && is_narrow(face);
                for (Local& n : face) n = n == gone ? kept : n;
                if (is_tiny(face) || (may_turn && is_narrow(face))) continue;
                const double sign = way[place] < 0 ? -1 : 1;
                const double limit =
                    was_tiny ? kLeastAlignment : std::min(kLeastAlignment, sign * before.alignment);
                const Fit after = fit(surface, points_[face[0]], points_[face[1]], points_[face[2]]);
                if (!(sign * after.alignment >= limit && after.sag <= most_sag)) return false;
            }
        }
    }
    return true;
}

/// Whether a crease's edge between two nodes, without the node `gone` between them, would stay close to its
/// surfaces: as a chord, or no farther than one of the three.
bool Block::chord_is_close(Local gone, Local a, Local b) const {
    const Point middle = 0.5 * (points_[a] + points_[b]);
    const double limit = std::max(kChordError * length(points_[a] - points_[b]), kOffSurface * size_[gone]);
    const auto distance = [&](std::uint32_t surface, const Point& x) {
        const Surfaces::Sample s = surfaces_->sample(surface, x);
        return s.valid ? std::fabs(s.value) / length(s.gradient) : HUGE_VAL;
    };
    return std::all_of(strata_[gone].begin(), strata_[gone].end(), [&](std::uint32_t surface) {
        const double off = distance(surface, middle);
        if (off <= limit) return true;
        const Local nodes[3] = {gone, a, b};
        return std::any_of(nodes, nodes + 3, [&](Local n) {
            const double d = distance(surface, points_[n]);
            return off <= d && d < HUGE_VAL;
        });
    });
}

/// A tetrahedron with three facets at a node that only it has: it goes, and its fourth face becomes the
/// facet. Either all lie on one surface, or the node lies on a crease: that then runs along the edge
/// opposite, from the one facet on the other surface to the next behind it.
bool Block::examine_ear(Local gone, Change& change) {
    const std::uint32_t ear = star_[gone].front();
    const Tetrahedron& t = tetrahedra_[ear];
    const auto ig = static_cast<std::size_t>(std::find(t.node.begin(), t.node.end(), gone) - t.node.begin());
    const std::size_t at[3] = {(ig + 1) % 4, (ig + 2) % 4, (ig + 3) % 4};
    // The tag that two facets have at least.
    const FaceTag tag = t.tag[at[0]] == t.tag[at[1]] ? t.tag[at[0]] : t.tag[at[2]];
    if (t.tag[ig] != 0 || tag == 0 || (tag & kTagInterface) != 0) return false;
    std::size_t single = 4;
    for (const std::size_t f : at) {
        if (t.tag[f] == tag) continue;
        if (single != 4) return false;
        single = f;
    }
    const std::uint32_t other = across(ear, ig);
    if (other == kNone || !options_.change_boundary) return false;
    bool merges = false;
    if (single != 4 && !ear_leaves_crease(ear, ig, single, merges)) return false;
    const std::uint32_t surface = tag_surface(tag);
    const auto faces_surface = [&](std::size_t f, bool inward) {
        const auto& o = kOpposite[f];
        return alignment(surface, points_[t.node[o[0]]], points_[t.node[o[inward ? 2 : 1]]],
                         points_[t.node[o[inward ? 1 : 2]]]);
    };
    const auto& o = kOpposite[ig];
    if (!is_narrow({t.node[o[0]], t.node[o[1]], t.node[o[2]]})) {
        // The new facet looks the other way than the ear's own face.
        double before = 0;
        for (const std::size_t f : at) {
            if (t.tag[f] == tag && std::fabs(faces_surface(f, false)) > std::fabs(before))
                before = faces_surface(f, false);
        }
        const double sign = before < 0 ? -1 : 1;
        if (!(sign * faces_surface(ig, true) >= std::min(kLeastAlignment, sign * before))) return false;
    }
    change.clear();
    change.collapse = true;
    change.merge = merges;
    change.before = t.quality;
    change.removed.push_back(ear);
    const auto& n = tetrahedra_[other].node;
    for (std::uint32_t f = 0; f < 4; ++f) {
        if (!has(t.node, n[f])) change.retagged.push_back({other, f, tag});
    }
    return !crosses(change);
}

/// Whether a face is so narrow that its direction means nothing.
bool Block::is_narrow(const std::array<Local, 3>& face) const {
    const Point u = points_[face[1]] - points_[face[0]];
    const Point v = points_[face[2]] - points_[face[0]];
    const double longest = std::max({squared_length(u), squared_length(v), squared_length(v - u)});
    const double tiny = kTinyFacet * std::min({size_[face[0]], size_[face[1]], size_[face[2]]});
    return squared_length(cross(u, v)) < tiny * tiny * longest;
}

/// Whether the crease through an ear's node may take the edge of the ear's only facet on one of the two
/// surfaces. `merges`: because that one has been merged away behind the edge.
bool Block::ear_leaves_crease(std::uint32_t ear, std::size_t gone, std::size_t single, bool& merges) const {
    const Tetrahedron& t = tetrahedra_[ear];
    const FaceTag tag = t.tag[single];
    const std::vector<std::uint32_t>& on = strata_[t.node[gone]];
    if (tag == 0 || (tag & kTagInterface) != 0 || on.size() != 2) return false;
    Local ends[2] = {kNone, kNone};
    std::size_t count = 0;
    for (std::size_t f = 0; f < 4; ++f) {
        if (f != gone && f != single) ends[count++] = t.node[f];
    }
    for (const Local end : ends) {
        if (!std::includes(strata_[end].begin(), strata_[end].end(), on.begin(), on.end())) return false;
    }
    const Local seen = free_[ends[0]] != 0 ? ends[0] : ends[1];
    if (free_[seen] == 0 || !chord_is_close(t.node[gone], ends[0], ends[1])) return false;
    // The facet behind the edge: there must be one, of the same surface.
    std::size_t facets = 0;
    bool same = true;
    for (const std::uint32_t i : star_[seen]) {
        const Tetrahedron& u = tetrahedra_[i];
        if (i == ear || !has(u.node, ends[0]) || !has(u.node, ends[1])) continue;
        for (std::size_t f = 0; f < 4; ++f) {
            if (u.tag[f] == 0 || u.node[f] == ends[0] || u.node[f] == ends[1]) continue;
            ++facets;
            same = same && u.tag[f] == tag;
        }
    }
    merges = !same && options_.merge_distance > 0 && t.quality < kMergeBelow;
    return facets == 1 && (same || merges);
}

/// What a collapse removes, adds and tags anew; false if two sheets would meet, or an edge would become too
/// long.
bool Block::list_collapse(Local gone, Local kept, const CachedViews& seen, Change& change) {
    const double longest = (options_.reposition ? kLongestEdge : kLongestStillEdge) * size_[gone];
    const double most_squared = std::max(longest * longest, seen.squared_reach);
    change.removed = star_[gone];
    for (std::size_t s = 0; s < star_[gone].size(); ++s) {
        const std::uint32_t i = star_[gone][s];
        const Tetrahedron& t = tetrahedra_[i];
        const auto ig =
            static_cast<std::size_t>(std::find(t.node.begin(), t.node.end(), gone) - t.node.begin());
        if (!has(t.node, kept)) {
            Tetrahedron moved = t;
            moved.node[ig] = kept;
            moved.quality = seen.views.quality(s);
            for (const Local n : t.node) {
                if (n != gone && squared_length(points_[n] - points_[kept]) > most_squared) return false;
            }
            change.added.push_back(moved);
            continue;
        }
        const auto ik =
            static_cast<std::size_t>(std::find(t.node.begin(), t.node.end(), kept) - t.node.begin());
        const FaceTag opposite_gone = t.tag[ig];
        const FaceTag opposite_kept = t.tag[ik];
        if (opposite_gone != 0 && opposite_kept != 0) return false;  // two sheets would meet
        if (opposite_gone != 0) {
            std::array<Local, 3> face = {t.node[kOpposite[ig][0]], t.node[kOpposite[ig][1]],
                                         t.node[kOpposite[ig][2]]};
            std::sort(face.begin(), face.end());
            entries_.push_back({face, t.region, opposite_gone});
        }
        if (opposite_kept != 0) {
            const std::uint32_t other = across(i, ig);
            if (other == kNone) return false;
            const auto& n = tetrahedra_[other].node;
            for (std::uint32_t f = 0; f < 4; ++f) {
                if (!has(t.node, n[f])) change.retagged.push_back({other, f, opposite_kept});
            }
        }
    }
    return !change.added.empty();
}

/// The crease's next node on the other side: whether its new edge stays close to both surfaces.
bool Block::crease_stays_close(Local gone, Local kept) const {
    for (const std::uint32_t i : star_[gone]) {
        for (const Local n : tetrahedra_[i].node) {
            if (n == gone || n == kept || strata_[n].size() < 2 || !edge_is_on_stratum(gone, n)) continue;
            if (!chord_is_close(gone, n, kept)) return false;
        }
    }
    return true;
}

bool Block::examine_collapse(Local gone, Local kept, bool good_will_do, double better_than, Change& change) {
    if (free_[gone] == 0 || joined_[gone] != 0 || tip_[gone] != 0) return false;
    if (!options_.change_boundary && !strata_[gone].empty()) return false;
    if (star_[gone].size() > kLargestStar || star_[kept].size() > kLargestStar) return false;
    if (star_[gone].size() == 1) return examine_ear(gone, change);
    const bool merges = !edge_is_on_stratum(gone, kept);
    if (merges && !may_merge(gone, kept)) return false;
    change.clear();
    change.collapse = true;
    change.merge = merges;
    change.gone = gone;
    change.kept = kept;
    entries_.clear();
    const bool on_surface = !strata_[gone].empty();
    CachedViews& seen = views(gone);
    change.before = seen.worst;
    // A short edge may go if nothing gets worse: the mesh gets simpler, and other changes get room.
    const bool is_short = is_short_edge(gone, kept);
    const double gain = is_short && !merges ? kEqual : kLeastGain;
    // What is flatter than allowed goes node by node: the others may stay so.
    change.needed = std::max(change.before * std::min(least_gain_, gain),
                             change.before < kLowestQuality ? 0 : kLowestQuality);
    if (good_will_do) change.needed = std::min(change.needed, options_.target);
    change.needed = std::max(change.needed, better_than);
    change.after = quality_at(seen.views, points_[kept], change.needed, kept);
    if (!(change.after > change.needed)) return false;
    if (!list_collapse(gone, kept, seen, change) || !links_allow(gone, kept)) return false;
    if (!on_surface) {
        tag_added(change, entries_);
        return true;
    }
    // A merge of loose nodes turns what is smaller than the distance over which it may be made.
    const bool is_free = merges && is_loose_;
    const bool any_narrow = options_.merge_distance > 0 && change.before < kHopeless;
    if (!is_free && !facets_stay_aligned(gone, kept, any_narrow)) return false;
    if (strata_[gone].size() > 1 && !is_free) {
        const bool is_crease = count_feature_edges(gone) == 2;
        if (!is_crease && !merges) return false;  // a corner, or where a crease ends
        if (is_crease && !crease_stays_close(gone, kept)) return false;
    }
    tag_added(change, entries_);
    if ((merges || is_curved(strata_[gone])) && swells(change)) return false;
    return !crosses(change);
}

}  // namespace mortise::improve
