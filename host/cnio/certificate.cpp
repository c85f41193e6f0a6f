#include "host/cnio/certificate.hpp"

#include <algorithm>

#include "host/common/sort_unique.hpp"
#include "host/common/watch.hpp"

namespace mortise::cnio {
namespace {

// A cell that holds too many surfaces to be cut by all of them stays as it is then: valid, but coarser.
constexpr std::size_t kMostWork = 1u << 19;  ///< simplices times surfaces
constexpr std::size_t kMostSimplices = 32768;
constexpr std::size_t kFewestSimplices = 256;

constexpr std::int64_t kSampleWeight = 8;

constexpr double kShortestBulge = 0.1;  ///< edge that is looked at, in cells
constexpr double kLeastBulge = 0.02;    ///< cells

/// The last cap is 5e-6 of a cell high: below it no sign changes (kSignTolerance).
constexpr int kCapHalvings = 16;

}  // namespace

CellRecord Certificate::run(const TreeNode& leaf, CellArena& arena, const LatticePoint* apex) {
    keep_watch();
    cell_.load(leaf);
    if (cell_.is_crowded()) ++cell_.counters.limited;
    clear();
    whole_.clear();
    whole_region_ = 0;
    CellRecord record;
    std::int32_t region = kUnknown;
    record.is_transition = cell_.surface_count() == 0 && !cell_.has_split_faces();
    if (apex == nullptr && (record.is_transition || is_uniform(&region))) {
        if (record.is_transition) region = cell_.local_tape().resolve(nullptr);
        whole_region_ = std::max(region, 0);
        if (whole_region_ > 0) fill_whole();
    } else if (apex != nullptr || hides_surface()) {
        LatticePoint at = apex != nullptr ? *apex : cell_.centre();
        for (std::int32_t& x : at) x *= apex != nullptr ? cell_.units() / kCellUnits : 1;
        fill_cone(at);
    } else {
        find_cone();
    }
    if (cell_.snaps()) record.unfit = unfit_corners();
    collect(record, arena);
    return record;
}

/// The cone from the apex, or from one on fewer surfaces where elements of the former do not bear that
/// corners move. On one at least: from the middle the foot of a thin rod was pinched.
void Certificate::find_cone() {
    const CellCounters before = cell_.counters;
    LatticePoint tried[kMostApexSurfaces];
    std::size_t count = 0;
    const auto fill = [&](const LatticePoint& at) {
        cell_.drop_inner_nodes();
        cell_.counters = before;
        clear();
        fill_cone(at);
    };
    for (std::size_t most = kMostApexSurfaces; most > 0; --most) {
        const LatticePoint at = cell_.apex(most);
        if (std::find(tried, tried + count, at) != tried + count) continue;
        fill(at);
        if (!cell_.snaps() || unfit_corners() == 0) return;
        tried[count++] = at;
    }
    if (count > 1) fill(tried[0]);
}

void Certificate::clear() {
    simplices_.clear();
    incident_.clear();
    pyramids_.clear();
    simplex_region_.clear();
    pyramid_region_.clear();
    refused_.clear();
}

/// All elements from the apex, cut by all surfaces, with their regions.
void Certificate::fill_cone(const LatticePoint& at) {
    const std::size_t first_inside = cell_.nodes().size();
    cone(at);
    const std::vector<std::size_t>& order = cell_.cutting_order();
    bool again = true;
    for (int round = 0; round < kBisectionRounds && again && !is_full(); ++round) {
        again = false;
        for (std::size_t k = 0; k < order.size() && !is_full(); ++k) again = bisect(order, k, round) || again;
    }
    cell_.settle_targets(first_inside, nullptr);
    const std::size_t n = cell_.surface_count();
    simplex_signs_.resize(simplices_.size() * n);
    pyramid_signs_.resize(pyramids_.size() * n);
    for (std::size_t i = 0; i < simplices_.size(); ++i)
        simplex_region_.push_back(label(simplices_[i].node.data(), 4, simplex_signs_.data() + i * n));
    for (std::size_t i = 0; i < pyramids_.size(); ++i)
        pyramid_region_.push_back(label(pyramids_[i].node.data(), 5, pyramid_signs_.data() + i * n));
}

/// Elements of a cell in one region, with whole faces or beside finer leaves.
void Certificate::fill_whole() {
    SplitPattern pattern = 0;
    for (int b = 0; b < kSplitBits; ++b) {
        if (cell_.vertex(split_vertex(b)) != kNoNode) pattern |= SplitPattern{1} << b;
    }
    transition_elements(pattern, transition_);
    LocalNode centre = kNoNode;
    for (const TransitionElement& element : transition_) {
        Whole whole{};
        whole.type = element.count == 8   ? ElementType::kHexahedron
                     : element.count == 6 ? ElementType::kWedge
                     : element.count == 5 ? ElementType::kPyramid
                                          : ElementType::kTetrahedron;
        for (std::size_t i = 0; i < static_cast<std::size_t>(element.count); ++i) {
            const bool at_centre = element.node[i] == kGridCentre;
            if (at_centre && centre == kNoNode) centre = cell_.add_node(cell_.centre(), 0);
            whole.node[i] = at_centre ? centre : cell_.vertex(element.node[i]);
        }
        whole_.push_back(whole);
    }
}

/// Whether the apex must stay in the centre: if that alone tells that some surface passes through the cell,
/// or if a tube of it leaves the cell within a face (the tip of a cone); from an apex on the tube's side no
/// simplex would join its ends.
bool Certificate::hides_surface() const {
    for (std::size_t s = 0; s < cell_.surface_count(); ++s) {
        if (!cell_.is_named(s)) continue;
        const int centre = cell_.pure_sign(s, cell_.centre(), cell_.size());
        const auto is_other = [&](std::size_t c) {
            return cell_.sign(static_cast<LocalNode>(c), s) == -centre;
        };
        bool alone = centre != 0;
        for (std::size_t c = 0; c < 8 && alone; ++c) alone = is_other(c);
        if (alone) return true;
        for (const auto& corner : kFaceCorners) {
            if (centre == 0 || !std::all_of(corner, corner + 4, is_other)) continue;
            const LatticePoint& low = cell_.nodes()[corner[0]].point;
            const LatticePoint& high = cell_.nodes()[corner[2]].point;
            LatticePoint middle;
            for (std::size_t j = 0; j < 3; ++j) middle[j] = low[j] + (high[j] - low[j]) / 2;
            if (cell_.pure_sign(s, middle, cell_.size()) == centre) return true;
        }
    }
    return false;
}

bool Certificate::is_full() const {
    return simplices_.size() >= std::clamp(kMostWork / std::max<std::size_t>(1, cell_.surface_count()),
                                           kFewestSimplices, kMostSimplices);
}

bool Certificate::is_uniform(std::int32_t* region) const {
    if (!cell_.has_whole_faces()) return false;
    std::vector<std::int8_t> signs(cell_.surface_count());
    for (std::size_t s = 0; s < cell_.surface_count(); ++s) {
        Sides sides;
        if (!cell_.is_named(s)) continue;
        for (LocalNode c = 0; c < 8; ++c) sides.add(cell_.sign(c, s));
        sides.add(cell_.pure_sign(s, cell_.centre(), cell_.size()));
        if (sides.are_mixed()) return false;
        signs[s] = sides.sign();
    }
    *region = cell_.local_tape().resolve(signs.data());
    return *region != kUnknown;
}

/// Adds a simplex and lists it with its nodes. Lists only grow: a simplex that has lost a node is skipped
/// when met.
void Certificate::add_simplex(const std::array<LocalNode, 4>& node) {
    simplices_.push_back({node, false});
    incident_.resize(cell_.nodes().size());
    for (const LocalNode n : node) incident_[n].push_back(static_cast<std::uint32_t>(simplices_.size() - 1));
}

void Certificate::cone(const LatticePoint& at) {
    const LocalNode apex = cell_.add_node(at, 0);
    cell_.settle_pole(apex, octree::LeafPole::kInside);
    for (int p = 0; p < kPatches; ++p) {
        const bool outward = frame_points_outward(p / 4);
        for (Facet facet : cell_.patch(p)) {
            // Turn the facet so that it is counter-clockwise seen from the apex.
            if (outward) std::reverse(facet.node, facet.node + facet.count);
            const LocalNode* v = facet.node;
            if (facet.count == 3) {
                add_simplex({v[0], v[1], v[2], apex});
                continue;
            }
            if (!is_mixed(facet, apex)) {
                pyramids_.push_back({{v[0], v[1], v[2], v[3], apex}});
                continue;
            }
            const LocalNode cap = add_cap(facet, at);
            pyramids_.push_back({{v[0], v[1], v[2], v[3], cap}});
            for (int i = 0; i < 4; ++i) add_simplex({v[i], v[(i + 1) % 4], cap, apex});
        }
    }
}

/// Whether some surface passes between the corners of a quadrilateral and the apex, for all that signs tell.
bool Certificate::is_mixed(const Facet& quad, LocalNode apex) const {
    for (std::size_t s = 0; s < cell_.surface_count(); ++s) {
        if (!cell_.is_named(s)) continue;
        Sides sides = cell_.sides(quad.node, 4, s);
        sides.add(cell_.sign(apex, s));
        if (sides.are_mixed()) return true;
    }
    return false;
}

LocalNode Certificate::add_cap(const Facet& quad, const LatticePoint& apex) {
    const std::size_t n = cell_.surface_count();
    LatticePoint middle{};
    for (std::size_t j = 0; j < 3; ++j) {
        std::int64_t sum = 0;
        for (int i = 0; i < 4; ++i)
            sum += std::clamp(cell_.nodes()[quad.node[i]].target[j], 0, cell_.units());
        middle[j] = static_cast<std::int32_t>(sum / 4);
    }
    double fraction = 0.3;
    for (int halving = 0;; ++halving, fraction *= 0.5) {
        LatticePoint at;
        for (std::size_t j = 0; j < 3; ++j) {
            at[j] = middle[j] + static_cast<std::int32_t>(std::rint(fraction * (apex[j] - middle[j])));
        }
        const LocalNode cap = cell_.add_node(at, 0);
        bool agrees = true;
        for (std::size_t s = 0; s < n; ++s) {
            if (!cell_.is_named(s)) continue;
            const int wanted = cell_.sides(quad.node, 4, s).sign();
            if (wanted == 0 || cell_.sign(cap, s) == wanted) continue;
            agrees = false;
            if (halving == kCapHalvings) cell_.set_sign(cap, s, wanted);
        }
        if (agrees || halving == kCapHalvings) {
            if (!agrees) ++cell_.counters.forced_caps;
            return cap;
        }
        cell_.remove_last_node();
    }
}

/// Whether a pyramid, which is not cut, has an edge from its apex.
bool Certificate::is_of_pyramid(LocalNode a, LocalNode b) const {
    return std::any_of(pyramids_.begin(), pyramids_.end(), [a, b](const Pyramid& pyramid) {
        const LocalNode* base = pyramid.node.data();
        const LocalNode* apex = base + 4;
        return (*apex == a && std::find(base, apex, b) != apex) ||
               (*apex == b && std::find(base, apex, a) != apex);
    });
}

/// Whether the signs that the simplex has for certain already tell its region: it need not be split then.
bool Certificate::is_resolved(const Simplex& simplex) {
    const std::size_t n = cell_.surface_count();
    signs_.resize(n);
    for (std::size_t s = 0; s < n; ++s) signs_[s] = cell_.sides(simplex.node.data(), 4, s).sign();
    return cell_.local_tape().resolve(signs_.data()) != kUnknown;
}

/// Lists in mixed_ the inner edges, with ends on different sides of surface p or on the same one, of
/// simplices that it cuts where that changes the region.
void Certificate::list_edges(std::size_t p, bool different) {
    mixed_.clear();
    for (Simplex& s : simplices_) {
        if (s.resolved) continue;
        if (!cell_.sides(s.node.data(), 4, p).are_mixed()) continue;
        s.resolved = is_resolved(s);
        if (s.resolved || !cell_.local_tape().depends_on(p, signs_.data())) continue;
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = i + 1; j < 4; ++j) {
                const LocalNode a = std::min(s.node[i], s.node[j]);
                const LocalNode b = std::max(s.node[i], s.node[j]);
                const int product = cell_.sign(a, p) * cell_.sign(b, p);
                if (different ? product >= 0 : product <= 0) continue;
                if ((cell_.nodes()[a].faces & cell_.nodes()[b].faces) != 0 || is_of_pyramid(a, b)) continue;
                if (!refused_.empty() && refused_.count({static_cast<std::uint32_t>(p), a, b}) != 0) continue;
                mixed_.push_back({a, b});
            }
        }
    }
    sort_unique(mixed_);
}

