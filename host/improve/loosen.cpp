// The last resort for slivers that nothing else has helped: their nodes may leave the model by a small part
// of a cell.
//
// Where three and more surfaces pass within a hundredth of a cell of each other, nodes on all of them cannot
// move and features cannot be merged without losing others: what is left has angles of a fraction of a
// degree, which no solver bears. A node of such an element may lie beside its surfaces, first by a merge
// distance, then by more if that does not help. Walls and gaps keep their width: elements between surfaces
// that face away from each other are left alone, unless they are few.
#include <algorithm>

#include "host/common/disjoint_sets.hpp"
#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

constexpr int kMostRounds = 8;
constexpr std::uint64_t kMostEvaluations = 50;       ///< of qualities, per tetrahedron of the block,
constexpr std::uint64_t kLeastEvaluations = 200000;  ///< and besides
constexpr std::uint64_t kMostTrials = 1000;          ///< changes of several steps
constexpr double kSharp = 0.9;                       ///< cosine: edges of less than 26 degrees
/// Cells over which a wall or a gap, or rather its poor elements, may reach for its nodes to move.
constexpr double kWidestWall = 2.5;
/// A node farther from a surface than this, in edges of the smallest leaf, counts as loosened.
constexpr double kOffSurface = 1e-4;

}  // namespace

LooseStart find_loose_start(const Zone& zone) {
    std::vector<std::uint32_t> poor;
    for (std::uint32_t i = 0; i < zone.tetrahedra.size(); ++i) {
        if (zone.tetrahedra[i].quality < kRefineBelow) poor.push_back(i);
    }
    // Clusters: elements that share nodes.
    std::vector<std::uint32_t> last(zone.points.size(), kNone);
    DisjointSets sets(poor.size());
    for (std::uint32_t c = 0; c < poor.size(); ++c) {
        for (const ZoneNode n : zone.tetrahedra[poor[c]].node) {
            if (last[n] != kNone) sets.join(last[n], c);
            last[n] = c;
        }
    }
    struct Extent {
        Bounds box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
        double cell = 0;
    };
    std::vector<Extent> extents(poor.size());
    for (std::uint32_t c = 0; c < poor.size(); ++c) {
        Extent& extent = extents[sets.find(c)];
        for (const ZoneNode n : zone.tetrahedra[poor[c]].node) {
            extent.cell = std::max(extent.cell, edge_of(zone.size_class[n]));
            for (std::size_t j = 0; j < 3; ++j) {
                extent.box.low[j] = std::min(extent.box.low[j], zone.points[n][j]);
                extent.box.high[j] = std::max(extent.box.high[j], zone.points[n][j]);
            }
        }
    }
    LooseStart start;
    start.home = zone.points;
    start.is_wide.assign(zone.points.size(), 0);
    for (std::uint32_t c = 0; c < poor.size(); ++c) {
        const Extent& extent = extents[sets.find(c)];
        const Point diagonal = extent.box.high - extent.box.low;
        if (!(std::max({diagonal[0], diagonal[1], diagonal[2]}) > kWidestWall * extent.cell)) continue;
        for (const ZoneNode n : zone.tetrahedra[poor[c]].node) start.is_wide[n] = 1;
    }
    return start;
}

std::uint64_t count_loose(const Zone& zone, const LooseStart& start, const Surfaces& surfaces) {
    std::vector<std::uint8_t> seen(zone.points.size());
    std::uint64_t count = 0;
    for (const Tetrahedron& t : zone.tetrahedra) {
        for (const ZoneNode n : t.node) {
            if (seen[n] != 0 || zone.points[n] == start.home[n]) continue;
            seen[n] = 1;
            const double off = kOffSurface * edge_of(zone.size_class[n]);
            const std::uint32_t* on = zone.surfaces(n);
            count += std::any_of(on, on + zone.stratum_size(n), [&](std::uint32_t surface) {
                const Surfaces::Sample s = surfaces.sample(surface, zone.points[n]);
                return s.valid && std::fabs(s.value) > off * length(s.gradient);
            });
        }
    }
    return count;
}

