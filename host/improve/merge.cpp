// Features of the model closer to each other than a small part of a cell: steps, slits and strips that often
// are artefacts of the model's making. Kept apart they force slivers of their width. So where elements are
// poor, a node may be merged with one that lies almost on all of its surfaces.
//
// A merged node's stratum is what its facets lie on afterwards, though it lies on some of these surfaces only
// almost. Topology is that of any collapse: sheets are never joined or parted.
#include <algorithm>

#include "host/common/sort_unique.hpp"
#include "host/common/watch.hpp"
#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

constexpr double kParallel = 0.1;  ///< sine of the angle between two creases
constexpr int kFewestSideBySide = 4;

}  // namespace

bool Block::has_creases_side_by_side(double merge_distance) const {
    const auto direction = [this](Local n) -> Point {
        const Surfaces::Sample a = surfaces_->sample(strata_[n][0], points_[n]);
        const Surfaces::Sample b = surfaces_->sample(strata_[n][1], points_[n]);
        return a.valid && b.valid ? cross(a.gradient, b.gradient) : Point{0, 0, 0};
    };
    const auto is_side_by_side = [&](Local a, Local b) {
        if (strata_[a].size() != 2 || strata_[b].size() != 2 || strata_[a] == strata_[b]) return false;
        const double reach = 0.5 * merge_distance * std::min(size_[a], size_[b]);
        if (squared_length(points_[a] - points_[b]) > reach * reach) return false;
        const Point u = direction(a);
        const Point v = direction(b);
        return squared_length(cross(u, v)) < kParallel * kParallel * squared_length(u) * squared_length(v);
    };
    int count = 0;
    for (const Tetrahedron& t : tetrahedra_) {
        for (std::size_t i = 0; i < 4 && t.quality < kMergeBelow; ++i) {
            for (std::size_t j = i + 1; j < 4; ++j) {
                if (is_side_by_side(t.node[i], t.node[j]) && ++count == kFewestSideBySide) return true;
            }
        }
    }
    return false;
}

/// A node's facets on a surface: their outward normal, twice as long as their area, and which way they lie
/// from the node.
Block::Facing Block::facing(Local node, std::uint32_t surface) const {
    Facing sum{};
    for (const std::uint32_t i : star_[node]) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.node[f] == node || (t.tag[f] & kTagInside) == 0 || tag_surface(t.tag[f]) != surface)
                continue;
            const Point& a = points_[t.node[kOpposite[f][0]]];
            const Point& b = points_[t.node[kOpposite[f][1]]];
            const Point& c = points_[t.node[kOpposite[f][2]]];
            const Point normal = cross(b - a, c - a);
            sum.normal = sum.normal + normal;
            sum.away = sum.away + length(normal) * ((1.0 / 3) * (a + b + c) - points_[node]);
        }
    }
    return sum;
}

/// Whether surfaces that face away from each other would meet: the rim of a thin plate, or of a slit, would
/// be eaten up from there. Not at the two ends of a crease between corners, if the surfaces lie on opposite
/// sides of it; at corners of a plate they lie on the same side.
bool Block::makes_blade(Local gone, Local kept) const {
    const std::vector<std::uint32_t>& on_gone = strata_[gone];
    const std::vector<std::uint32_t>& on_kept = strata_[kept];
    const auto is_in = [](const std::vector<std::uint32_t>& list, std::uint32_t surface) {
        return std::binary_search(list.begin(), list.end(), surface);
    };
    const auto shared = std::count_if(on_gone.begin(), on_gone.end(),
                                      [&](std::uint32_t surface) { return is_in(on_kept, surface); });
    for (const std::uint32_t a : on_gone) {
        const Facing u = facing(gone, a);
        for (const std::uint32_t b : on_kept) {
            if (is_in(on_kept, a) && is_in(on_gone, b)) continue;
            const Facing v = facing(kept, b);
            const double cosine = dot(u.normal, v.normal);
            const double square = squared_length(u.normal) * squared_length(v.normal);
            if (cosine < 0 && cosine * cosine > kFacingAway * kFacingAway * square &&
                (shared < 2 || dot(u.away, v.away) >= 0))
                return true;
        }
    }
    return false;
}