/// Lists in around_ the simplices at an edge; false if a node at `at` would make a part of one flat.
bool Certificate::can_split(LocalNode a, LocalNode b, const LatticePoint& at) {
    around_.clear();
    const auto& candidates = incident_[incident_[a].size() <= incident_[b].size() ? a : b];
    for (const std::uint32_t i : candidates) {
        const auto& v = simplices_[i].node;
        const auto ia = std::find(v.begin(), v.end(), a);
        const auto ib = std::find(v.begin(), v.end(), b);
        if (ia == v.end() || ib == v.end()) continue;
        around_.push_back(i);
        for (const auto replaced : {ia, ib}) {
            LatticePoint q[4];
            for (std::size_t j = 0; j < 4; ++j) q[j] = cell_.nodes()[v[j]].point;
            q[replaced - v.begin()] = at;
            if (!is_solid(q[0], q[1], q[2], q[3])) return false;
        }
    }
    return true;
}

/// Splits the simplices of can_split() at node m.
void Certificate::split(LocalNode a, LocalNode b, LocalNode m) {
    incident_.resize(cell_.nodes().size());
    for (const std::uint32_t i : around_) {
        // Where a surface is curved, m may lie on another side of it than a and b: nothing is resolved.
        simplices_[i].resolved = false;
        std::array<LocalNode, 4> second = simplices_[i].node;
        std::replace(simplices_[i].node.begin(), simplices_[i].node.end(), b, m);
        std::replace(second.begin(), second.end(), a, m);
        incident_[m].push_back(i);
        add_simplex(second);
    }
}