/// Whether a node may lie at a point: within reach of where it was, and of each of its surfaces.
bool Block::is_within_reach(Local node, const Point& at) const {
    const double reach = loose_start_->reach * size_[node];
    const Point& home = loose_start_->home[zone_node_[node]];
    if (squared_length(at - home) > reach * reach) return false;
    const std::vector<std::uint32_t>& on = strata_[node];
    return std::all_of(on.begin(), on.end(), [&](std::uint32_t surface) {
        const Surfaces::Sample now = surfaces_->sample(surface, at);
        if (!now.valid) return false;
        const double distance = std::fabs(now.value) / length(now.gradient);
        if (distance <= reach) return true;
        const Surfaces::Sample before = surfaces_->sample(surface, home);
        return before.valid && distance <= std::fabs(before.value) / length(before.gradient);
    });
}

/// Whether an element lies between surfaces that face away from each other.
bool Block::is_in_wall(const std::array<Local, 4>& node) const {
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            if (i != j && makes_blade(node[i], node[j])) return true;
        }
    }
    return false;
}

/// Whether an element touches a sharp edge of the model: then no other shape of it is much better.
bool Block::is_at_sharp_edge(const std::array<Local, 4>& node) const {
    return std::any_of(node.begin(), node.end(), [this](Local n) {
        const std::vector<std::uint32_t>& on = strata_[n];
        for (std::size_t i = 0; i < on.size(); ++i) {
            const Point u = facing(n, on[i]).normal;
            for (std::size_t j = i + 1; j < on.size(); ++j) {
                const Point v = facing(n, on[j]).normal;
                const double cosine = dot(u, v);
                if (cosine < 0 && cosine * cosine > kSharp * kSharp * squared_length(u) * squared_length(v))
                    return true;
            }
        }
        return false;
    });
}

/// Poor elements whose nodes may leave their surfaces: not where the model itself is thin, or sharp.
std::vector<std::uint32_t> Block::list_loosable() const {
    std::vector<std::uint32_t> result;
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        const Tetrahedron& t = tetrahedra_[i];
        // Of nodes that are not free not all facets are seen.
        if (alive_[i] == 0 || t.quality >= kRefineBelow || !is_inside(t.node)) continue;
        const bool is_wide = std::any_of(t.node.begin(), t.node.end(), [this](Local n) {
            return n < loaded_ && loose_start_->is_wide[zone_node_[n]] != 0;
        });
        if (is_wide ? is_in_wall(t.node) : t.quality >= kMergeBelow && is_at_sharp_edge(t.node)) continue;
        result.push_back(i);
    }
    return result;
}

bool Block::loosen(const BlockOptions& options, const LooseStart& start) {
    options_ = options;
    loose_start_ = &start;
    options_.watch_facets = true;
    options_.target = kGoodQuality;
    running_.on = false;
    list_all_facets();
    std::fill(tried_.begin(), tried_.end(), 0);
    most_evaluated_ = evaluated_ + kLeastEvaluations + kMostEvaluations * tetrahedra_.size();
    trials_left_ = kMostTrials;
    is_loose_ = true;
    bool any = false;
    bool changed = true;
    for (int round = 0; round < kMostRounds && changed; ++round) {
        changed = false;
        for (const std::uint32_t i : list_loosable()) {
            if (evaluated_ > most_evaluated_) break;
            if (alive_[i] == 0 || tetrahedra_[i].quality >= kRefineBelow || !has_changed(i)) continue;
            ++counters.tried;
            if (improve(i) || look_ahead(i)) {
                changed = true;
            } else {
                tried_[i] = clock_;
            }
        }
        any = any || changed;
    }
    is_loose_ = false;
    return any;
}

}  // namespace mortise::improve
