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
constexpr std::uint64_t kMostEvaluations = 50;       ///< of qualities, per tetrahedron of the block,
constexpr std::uint64_t kLeastEvaluations = 200000;  ///< and besides
constexpr std::uint64_t kMostTrials = 1000;          ///< changes of several steps
constexpr double kSharp = 0.9;                       ///< cosine: edges of less than 26 degrees
constexpr double kFacingAway = 0.72;                 ///< cosine: as for merging
constexpr double kThickestWall = 0.5;                ///< cells
/// Skin of walls, both sides, in three by three by three cells; what has less is a strip, not a wall. A plate
/// has 18 squares of a cell's side, a strip half a cell wide 3.
constexpr double kMostSkin = 6;
/// What a wall's nodes may move, in thicknesses of it, for elements that are flatter than this part of it.
constexpr double kWallPart = 0.2;
constexpr double kFlatPart = 0.25;
/// A node whose facets on one surface add up to less than this part of their area lies on a rod or a ball
/// that is smaller than a cell.
constexpr double kTurning = 0.75;
/// A node farther from a surface than this, in edges of the smallest leaf, counts as loosened.
constexpr double kOffSurface = 1e-4;

}  // namespace

namespace {

/// A node's facets on one of its surfaces, as the whole zone has them.
struct Side {
    Point at;
    Point normal;  ///< outward, of length 1; zero: the zone has none of them
    double size;
    double area;  ///< of these facets, doubled
    bool turns;   ///< their normals differ much: a rod, or a ball, smaller than a cell
};

/// Per entry of zone.stratum.
std::vector<Side> find_sides(const Zone& zone) {
    std::vector<Side> sides(zone.stratum.size());
    for (const Tetrahedron& t : zone.tetrahedra) {
        for (std::size_t f = 0; f < 4; ++f) {
            if ((t.tag[f] & kTagInside) == 0) continue;
            const auto& o = kOpposite[f];
            const Point& a = zone.points[t.node[o[0]]];
            const Point normal = cross(zone.points[t.node[o[1]]] - a, zone.points[t.node[o[2]]] - a);
            for (const std::uint8_t k : o) {
                const std::uint32_t* on = zone.surfaces(t.node[k]);
                const std::uint32_t* end = on + zone.stratum_size(t.node[k]);
                const std::uint32_t* found = std::find(on, end, tag_surface(t.tag[f]));
                if (found == end) continue;
                Side& side = sides[static_cast<std::size_t>(found - zone.stratum.data())];
                side.normal = side.normal + normal;
                side.area += length(normal);
            }
        }
    }
    for (ZoneNode n = 0; n < zone.points.size(); ++n) {
        for (std::uint32_t k = zone.stratum_begin[n]; k < zone.stratum_end[n]; ++k) {
            const double norm = length(sides[k].normal);
            sides[k].at = zone.points[n];
            sides[k].size = edge_of(zone.size_class[n]);
            sides[k].turns = norm < kTurning * sides[k].area;
            if (norm > 0) sides[k].normal = (1 / norm) * sides[k].normal;
        }
    }
    return sides;
}

/// The thickest wall, in finest cells, across which two of these face away from each other; a negative number
/// if there is none.
double wall_between(const std::vector<Side>& sides) {
    double thickest = -1;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        for (std::size_t j = i + 1; j < sides.size(); ++j) {
            if (dot(sides[i].normal, sides[j].normal) > -kFacingAway) continue;
            // Of a bent wall one of the two says more than it is.
            const Point way = sides[j].at - sides[i].at;
            const double thickness =
                std::min(std::fabs(dot(way, sides[i].normal)), std::fabs(dot(way, sides[j].normal)));
            if (thickness < kThickestWall * std::min(sides[i].size, sides[j].size))
                thickest = std::max(thickest, thickness);
        }
    }
    return thickest;
}

using Bin = std::array<std::int32_t, 4>;  ///< size class, and place in edges of such leaves

Bin bin_of(const Zone& zone, ZoneNode n) {
    const int size_class = zone.size_class[n];
    Bin bin = {size_class, 0, 0, 0};
    for (std::size_t j = 0; j < 3; ++j)
        bin[j + 1] = static_cast<std::int32_t>(std::floor(zone.points[n][j] / edge_of(size_class)));
    return bin;
}

template <class Visit>
void for_bins_around(const Bin& bin, const Visit& visit) {
    for (std::int32_t k = 0; k < 27; ++k)
        visit(Bin{bin[0], bin[1] + k % 3 - 1, bin[2] + k / 3 % 3 - 1, bin[3] + k / 9 - 1});
}

/// Areas by bin.
class Areas {
  public:
    void add(const Bin& bin, double area) { entries_.push_back({bin, area}); }
    void sum_up() {
        std::stable_sort(entries_.begin(), entries_.end(),
                         [](const Entry& a, const Entry& b) { return a.first < b.first; });
        std::size_t count = 0;
        for (const Entry& entry : entries_) {
            if (count > 0 && entries_[count - 1].first == entry.first)
                entries_[count - 1].second += entry.second;
            else
                entries_[count++] = entry;
        }
        entries_.resize(count);
    }
    const std::vector<std::pair<Bin, double>>& entries() const { return entries_; }
    double at(const Bin& bin) const {
        const auto found = std::lower_bound(entries_.begin(), entries_.end(), bin,
                                            [](const Entry& a, const Bin& b) { return a.first < b; });
        return found != entries_.end() && found->first == bin ? found->second : 0;
    }