/// Whether the ends of an edge tell the sides of all surfaces but p at a point between them.
bool Certificate::is_told_by_ends(LocalNode a, LocalNode b, const LatticePoint& at, std::size_t p) const {
    for (std::size_t s = 0; s < cell_.surface_count(); ++s) {
        const int first = cell_.sign(a, s), second = cell_.sign(b, s);
        if (s == p || first * second < 0 || !cell_.is_named(s)) continue;
        if (cell_.pure_sign(s, at, cell_.size()) != (first != 0 ? first : second)) return false;
    }
    return true;
}

/// Whether a simplex of can_split() at an edge has a chord of surface p in a face of the cell opposite it,
/// with the surface on the edge's side of the chord, too: bulging between chord and edge is not shown in the
/// face, and what is shown of it at the edge alone would touch the chord from behind.
bool Certificate::is_hidden_by_chord(LocalNode a, LocalNode b, std::size_t p) const {
    return std::any_of(around_.begin(), around_.end(), [&](std::uint32_t i) {
        std::array<LocalNode, 2> end{};
        std::size_t count = 0;
        for (const LocalNode n : simplices_[i].node) {
            if (n != a && n != b) end[count++] = n;
        }
        if (cell_.sign(end[0], p) != 0 || cell_.sign(end[1], p) != 0) return false;
        const auto &first = cell_.nodes()[end[0]], &last = cell_.nodes()[end[1]];
        if ((first.faces & last.faces) == 0) return false;
        const LatticePoint middle = cell_.between(first.point, last.point, 0.5);
        return cell_.pure_sign(p, middle, cell_.size()) == -cell_.sign(a, p);
    });
}

