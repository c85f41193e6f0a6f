// Decompositions without a new node; see tiling.hpp.
#include "host/templates/tiling.hpp"

#include <map>
#include <set>
#include <utility>

namespace mortise::templates {
namespace {

constexpr double kLeastShare = 0.95;  ///< of samples at which an element must be positive to be tried

/// All elements over the pattern's nodes that may occur in a decomposition.
class Pool {
  public:
    struct Entry {
        Element element;
        std::vector<std::uint32_t> facets;    // keys
        std::vector<std::uint32_t> opposite;  // keys of the reversed facets
        std::vector<NodeSet> facet_nodes;
        Series quality;
    };

    Pool(Pattern pattern, const std::vector<Positions>& positions)
        : pattern_(pattern), positions_(positions), nodes_(node_list(pattern_nodes(pattern))) {
        for (int f = 0; f < kFaces; ++f) {
            for (const Facet& facet : face_mesh(pattern, f)) face_facets_.insert(facet_key(facet));
        }
        find_quads();
        for (const NodeCode a : nodes_) {
            for (const NodeCode b : nodes_) {
                for (const NodeCode c : nodes_) {
                    for (const NodeCode d : nodes_) {
                        if (!(a < b && b < c && c < d)) continue;
                        offer({ElementType::kTetrahedron, {a, b, c, d}});
                        offer({ElementType::kTetrahedron, {a, c, b, d}});
                    }
                }
            }
        }
        for (const Facet& base : quads_) {
            const auto& q = base.nodes;
            for (const NodeCode apex : nodes_) offer({ElementType::kPyramid, {q[0], q[1], q[2], q[3], apex}});
            for (const Facet& top : quads_) {
                const auto& t = top.nodes;
                for (std::size_t r = 0; r < 4; ++r) {
                    // A top quad in the base's sense; each hexahedron once: its base holds the smallest node.
                    if ((node_set(top) & node_set(base)) != 0 || node_set(top) < node_set(base)) continue;
                    offer({ElementType::kHexahedron,
                           {q[0], q[1], q[2], q[3], t[r], t[(r + 1) % 4], t[(r + 2) % 4], t[(r + 3) % 4]}});
                }
            }
            // A wedge on side quad 0-1-4-3: the third quad-free edge is (2, 5).
            for (std::size_t r = 0; r < 4; ++r) {
                const NodeCode n0 = q[r], n1 = q[(r + 1) % 4], n4 = q[(r + 2) % 4], n3 = q[(r + 3) % 4];
                for (const NodeCode n2 : nodes_) {
                    for (const NodeCode n5 : nodes_) {
                        if (n2 > n0 && n2 > n1 && n2 != n5)
                            offer({ElementType::kWedge, {n0, n1, n2, n3, n4, n5}});
                    }
                }
            }
        }
    }

    const std::vector<Entry>& entries() const { return entries_; }
    const std::vector<int>& with_facet(std::uint32_t key) const {
        static const std::vector<int> none;
        const auto found = by_facet_.find(key);
        return found == by_facet_.end() ? none : found->second;
    }

  private:
    void find_quads() {
        for (const NodeCode a : nodes_) {
            for (const NodeCode b : nodes_) {
                for (const NodeCode c : nodes_) {
                    for (const NodeCode d : nodes_) {
                        if (a >= b || a >= c || a >= d || b == c || b == d || c == d) continue;
                        if (may_occur(quad(a, b, c, d)) || may_occur(quad(d, c, b, a)))
                            quads_.push_back(quad(a, b, c, d));
                    }
                }
            }
        }
    }

    bool may_occur(const Facet& facet) const {
        for (int f = 0; f < kFaces; ++f) {
            if ((node_set(facet) & ~face_nodes(f)) == 0) return face_facets_.count(facet_key(facet)) != 0;
        }
        return true;
    }

    void offer(const Element& element) {
        const int count = kElementNodes[static_cast<std::size_t>(element.type)];
        NodeSet used = 0;
        for (int i = 0; i < count; ++i) used |= 1U << element.nodes[static_cast<std::size_t>(i)];
        if (bits(used) != count) return;
        if (scaled_jacobian(element, positions_[0]) <= 0 || scaled_jacobian(element, positions_[1]) <= 0)
            return;
        Entry entry;
        entry.element = element;
        for (const Facet& facet : element_facets(element)) {
            if (!may_occur(facet)) return;
            entry.facets.push_back(facet_key(facet));
            entry.opposite.push_back(facet_key(reversed(facet)));
            entry.facet_nodes.push_back(node_set(facet));
        }
        const auto allowed = static_cast<int>((1 - kLeastShare) * static_cast<double>(positions_.size()));
        int failures = 0;
        for (const Positions& p : positions_) {
            append(entry.quality, element, p);
            if (entry.quality.jacobian.back() <= 0 && ++failures > allowed) return;
        }
        for (const std::uint32_t key : entry.facets)
            by_facet_[key].push_back(static_cast<int>(entries_.size()));
        entries_.push_back(std::move(entry));
    }

