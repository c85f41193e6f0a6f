// The last resort for slivers that nothing else has helped: their nodes may leave the model by a small part
// of a cell.
//
// Where three and more surfaces pass within a hundredth of a cell of each other, nodes on all of them cannot
// move and features cannot be merged without losing others: what is left has angles of a fraction of a
// degree, which no solver bears. A node of such an element may lie beside its surfaces, first by a merge
// distance, then by more if that does not help. Nodes of walls and sharp edges, if these are no narrow
// strips, stay within a part of their thickness: there the model itself is as thin, or as sharp.
#include <algorithm>

#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

constexpr int kMostRounds = 8;
constexpr std::uint64_t kLooseEvaluations = 50;           ///< of qualities, per tetrahedron of the block,
constexpr std::uint64_t kLeastLooseEvaluations = 200000;  ///< and besides
constexpr std::uint64_t kMostLooseTrials = 1000;          ///< changes of several steps
constexpr double kSharp = 0.9;                            ///< cosine: edges of less than 26 degrees
/// Of a wall's thickness: elements that are flatter are not as flat because of the wall.
constexpr double kFlatPart = 0.25;

}  // namespace

/// How far a node, or anything that has been merged with it, would come from where it was.
double Block::way_to(Local node, const Point& at) const {
    return length(at - loose_start_->home[zone_node_[node]]) + used_[node];
}

/// Whether a node may lie at a point: within reach of where it was, and of each of its surfaces.
bool Block::is_within_reach(Local node, const Point& at) const {
    const Point& home = loose_start_->home[zone_node_[node]];
    const double reach = std::min(loose_start_->reach * size_[node], loose_start_->most[zone_node_[node]]);
    if (way_to(node, at) > reach) return false;
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

/// A node is about to be merged with another.
void Block::note_way(Local gone, Local kept) {
    used_[kept] = std::max(used_[kept], way_to(gone, points_[kept]));
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

/// Poor elements whose nodes may leave their surfaces: not those that a wall or a sharp edge explains.
std::vector<std::uint32_t> Block::list_loosable() const {
    std::vector<std::uint32_t> result;
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        const Tetrahedron& t = tetrahedra_[i];
        // Of nodes that are not free not all facets are seen.
        if (alive_[i] == 0 || t.quality >= kLoosenBelow || !is_inside(t.node)) continue;
        double wall = HUGE_VAL;
        std::array<Point, 4> p;
        for (std::size_t k = 0; k < 4; ++k) {
            wall = std::min(wall, loose_start_->wall[zone_node_[t.node[k]]]);
            p[k] = points_[t.node[k]];
        }
        if (wall >= 0 && smallest_height(p) >= kFlatPart * wall) continue;
        if (t.quality >= kMergeBelow && is_at_sharp_edge(t.node)) continue;
        result.push_back(i);
    }
    return result;
}

bool Block::loosen(const BlockOptions& options, const LooseStart& start) {
    options_ = options;
    loose_start_ = &start;
    used_.clear();
    for (const ZoneNode n : zone_node_) used_.push_back(start.used[n]);
    options_.watch_facets = true;
    options_.target = kGoodQuality;
    running_.on = false;
    if (is_hopeless()) return false;
    list_watched_facets();
    std::fill(tried_.begin(), tried_.end(), 0);
    most_evaluated_ = evaluated_ + kLeastLooseEvaluations + kLooseEvaluations * tetrahedra_.size();
    trials_left_ = kMostLooseTrials;
    is_loose_ = true;
    bool any = false;
    bool changed = true;
    for (int round = 0; round < kMostRounds && changed; ++round) {
        changed = false;
        for (const std::uint32_t i : list_loosable()) {
            if (evaluated_ > most_evaluated_) break;
            if (alive_[i] == 0 || tetrahedra_[i].quality >= kLoosenBelow || !has_changed(i)) continue;
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
