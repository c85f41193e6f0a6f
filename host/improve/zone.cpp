#include "host/improve/zone.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/improve/kept_quads.hpp"
#include "host/improve/poor_cells.hpp"
#include "host/improve/split_elements.hpp"
#include "host/improve/tips.hpp"
#include "host/improve/zone_facets.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kZoneChunk = 4096;
/// An element that shares a node with one of the zone has its centroid within three cells of it: less than
/// CellSet::kShortReach. The last growth is not collected, the others reach two cells each; few zones grow.
constexpr int kGrowths = 3;
static_assert(3 < CellSet::kShortReach && 2 * (kGrowths - 1) + 3 < CellSet::kReach);

constexpr double kSameDistance = 2e-5;  ///< cells
constexpr double kLessTurned = 0.1;
constexpr double kFar = 1.5;  ///< cells: of a surface that has no value there

class Opener {
  public:
    Opener(const Mesh& mesh, const CellFrame& frame, const Surfaces& surfaces, const std::vector<Tip>& tips,
           const ZoneOptions& options, Known& known)
        : mesh_(mesh),
          frame_(frame),
          surfaces_(surfaces),
          tips_(tips),
          options_(options),
          threads_(options.threads),
          known_(known),
          cells_(frame.level, frame.leaves) {}

    Zone open() {
        if (cells_.is_graded()) {
            unit_class_ = finest_class(*frame_.leaves);
            find_cells(mesh_, frame_, cells_, known_, threads_, places_);
            find_size_classes(mesh_, frame_, cells_, known_.gone, threads_, places_);
        }
        rounding_ = volume_rounding(frame_, unit_class_);
        std::vector<CellId> poor =
            poor_cells(mesh_, frame_, cells_, places_, rounding_, options_.least, threads_, known_);
        poor.insert(poor.end(), known_.poor.begin(), known_.poor.end());
        for (const Tip& tip : tips_) poor.push_back(cells_.index(tip.point));
        if (options_.slabs != nullptr) {
            for (const Slab& slab : *options_.slabs) keep_those_in(slab, poor);
        }
        if (poor.empty()) return {};
        for (const CellId cell : poor) options_.is_wide ? cells_.set_two_rings(cell) : cells_.set_ring(cell);
        if (!cells_.is_graded()) find_cells(mesh_, frame_, cells_, known_, threads_, places_);
        if (options_.leaves_cubes) leave_cubes(poor);
        outer_quads_ = outer_quads(mesh_, frame_, cells_, threads_, known_);
        held_quads_ = held_quads(mesh_, options_.held);
        for (int round = 0; round < kGrowths; ++round) {
            collect();
            // The others see the faces of an element that has left the zone whole.
            while (!split()) collect();
            if (!grow()) break;
            if (round == 0 && !cells_.is_graded()) look_farther();
        }
        near_facets_ = find_near_facets(mesh_, frame_, cells_, place_, threads_, known_);
        finish_nodes();
        find_strata();
        tag_faces(mesh_, place_, near_facets_, options_.held, threads_, known_.gone.facet, zone_);
        correct_tags();
        find_strata();
        if (assign_tips(tips_, surfaces_, zone_)) find_strata();
        for_tetrahedra([this](Tetrahedron& t) {
            t.quality = quality(t);
            t.share = tetrahedron_volume(zone_.points[t.node[0]], zone_.points[t.node[1]],
                                         zone_.points[t.node[2]], zone_.points[t.node[3]]);
        });
        for (const CellId cell : poor) {
            if (!cells_.test(cell)) zone_.left_poor.push_back(cell);
        }
        for (const ElementRef& r : elements_)
            zone_.taken[r.type].push_back(static_cast<std::uint32_t>(r.index));
        return std::move(zone_);
    }