/// Where surface p bulges through an edge whose ends lie on one side of it: in the middle, or else where its
/// value turns, if it reaches kLeastBulge there (less makes slivers of more parts than it mends). False if it
/// does neither.
bool Certificate::find_bulge(LocalNode a, LocalNode b, std::size_t p, LatticePoint* at) const {
    const LatticePoint &from = cell_.nodes()[a].point, &to = cell_.nodes()[b].point;
    const int other = -cell_.sign(a, p);
    *at = cell_.between(from, to, 0.5);
    if (cell_.pure_sign(p, *at, cell_.size()) == other) return true;
    *at = cell_.turning_point(p, from, to);
    return cell_.pure_sign(p, *at, cell_.size()) == other &&
           cell_.distance_to(p, *at) >= kLeastBulge * cell_.size();
}

/// Splits edges of simplices cut by surface order[k] whose ends lie on one side, where the surface bulges
/// through them: what is left in front of it would be a film. Not where another surface does so, too: the two
/// sides of a thin shell are chords of the same nodes, or it would have holes.
void Certificate::show_bulges(const std::vector<std::size_t>& order, std::size_t k, int round) {
    const std::size_t p = order[k];
    if (!cell_.is_curved(p)) return;
    list_edges(p, false);
    for (const auto& [a, b] : mixed_) {
        if (is_full()) return;
        if (distance(cell_.nodes()[a].point, cell_.nodes()[b].point) < kShortestBulge * cell_.units())
            continue;
        LatticePoint at;
        if (!find_bulge(a, b, p, &at) || !is_told_by_ends(a, b, at, p) || !can_split(a, b, at) ||
            is_hidden_by_chord(a, b, p))
            continue;
        const LocalNode m = cell_.split_node(order, k, a, b, at, round, nullptr);
        cell_.set_sign(m, p, -cell_.sign(a, p));
        split(a, b, m);
    }
}