/// Whether `gone`, on a stratum that `kept` is not on, may be merged with it. A crease is not moved onto a
/// face, nor a corner onto a crease, unless nodes may be loose: then whatever is within reach.
bool Block::may_merge(Local gone, Local kept) {
    if (!may_merge_ || free_[kept] == 0) return false;
    if (is_loose_ && !strata_[kept].empty() && is_within_reach(gone, points_[kept])) return true;
    if (strata_[kept].size() < 2) return false;
    if (strata_[kept].size() < strata_[gone].size()) return false;
    const auto& star = star_[gone];
    if (std::none_of(star.begin(), star.end(),
                     [this](std::uint32_t i) { return tetrahedra_[i].quality < kMergeBelow; }))
        return false;
    const double reach = options_.merge_distance * std::min(size_[gone], size_[kept]);
    const auto is_near = [&](std::uint32_t surface) {
        if (std::binary_search(strata_[kept].begin(), strata_[kept].end(), surface)) return true;
        const Surfaces::Sample s = surfaces_->sample(surface, points_[kept]);
        return s.valid && std::fabs(s.value) <= reach * length(s.gradient);
    };
    if (!std::all_of(strata_[gone].begin(), strata_[gone].end(), is_near) || makes_blade(gone, kept))
        return false;
    // A corner, or where a crease ends, goes no farther than to what is next to it.
    const std::size_t on = strata_[gone].size();
    if (on < 2 || (on == 2 && count_feature_edges(gone) > 1)) return true;
    return squared_length(points_[gone] - points_[kept]) <= reach * reach;
}

/// Before anything else, while features that run side by side still have their nodes side by side.
void Block::merge_close_nodes() {
    if (!(options_.merge_distance > 0)) return;
    const auto is_close = [this](Local a, Local b) {
        const double reach = options_.merge_distance * std::min(size_[a], size_[b]);
        return squared_length(points_[a] - points_[b]) <= reach * reach;
    };
    may_merge_ = true;
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        keep_watch();
        for (std::size_t k = 0; k < 12 && alive_[i] != 0; ++k) {
            const Local gone = tetrahedra_[i].node[k % 4];
            const Local kept = tetrahedra_[i].node[(k % 4 + 1 + k / 4) % 4];
            if (tetrahedra_[i].quality >= kMergeBelow || !is_close(gone, kept)) continue;
            if (examine_collapse(gone, kept, true, 0, trial_)) apply(trial_);
        }
    }
    may_merge_ = false;
}

/// Tries to merge nodes of an element that nothing else improves.
bool Block::merge(const std::array<Local, 4>& node) {
    if (!(options_.merge_distance > 0) || running_.on) return false;
    bool found = false;
    may_merge_ = true;
    for (const Local gone : node) {
        for (const Local kept : node) {
            if (gone == kept || !examine_collapse(gone, kept, false, found ? best_.after : 0, trial_))
                continue;
            std::swap(trial_, best_);
            found = true;
        }
    }
    may_merge_ = false;
    if (found) apply(best_);
    return found;
}

bool Block::has_slivers() const {
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
        const Tetrahedron& t = tetrahedra_[i];
        if (alive_[i] != 0 && t.quality < kMergeBelow && is_inside(t.node)) return true;
    }
    return false;
}

bool Block::merge_slivers(double merge_distance) {
    const std::uint64_t merged = counters.merged;
    options_.merge_distance = merge_distance;
    merge_close_nodes();
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        if (alive_[i] != 0 && tetrahedra_[i].quality < kMergeBelow) improve(i);
    }
    if (counters.merged == merged) return false;
    mend(count_alive());
    return true;
}

/// Sets the strata of the nodes of a merge's elements by their facets.
void Block::renew_strata(const Change& merge) {
    std::vector<Local> nodes;
    for (const Tetrahedron& t : merge.added) nodes.insert(nodes.end(), t.node.begin(), t.node.end());
    for (const std::uint32_t i : merge.removed) {
        nodes.insert(nodes.end(), tetrahedra_[i].node.begin(), tetrahedra_[i].node.end());
    }
    sort_unique(nodes);
    for (const Local n : nodes) {
        // Of others not all facets are in the block.
        if (free_[n] == 0 || star_[n].empty()) continue;
        std::vector<std::uint32_t> on;
        for (const std::uint32_t i : star_[n]) {
            const Tetrahedron& t = tetrahedra_[i];
            for (std::size_t f = 0; f < 4; ++f) {
                if (t.tag[f] != 0 && t.node[f] != n) on.push_back(tag_surface(t.tag[f]));
            }
        }
        sort_unique(on);
        if (on == strata_[n]) continue;
        strata_[n] = on;
        renewed_.push_back(n);
    }
}

}  // namespace mortise::improve