  private:
    /// Visits tetrahedra of the zone on all threads; each may be changed.
    template <class Visit>
    void for_tetrahedra(const Visit& visit) {
        parallel_chunks(zone_.tetrahedra.size(), kZoneChunk, threads_,
                        [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t i = begin; i < end; ++i) visit(zone_.tetrahedra[i]);
                        });
    }

    void keep_those_in(const Slab& slab, std::vector<CellId>& poor) const {
        poor.erase(std::remove_if(poor.begin(), poor.end(),
                                  [&](CellId cell) {
                                      const std::int64_t at = cells_.cell_of(cell)[slab.axis];
                                      return at < slab.low || at >= slab.high;
                                  }),
                   poor.end());
    }

    /// Cubes are no part of the ring around poor cells.
    void leave_cubes(std::vector<CellId> poor) {
        std::sort(poor.begin(), poor.end());
        for (std::size_t i = 0; i < places_.element[0].size(); ++i) {
            if (!is_cube(mesh_.elements[0], 0, places_.element[0][i])) continue;
            const CellId cell = places_.cell(mesh_, frame_, cells_, 0, i);
            if (!std::binary_search(poor.begin(), poor.end(), cell)) cells_.reset(cell);
        }
    }

    /// The elements of the zone are in the mesh again.
    void put_back() {
        for (const ElementRef& r : elements_) known_.gone.element[r.type][r.index] = 0;
        elements_.clear();
    }

    void look_farther() {
        put_back();
        cells_.extend_reach(CellSet::kReach);
        places_ = {};
        find_cells(mesh_, frame_, cells_, known_, threads_, places_);
        outer_quads_ = outer_quads(mesh_, frame_, cells_, threads_, known_);
    }

    void collect() {
        zone_ = Zone{};
        zone_.finest_class = unit_class_;
        zone_.unit = edge_of(unit_class_);
        zone_.rounding = rounding_;
        put_back();
        for (int t = 0; t < kElementTypes; ++t) {
            const auto type = static_cast<std::size_t>(t);
            const std::vector<std::uint32_t>& listed = places_.element[type];
            std::vector<std::uint8_t>& gone = known_.gone.element[type];
            std::vector<std::vector<ElementRef>> found(chunk_count(listed.size(), kZoneChunk));
            parallel_chunks(listed.size(), kZoneChunk, threads_,
                            [&](std::size_t begin, std::size_t end, int) {
                                for (std::size_t i = begin; i < end; ++i) {
                                    const CellId cell = places_.cell(mesh_, frame_, cells_, t, i);
                                    if (gone[listed[i]] != 0 || !cells_.test(cell)) continue;
                                    gone[listed[i]] = 1;
                                    found[begin / kZoneChunk].push_back(
                                        {static_cast<std::uint8_t>(t), listed[i], cell, 0});
                                }
                            });
            append_lists(found, threads_, elements_);
        }
        if (!options_.cuts_quads) mark_kept_quads(mesh_, outer_quads_, held_quads_, threads_, elements_);
        number_nodes();
    }

    /// Nodes of the zone, in the order of their numbers in the mesh.
    void number_nodes() {
        place_.clear(mesh_.node_count());
        for (const ElementRef& r : elements_) {
            const Element e = element(mesh_, r.type, r.index);
            for (std::size_t k = 0; k < e.count; ++k) place_.add(e.node[k]);
        }
        place_.number([this](NodeId node) {
            zone_.points.push_back(in_cells(mesh_, frame_, node));
            zone_.size_class.push_back(static_cast<std::uint8_t>(places_.size_class(node)));
            zone_.mesh_node.push_back(node);
        });
    }

    /// False if an element cannot be split: it leaves the zone with its cell.
    bool split() {
        const std::vector<CellId> refused =
            split_elements(mesh_, frame_, cells_, elements_, place_, threads_, zone_);
        for (const CellId cell : refused) cells_.reset(cell);
        return refused.empty();
    }

    /// Where a pyramid at the zone's border is poor, the zone takes one more ring.
    bool grow() {
        std::vector<CellId> poor;
        for (const Pyramid& p : zone_.pyramids) {
            const auto c = corners(p);
            if (pyramid_quality(c) >= options_.least) continue;
            poor.push_back(cells_.index(0.2 * (c[0] + c[1] + c[2] + c[3] + c[4])));
        }
        for (const CellId cell : poor) cells_.set_ring(cell);
        return !poor.empty();
    }

    void finish_nodes() {
        const std::size_t count = zone_.points.size();
        zone_.original = zone_.points;
        zone_.joined.assign(count, 0);
        for (const Pyramid& p : zone_.pyramids) {
            for (const ZoneNode node : p.node) zone_.joined[node] = 1;
        }
        // The listed elements are enough: others share no node with the zone. Threads may mark the same node.
        std::vector<std::atomic<std::uint8_t>> frozen(count);
        for (int t = 0; t < kElementTypes; ++t) {
            const std::vector<std::uint8_t>& gone = known_.gone.element[static_cast<std::size_t>(t)];
            const std::vector<std::uint32_t>& listed = places_.element[static_cast<std::size_t>(t)];
            parallel_chunks(listed.size(), kZoneChunk, threads_,
                            [&](std::size_t begin, std::size_t end, int) {
                                for (std::size_t i = begin; i < end; ++i) {
                                    if (gone[listed[i]] != 0) continue;
                                    const Element e = element(mesh_, t, listed[i]);
                                    for (std::size_t k = 0; k < e.count; ++k) {
                                        const ZoneNode node = place_[e.node[k]];
                                        if (node != kNone) frozen[node].store(1, std::memory_order_relaxed);
                                    }
                                }
                            });
        }
        zone_.frozen.assign(frozen.begin(), frozen.end());
        for (const std::size_t i : near_facets_) {
            if (!is_held(mesh_.facets.surface[i])) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                const ZoneNode node = place_[mesh_.facets.nodes[4 * i + k]];
                if (node != kNone) zone_.frozen[node] = 1;
            }
        }
    }

    /// Surfaces of each node: of the facets of the mesh that stay, and of those that the zone has taken.
    void find_strata() {
        const std::size_t count = zone_.points.size();
        // Most nodes have one surface at most: the first of each, and what others there are.
        std::vector<std::uint32_t> first(count, kNone);
        std::vector<std::pair<ZoneNode, std::uint32_t>> others;
        const auto add = [&](ZoneNode node, std::uint32_t surface) {
            if (first[node] == kNone) first[node] = surface;
            if (first[node] != surface) others.push_back({node, surface});
        };
        const FacetBlock& facets = mesh_.facets;
        for (const std::size_t i : near_facets_) {
            if (known_.gone.facet[i] != 0) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                const ZoneNode node = place_[facets.nodes[4 * i + k]];
                if (node != kNone) add(node, facets.surface[i]);
            }
        }
        for (const Tetrahedron& t : zone_.tetrahedra) {
            for (std::size_t f = 0; f < 4; ++f) {
                if (t.tag[f] == 0) continue;
                for (const std::uint8_t k : kOpposite[f]) add(t.node[k], tag_surface(t.tag[f]));
            }
        }
        parallel_sort(others, threads_);
        others.erase(std::unique(others.begin(), others.end()), others.end());
        std::vector<std::uint32_t>& stratum = zone_.stratum;
        stratum.clear();
        zone_.stratum_begin.assign(count, 0);
        zone_.stratum_end.assign(count, 0);
        auto other = others.begin();
        for (ZoneNode node = 0; node < count; ++node) {
            if (first[node] == kNone) continue;
            zone_.stratum_begin[node] = static_cast<std::uint32_t>(stratum.size());
            for (; other != others.end() && other->first == node && other->second < first[node]; ++other)
                stratum.push_back(other->second);
            stratum.push_back(first[node]);
            for (; other != others.end() && other->first == node; ++other) stratum.push_back(other->second);
            zone_.stratum_end[node] = static_cast<std::uint32_t>(stratum.size());
        }
    }

    bool is_held(std::uint32_t surface) const {
        return options_.held != nullptr && (*options_.held)[surface] != 0;
    }

    /// How far a facet's nodes are from a surface, in finest cells; and how much it is turned against it, 0
    /// to 1.
    struct Fit {
        double distance = 0;
        double turned = 1;
    };
    Fit fit(std::uint32_t surface, const std::array<Point, 3>& p, double size) const {
        Fit result;
        for (const Point& x : p) {
            const Surfaces::Sample s = surfaces_.sample(surface, x);
            if (!s.valid) return {kFar * size, 1};
            result.distance = std::max(result.distance, std::fabs(s.value) / length(s.gradient));
        }
        const Surfaces::Sample s = surfaces_.sample(surface, (1.0 / 3) * (p[0] + p[1] + p[2]));
        const Point normal = cross(p[1] - p[0], p[2] - p[0]);
        const double product = s.valid ? length(normal) * length(s.gradient) : 0;
        if (product > 0) result.turned = 1 - std::fabs(dot(normal, s.gradient)) / product;
        return result;
    }

    /// Where the certificate's slivers lie on several surfaces at once, their facets may carry the wrong one.
    /// Each facet gets, of the surfaces that its nodes have, the one it fits best.
    void correct_tags() {
        for_tetrahedra([this](Tetrahedron& t) {
            for (std::size_t f = 0; f < 4; ++f) {
                if (t.tag[f] == 0 || (t.tag[f] & kTagBorder) != 0) continue;
                std::array<ZoneNode, 3> node = {t.node[kOpposite[f][0]], t.node[kOpposite[f][1]],
                                                t.node[kOpposite[f][2]]};
                if (std::all_of(node.begin(), node.end(),
                                [&](ZoneNode n) { return zone_.stratum_size(n) < 2; }))
                    continue;
                // Both sides of an interface must decide alike: in one order of the nodes.
                std::sort(node.begin(), node.end());
                const std::array<Point, 3> p = {zone_.points[node[0]], zone_.points[node[1]],
                                                zone_.points[node[2]]};
                std::uint32_t best = tag_surface(t.tag[f]);
                const double size = std::min({size_at(node[0]), size_at(node[1]), size_at(node[2])});
                Fit best_fit = fit(best, p, size);
                for (const ZoneNode n : node) {
                    for (std::size_t k = 0; k < zone_.stratum_size(n); ++k) {
                        const std::uint32_t other = zone_.surfaces(n)[k];
                        if (other == best || is_held(other)) continue;
                        const Fit other_fit = fit(other, p, size);
                        if (other_fit.distance > best_fit.distance + kSameDistance * size ||
                            other_fit.turned > best_fit.turned - kLessTurned)
                            continue;
                        best = other;
                        best_fit = other_fit;
                    }
                }
                t.tag[f] = make_tag(best) | (t.tag[f] & (kTagInside | kTagInterface | kTagBorder));
            }
        });
    }

    std::array<Point, 5> corners(const Pyramid& p) const {
        std::array<Point, 5> result;
        for (std::size_t k = 0; k < 5; ++k) result[k] = zone_.points[p.node[k]];
        return result;
    }
    double quality(const Tetrahedron& t) const {
        return tetrahedron_quality(zone_.points[t.node[0]], zone_.points[t.node[1]], zone_.points[t.node[2]],
                                   zone_.points[t.node[3]], rounding_);
    }
    /// Edge of the smallest leaf around a node.
    double size_at(ZoneNode n) const { return edge_of(zone_.size_class[n]); }

    const Mesh& mesh_;
    const CellFrame& frame_;
    const Surfaces& surfaces_;
    const std::vector<Tip>& tips_;
    const ZoneOptions& options_;
    int threads_;
    Known& known_;
    CellSet cells_;
    Zone zone_;
    Places places_;
    int unit_class_ = 0;
    double rounding_ = kVolumeRounding;
    std::vector<QuadKey> outer_quads_, held_quads_;
    std::vector<ElementRef> elements_;
    ZoneNodes place_;                         ///< of the mesh's nodes, without new ones
    std::vector<std::uint32_t> near_facets_;  ///< facets with a node in the zone
};

}  // namespace

Zone open_zone(const Mesh& mesh, const CellFrame& frame, const Surfaces& surfaces,
               const std::vector<Tip>& tips, const ZoneOptions& options, Known& known) {
    return Opener(mesh, frame, surfaces, tips, options, known).open();
}

}  // namespace mortise::improve