/// Splits the inner edges of simplices that are mixed for surface order[k], where it changes the region;
/// tells whether there were any.
bool Certificate::bisect(const std::vector<std::size_t>& order, std::size_t k, int round) {
    keep_watch();  // a crowded cell may take seconds
    const std::size_t p = order[k];
    bool any = false;
    show_bulges(order, k, round);
    list_edges(p, true);
    for (const auto& [a, b] : mixed_) {
        if (cell_.sign(a, p) * cell_.sign(b, p) >= 0) continue;  // an end was snapped
        if (is_full()) {
            ++cell_.counters.limited;
            return false;
        }
        const LatticePoint at = cell_.root(p, cell_.nodes()[a].point, cell_.nodes()[b].point);
        if (cell_.snap_end(p, a, b, at, kMergeDistance, false)) {
            any = true;
            continue;
        }
        if (!can_split(a, b, at)) {
            if (!cell_.snap_end(p, a, b, at, kSnapDistance, false)) {
                ++cell_.counters.refused;
                refused_.insert({static_cast<std::uint32_t>(p), a, b});
            }
            continue;
        }
        const LocalNode m = cell_.split_node(order, k, a, b, at, round, nullptr);
        any = true;
        split(a, b, m);
    }
    return any;
}

/// The region of all corners of a simplex, if they alone tell it. Its edges are mixed then only on faces of
/// the cell where the surfaces are not active: nothing changes along them.
std::int32_t Certificate::common_region(const LocalNode* node, std::size_t count) {
    std::int32_t common = kUnknown;
    for (std::size_t i = 0; i < count; ++i) {
        const std::int32_t region = cell_.local_tape().resolve(cell_.signs(node[i]));
        if (region == kUnknown || (i > 0 && region != common)) return kUnknown;
        common = region;
    }
    return common;
}

/// Whether the samples inside a simplex all lie in a region.
bool Certificate::is_filled_by(std::int32_t region, const LocalNode* node, std::size_t count) {
    const std::size_t n = cell_.surface_count();
    signs_.resize(n);
    std::array<std::int64_t, 5> weight{};
    // All ways to give the corners weights of 1 at least, kSampleWeight in all: 35 for four and for five.
    const auto visit = [&](const auto& next, std::size_t corner, std::int64_t left) -> bool {
        if (corner + 1 < count) {
            const auto others = static_cast<std::int64_t>(count - corner) - 1;
            for (std::int64_t w = 1; w <= left - others; ++w) {
                weight[corner] = w;
                if (!next(next, corner + 1, left - w)) return false;
            }
            return true;
        }
        weight[corner] = left;
        LatticePoint at{};
        for (std::size_t j = 0; j < 3; ++j) {
            std::int64_t sum = 0;
            for (std::size_t i = 0; i < count; ++i) sum += weight[i] * cell_.nodes()[node[i]].point[j];
            at[j] = static_cast<std::int32_t>(sum / kSampleWeight);
        }
        for (std::size_t s = 0; s < n; ++s) signs_[s] = static_cast<std::int8_t>(cell_.value_sign(s, at));
        return cell_.local_tape().resolve(signs_.data()) == region;
    };
    return visit(visit, 0, kSampleWeight);
}

std::int32_t Certificate::label(const LocalNode* node, std::size_t count, std::int8_t* signs) {
    const std::size_t n = cell_.surface_count();
    LatticePoint centroid{};
    for (std::size_t j = 0; j < 3; ++j) {
        std::int64_t sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += cell_.nodes()[node[i]].point[j];
        centroid[j] = static_cast<std::int32_t>(sum / static_cast<std::int64_t>(count));
    }
    for (std::size_t s = 0; s < n; ++s) {
        const Sides sides = cell_.sides(node, count, s);
        const bool all_on = !sides.negative && !sides.positive;
        signs[s] = all_on ? static_cast<std::int8_t>(cell_.value_sign(s, centroid)) : sides.sign();
    }
    std::int32_t region = cell_.local_tape().resolve(signs);
    if (region != kUnknown) return region;
    region = is_full() ? kUnknown : common_region(node, count);
    if (region != kUnknown) return region;
    for (std::size_t s = 0; s < n; ++s) {
        if (signs[s] == 0) signs[s] = static_cast<std::int8_t>(cell_.value_sign(s, centroid));
    }
    region = cell_.local_tape().resolve(signs);
    if (is_full() || !is_filled_by(region, node, count)) ++cell_.counters.unresolved;
    return region;
}

}  // namespace mortise::cnio