    Pattern pattern_;
    const std::vector<Positions>& positions_;
    std::vector<NodeCode> nodes_;
    std::vector<Facet> quads_;
    std::set<std::uint32_t> face_facets_;
    std::map<std::uint32_t, std::vector<int>> by_facet_;
    std::vector<Entry> entries_;
};

/// Exact cover of the boundary by pool elements, with branch and bound on the rank.
class Tiler {
  public:
    Tiler(const Pool& pool, std::size_t samples) : pool_(pool), all_good_(perfect(samples)) {}

    std::optional<Candidate> tile(const std::vector<Facet>& boundary, NodeSet cuts_in_plane) {
        best_.reset();
        open_.clear();
        used_.clear();
        chosen_.clear();
        cuts_in_plane_ = cuts_in_plane;
        for (const Facet& facet : boundary) open_.insert(facet_key(facet));
        extend(all_good_);
        return best_;
    }

  private:
    bool fits(const Pool::Entry& entry) const {
        for (std::size_t i = 0; i < entry.facets.size(); ++i) {
            const std::uint32_t key = entry.facets[i];
            if (open_.count(key) != 0) continue;
            // Taken by another element, or on the far side of an open facet.
            if (used_.count(key) != 0 || open_.count(entry.opposite[i]) != 0) return false;
            // A facet in the surface's plane must be one of the surface's facets.
            if ((entry.facet_nodes[i] & ~cuts_in_plane_) == 0) return false;
        }
        return true;
    }

    void extend(const Series& quality) {
        if (open_.empty()) {
            keep(quality);
            return;
        }
        // The open facet with the fewest elements that fit.
        std::vector<int> fitting;
        bool first = true;
        for (const std::uint32_t key : open_) {
            std::vector<int> here;
            for (const int e : pool_.with_facet(key)) {
                if (fits(pool_.entries()[static_cast<std::size_t>(e)])) here.push_back(e);
            }
            if (here.empty()) return;
            if (first || here.size() < fitting.size()) fitting = std::move(here);
            first = false;
        }
        for (const int e : fitting) {
            const Pool::Entry& entry = pool_.entries()[static_cast<std::size_t>(e)];
            Series next = quality;
            lower(next, entry.quality);
            if (is_hopeless(next)) continue;
            const auto open_before = open_;
            const auto used_before = used_;
            for (std::size_t i = 0; i < entry.facets.size(); ++i) {
                used_.insert(entry.facets[i]);
                if (open_.erase(entry.facets[i]) == 0) open_.insert(entry.opposite[i]);
            }
            chosen_.push_back(e);
            extend(next);
            chosen_.pop_back();
            open_ = open_before;
            used_ = used_before;
        }
    }

    bool is_hopeless(const Series& quality) const {
        return best_ && !(best_->rank < rank_of(quality, chosen_.size() + 1));
    }

    void keep(const Series& quality) {
        Candidate candidate;
        candidate.rank = rank_of(quality, chosen_.size());
        if (best_ && !(best_->rank < candidate.rank)) return;
        for (const int e : chosen_) {
            candidate.elements.push_back(pool_.entries()[static_cast<std::size_t>(e)].element);
        }
        best_ = std::move(candidate);
    }

    const Pool& pool_;
    Series all_good_;
    std::optional<Candidate> best_;
    std::set<std::uint32_t> open_;
    std::set<std::uint32_t> used_;  // facets of chosen elements
    std::vector<int> chosen_;
    NodeSet cuts_in_plane_ = 0;
};

}  // namespace

std::vector<std::optional<Candidate>> best_tilings(Pattern pattern, bool planar_surface,
                                                   const std::vector<std::vector<Facet>>& boundaries,
                                                   const std::vector<Positions>& positions) {
    const Pool pool(pattern, positions);
    Tiler tiler(pool, positions.size());
    NodeSet cuts_in_plane = 0;
    if (planar_surface) {
        for (const NodeCode cut : surface_loop(pattern)) cuts_in_plane |= 1U << cut;
    }
    std::vector<std::optional<Candidate>> best;
    for (const auto& boundary : boundaries) best.push_back(tiler.tile(boundary, cuts_in_plane));
    return best;
}

}  // namespace mortise::templates