  private:
    using Entry = std::pair<Bin, double>;
    std::vector<Entry> entries_;
};

/// Per element: how thick the wall is in which it lies, as wall_between() tells.
std::vector<double> find_wall_elements(const Zone& zone, const std::vector<Side>& sides) {
    const std::size_t nodes = zone.points.size();
    std::vector<Side> around;
    const auto add_sides = [&](const Tetrahedron& t) {
        for (const ZoneNode n : t.node)
            around.insert(around.end(), sides.begin() + zone.stratum_begin[n],
                          sides.begin() + zone.stratum_end[n]);
    };
    std::vector<double> thickness(zone.tetrahedra.size());
    // The elements at each inner node: none of them may have both sides of a wall around it.
    std::vector<std::uint32_t> first(nodes + 1);
    const auto for_inner_nodes = [&](std::size_t i, const auto& visit) {
        for (const ZoneNode n : zone.tetrahedra[i].node) {
            if (zone.stratum_size(n) == 0) visit(n);
        }
    };
    for (std::size_t i = 0; i < zone.tetrahedra.size(); ++i) {
        around.clear();
        add_sides(zone.tetrahedra[i]);
        thickness[i] = wall_between(around);
        for_inner_nodes(i, [&](ZoneNode n) { ++first[n + 1]; });
    }
    for (std::size_t n = 0; n < nodes; ++n) first[n + 1] += first[n];
    std::vector<std::uint32_t> at(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < zone.tetrahedra.size(); ++i)
        for_inner_nodes(i, [&](ZoneNode n) { at[next[n]++] = i; });
    for (ZoneNode n = 0; n < nodes; ++n) {
        if (first[n] == first[n + 1]) continue;
        around.clear();
        for (std::uint32_t k = first[n]; k < first[n + 1]; ++k) add_sides(zone.tetrahedra[at[k]]);
        const double here = wall_between(around);
        for (std::uint32_t k = first[n]; k < first[n + 1]; ++k)
            thickness[at[k]] = std::max(thickness[at[k]], here);
    }
    return thickness;
}

/// How thick the walls of nodes are; a negative number for nodes of no wall, and of strips thinner than the
/// distance over which features may be merged.
std::vector<double> find_walls(const Zone& zone, const std::vector<Side>& sides, double merge_distance) {
    const std::vector<double> in_wall = find_wall_elements(zone, sides);
    Areas areas;
    for (std::size_t i = 0; i < in_wall.size(); ++i) {
        const Tetrahedron& t = zone.tetrahedra[i];
        for (std::size_t f = 0; f < 4 && in_wall[i] >= 0; ++f) {
            if ((t.tag[f] & kTagInside) == 0) continue;
            const auto& o = kOpposite[f];
            const Point& a = zone.points[t.node[o[0]]];
            const double twice = length(cross(zone.points[t.node[o[1]]] - a, zone.points[t.node[o[2]]] - a));
            const Bin bin = bin_of(zone, t.node[o[0]]);
            const double edge = edge_of(static_cast<std::uint8_t>(bin[0]));
            areas.add(bin, 0.5 * twice / (edge * edge));
        }
    }
    areas.sum_up();
    // Around each bin; then the nodes beside a bin with much skin around it, so that a wall's rim counts as
    // it.
    Areas wide;
    for (const auto& [bin, area] : areas.entries()) {
        double sum = 0;
        for_bins_around(bin, [&](const Bin& beside) { sum += areas.at(beside); });
        if (sum > kMostSkin) for_bins_around(bin, [&](const Bin& beside) { wide.add(beside, 1); });
    }
    wide.sum_up();
    std::vector<double> thickness(zone.points.size(), -1);
    for (std::size_t i = 0; i < in_wall.size(); ++i) {
        if (in_wall[i] < 0) continue;
        for (const ZoneNode n : zone.tetrahedra[i].node) {
            const bool counts =
                in_wall[i] > merge_distance * edge_of(zone.size_class[n]) || wide.at(bin_of(zone, n)) > 0;
            if (counts) thickness[n] = std::max(thickness[n], in_wall[i]);
        }
    }
    return thickness;
}

}  // namespace

LooseStart find_loose_start(const Zone& zone, double merge_distance) {
    LooseStart start;
    const std::vector<Side> sides = find_sides(zone);
    start.home = zone.points;
    start.used.assign(zone.points.size(), 0);
    start.wall = find_walls(zone, sides, merge_distance);
    for (ZoneNode n = 0; n < zone.points.size(); ++n) {
        double most = start.wall[n] < 0 ? HUGE_VAL : kWallPart * start.wall[n];
        for (std::uint32_t k = zone.stratum_begin[n]; k < zone.stratum_end[n]; ++k) {
            if (sides[k].turns) most = 0;
        }
        start.most.push_back(most);
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

/// How far a node, or anything that has been merged with it, would come from where it was.
double Block::way_to(Local node, const Point& at) const {
    const ZoneNode n = zone_node_[node];
    return length(at - loose_start_->home[n]) + loose_start_->used[n];
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
    double& used = loose_start_->used[zone_node_[kept]];
    used = std::max(used, way_to(gone, points_[kept]));
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
        if (alive_[i] == 0 || t.quality >= kRefineBelow || !is_inside(t.node)) continue;
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

bool Block::loosen(const BlockOptions& options, LooseStart& start) {
    options_ = options;
    loose_start_ = &start;
    options_.watch_facets = true;
    options_.target = kGoodQuality;
    running_.on = false;
    if (is_hopeless()) return false;
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
