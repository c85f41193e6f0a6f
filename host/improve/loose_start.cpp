// Where a zone's nodes may not become loose (loosen.cpp), or by little: in walls, at sharp edges, on small
// rods, holes and balls.
#include "host/improve/loose_start.hpp"

#include <algorithm>
#include <cmath>

namespace mortise::improve {
namespace {

constexpr double kThickestWall = 0.5;  ///< cells
/// Skin of walls, both sides, in three by three by three cells; what has less is a strip, not a wall. A plate
/// has 18 squares of a cell's side, a strip half a cell wide 3.
constexpr double kMostSkin = 6;
/// A node whose facets on one surface add up to less than this part of their area lies on a rod, a
/// hole or a ball that is smaller than a cell.
constexpr double kTurning = 0.75;
/// What such a node may move, in widths of a square as large as its facets: some 6 % of the radius in holes
/// of 0.6 cells, of which chords take up to a third anyway.
constexpr double kTurningPart = 0.05;
/// What a wall's nodes may move, in thicknesses of it.
constexpr double kWallPart = 0.2;
/// A node farther from a surface than this, in edges of the smallest leaf, counts as loosened.
constexpr double kLoosened = 1e-4;

/// A node's facets on one of its surfaces, as the whole zone has them.
struct Side {
    Point at;
    Point normal;  ///< outward, of length 1; zero: the zone has none of them
    double size;
    double area;  ///< of these facets, doubled
    bool turns;   ///< their normals differ much: kTurning
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
            if (sides[k].turns) most = std::min(most, kTurningPart * std::sqrt(0.5 * sides[k].area));
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
            const double off = kLoosened * edge_of(zone.size_class[n]);
            const std::uint32_t* on = zone.surfaces(n);
            count += std::any_of(on, on + zone.stratum_size(n), [&](std::uint32_t surface) {
                const Surfaces::Sample s = surfaces.sample(surface, zone.points[n]);
                return s.valid && std::fabs(s.value) > off * length(s.gradient);
            });
        }
    }
    return count;
}

}  // namespace mortise::improve
