#include "host/layers/fit.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <numeric>

#include "host/common/element_jacobian.hpp"
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/vec3.hpp"
#include "host/layers/cuts.hpp"
#include "host/layers/moves.hpp"
#include "host/layers/stack.hpp"

namespace mortise::layers {
namespace {

/// Heights become lower by this factor, and end at the least share of the full height, or of an edge of the
/// wall if that is less; from node to node they rise by no more than the slope.
constexpr double kLower = 0.6, kLeastShare = 0.05, kSlope = 0.15;

/// Scaled Jacobians: elements may lose some of theirs, or all above what is good; those in layers, and parts
/// of cut ones, have at least so much; where layers narrow to nothing theirs is their height to their length.
constexpr double kKept = 0.5, kGood = 0.2, kLeastInLayer = 0.03, kLeastNarrow = 1e-5;

class Fitting {
  public:
    Fitting(const Mesh& mesh, const Walls& walls, const Band& band, const Slides& slides,
            const Growth& growth, const Heights& heights, int threads)
        : mesh_(mesh),
          walls_(walls),
          band_(band),
          slides_(slides),
          growth_(growth),
          heights_(heights),
          threads_(threads),
          moves_(band, slides, growth, threads),
          is_blamed_(new std::atomic<bool>[band.node.size()]),
          is_active_(band.node.size()) {
        fit_.share.assign(wall_nodes(), 1.0);
        for (std::size_t i = 0; i < wall_nodes(); ++i) {
            if (walls.is_bare[i] != 0) fit_.share[i] = 0;
        }
        for (const NodeId node : band.node) fit_.inner.push_back(point_of(mesh, node));
        fit_.between.resize(wall_nodes() * levels());
        for (int k = 1; k < heights.count; ++k) part_.push_back(heights.share(k));
        clear_blame();
    }

    Fit run() {
        std::vector<std::uint32_t> changed(band_.node.size());
        std::iota(changed.begin(), changed.end(), 0u);
        while (!changed.empty()) {
            level_out(changed);
            const std::vector<std::uint32_t> active = around(changed);
            moves_.solve(fit_.share, active);
            place_nodes(active);
            look_at_elements();
            look_at_stacks();
            changed = lower(kLower);
            if (changed.empty()) {
                look_at_cuts();
                changed = lower(0);
            }
            if (changed.empty() && active.size() < band_.node.size()) changed = look_at_all();
        }
        return std::move(fit_);
    }

  private:
    std::size_t wall_nodes() const { return walls_.nodes.size(); }
    std::size_t levels() const { return static_cast<std::size_t>(heights_.count) - 1; }

    void clear_blame() {
        for (std::size_t s = 0; s < band_.node.size(); ++s)
            is_blamed_[s].store(false, std::memory_order_relaxed);
    }
    void blame(std::size_t slot) { is_blamed_[slot].store(true, std::memory_order_relaxed); }
    bool is_blamed(std::size_t slot) const { return is_blamed_[slot].load(std::memory_order_relaxed); }

    double least_share(std::size_t place) const {
        return kLeastShare * std::min(1.0, growth_.edges[place] / growth_.height[place]);
    }
    void set_share(std::size_t place, double share) {
        fit_.share[place] = share < least_share(place) ? 0 : share;
    }

    /// Lowers layers at the walls nearest to blamed nodes, or if none of these has any, freezes the nodes.
    /// Returns what has changed: slots, ascending.
    std::vector<std::uint32_t> lower(double factor) {
        std::vector<std::uint32_t> behind, changed;
        for (std::size_t s = wall_nodes(); s < band_.node.size(); ++s) {
            if (is_blamed(s)) behind.push_back(static_cast<std::uint32_t>(s));
        }
        for (std::size_t r = band_.ring.size() - 2; r > 0; --r) {
            for (std::size_t s = band_.ring[r]; s < band_.ring[r + 1]; ++s) {
                if (!is_blamed(s)) continue;
                for (const std::uint32_t other : band_.neighbours[s]) {
                    if (other < band_.ring[r] && other >= band_.ring[r - 1]) blame(other);
                }
            }
        }
        for (std::size_t i = 0; i < wall_nodes(); ++i) {
            if (!is_blamed(i) || fit_.share[i] == 0) continue;
            set_share(i, factor * fit_.share[i]);
            changed.push_back(static_cast<std::uint32_t>(i));
        }
        if (changed.empty()) {
            for (const std::uint32_t s : behind) {
                if (squared_length(moves_.all()[s]) == 0) continue;
                moves_.freeze(s);
                changed.push_back(s);
            }
        } else {
            // Walls far from some of these may be all that was lowered; they are looked at again, too.
            changed.insert(changed.end(), behind.begin(), behind.end());
        }
        clear_blame();
        return changed;
    }

    /// From node to node of the walls heights rise by the slope at most; adds the walls where they did by
    /// more.

    void level_out(std::vector<std::uint32_t>& changed) {
        for (std::size_t i = 0; i < changed.size(); ++i) {
            if (changed[i] >= wall_nodes()) continue;
            const double share = fit_.share[changed[i]];
            const Vec3 at = point_of(mesh_, walls_.nodes[changed[i]]);
            for (const std::uint32_t other : band_.neighbours[changed[i]]) {
                if (other >= wall_nodes() || fit_.share[other] <= share) continue;
                const double apart = length(difference(point_of(mesh_, walls_.nodes[other]), at));
                const double most =
                    std::max(least_share(other), share + kSlope * apart / length(growth_.reach[other]));
                if (fit_.share[other] <= most) continue;
                set_share(other, most);
                changed.push_back(other);
            }
        }
    }

    /// Slots whose moves depend on those of others, ascending; marks them.
    std::vector<std::uint32_t> around(std::vector<std::uint32_t> slots) {
        std::fill(is_active_.begin(), is_active_.end(), std::uint8_t{0});
        for (const std::uint32_t s : slots) is_active_[s] = 1;
        std::size_t begin = 0;
        for (std::size_t ring = 1; ring < band_.ring.size(); ++ring) {
            const std::size_t end = slots.size();
            for (; begin < end; ++begin) {
                for (const std::uint32_t other : band_.neighbours[slots[begin]]) {
                    if (is_active_[other] != 0) continue;
                    is_active_[other] = 1;
                    slots.push_back(other);
                }
            }
        }
        sort_unique(slots);
        return slots;
    }

    /// Blames those that do not find back to their surfaces.
    void place_nodes(const std::vector<std::uint32_t>& active) {
        parallel_chunks(active.size(), kNodeChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t s = active[i];
                const NodeId node = band_.node[s];
                const Vec3& move = moves_.all()[s];
                bool found = slides_.place(node, move, fit_.inner[s]);
                for (std::size_t k = 0; s < wall_nodes() && k < levels(); ++k) {
                    const Vec3 part = scaled(move, part_[k]);
                    found = slides_.place(node, part, fit_.between[levels() * s + k]) && found;
                }
                if (!found) blame(s);
            }
        });
    }

    Vec3 inner_point(NodeId node) const {
        const std::uint32_t slot = band_.slot[node];
        return slot == kNoSlot ? point_of(mesh_, node) : fit_.inner[slot];
    }

    void look_at_elements() {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const auto type = static_cast<ElementType>(t);
            const auto count = nodes_per(type);
            const std::vector<std::uint32_t>& list = band_.elements[t];
            parallel_chunks(
                list.size(), kElementChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t e = begin; e < end; ++e)
                        look_at_element(type, mesh_.block(type).nodes.data() + count * list[e], count);
                });
        }
    }

    /// Nothing may have been forgotten.
    std::vector<std::uint32_t> look_at_all() {
        std::fill(is_active_.begin(), is_active_.end(), std::uint8_t{1});
        look_at_elements();
        look_at_stacks();
        return lower(kLower);
    }

    void look_at_element(ElementType type, const NodeId* node, std::size_t count) {
        const auto moves = [&](NodeId n) {
            const std::uint32_t slot = band_.slot[n];
            return slot != kNoSlot && is_active_[slot] != 0;
        };
        if (std::none_of(node, node + count, moves)) return;
        std::array<Vec3, 8> before{}, after{};
        for (std::size_t k = 0; k < count; ++k) {
            before[k] = point_of(mesh_, node[k]);
            after[k] = inner_point(node[k]);
        }
        if (after == before) return;  // valid, whatever bounds say
        const double least = least_scaled_jacobian(type, after.data());
        if (least >= kGood && least_straight_jacobian(type, after.data()) > 0) return;
        const double wanted = std::min(kGood, kKept * least_scaled_jacobian(type, before.data()));
        if (least >= wanted && least_straight_jacobian(type, after.data()) > 0) return;
        for (std::size_t k = 0; k < count; ++k) {
            if (band_.slot[node[k]] != kNoSlot) blame(band_.slot[node[k]]);
        }
    }

    std::vector<std::uint8_t> bare_nodes() const {
        std::vector<std::uint8_t> is_bare(wall_nodes());
        for (std::size_t i = 0; i < is_bare.size(); ++i) is_bare[i] = fit_.share[i] == 0;
        return is_bare;
    }

    void look_at_stacks() {
        const std::vector<std::uint8_t> is_bare = bare_nodes();
        const auto point = [&](const WallFacet& facet, const StackNode& node) {
            const std::size_t place = walls_.place[facet.node[node.corner]];
            if (node.layer == 0) return point_of(mesh_, facet.node[node.corner]);
            return node.layer == heights_.count
                       ? fit_.inner[place]
                       : fit_.between[levels() * place + static_cast<std::size_t>(node.layer) - 1];
        };
        parallel_chunks(
            walls_.facets.size(), kElementChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t f = begin; f < end; ++f) {
                    const WallFacet& facet = walls_.facets[f];
                    const auto changes = [&](NodeId n) { return is_active_[walls_.place[n]] != 0; };
                    if (std::none_of(facet.node.begin(), facet.node.end(), changes)) continue;
                    const BareCorners bare = bare_corners(facet, walls_.place, is_bare);
                    const double least = bare == BareCorners{} ? kLeastInLayer : kLeastNarrow;
                    bool is_valid = true;
                    for_stack(facet, bare, heights_.count, [&](ElementType type, const StackNodes& nodes) {
                        std::array<Vec3, 8> points;
                        const auto count = nodes_per(type);
                        for (std::size_t k = 0; k < count; ++k) points[k] = point(facet, nodes[k]);
                        is_valid = is_valid && is_good_enough(type, points.data(), least);
                    });
                    if (is_valid) continue;
                    for (const NodeId node : facet.node) blame(walls_.place[node]);
                }
            });
    }

    static bool is_good_enough(ElementType type, const Vec3* points, double least) {
        return least_straight_jacobian(type, points) > 0 && least_scaled_jacobian(type, points) >= least;
    }

    /// Blames the nodes of faces that cannot be cut.
    void look_at_cuts() {
        const std::vector<CutFace> faces = find_cut_faces(walls_, bare_nodes());
        for (const std::uint32_t facet : find_folded_cuts(mesh_, walls_, faces)) {
            for (const NodeId node : walls_.facets[facet].node) blame(walls_.place[node]);
        }
        for (const CutElement& element : find_cut_elements(mesh_, faces, threads_)) {
            const ElementBlock& block = mesh_.block(element.type);
            const auto count = nodes_per(element.type);
            const NodeId* const node = block.nodes.data() + count * element.index;
            const bool moves = walls_.has_layers[block.region[element.index]] != 0;
            std::array<Vec3, 8> corner;
            Vec3 centre{};
            for (std::size_t k = 0; k < count; ++k) {
                corner[k] = moves ? inner_point(node[k]) : point_of(mesh_, node[k]);
                centre = sum(centre, scaled(corner[k], 1 / static_cast<double>(count)));
            }
            bool is_valid = true;
            for (const CutPart& part : cut_element(element.type, node, faces)) {
                std::array<Vec3, 5> points;
                for (std::size_t k = 0; k < 5; ++k)
                    points[k] =
                        part.node[k] == kCentre ? centre : corner[static_cast<std::size_t>(part.node[k])];
                is_valid = is_valid && is_good_enough(part.type, points.data(), kLeastInLayer);
            }
            if (is_valid) continue;
            for (std::size_t k = 0; k < count; ++k) {
                const std::uint32_t place = walls_.place[node[k]];
                if (place != kNoWallNode) blame(place);
            }
        }
    }

    const Mesh& mesh_;
    const Walls& walls_;
    const Band& band_;
    const Slides& slides_;
    const Growth& growth_;
    const Heights& heights_;
    const int threads_;
    std::vector<double> part_;  ///< of all layers' height, after each but the last
    Moves moves_;
    Fit fit_;
    std::unique_ptr<std::atomic<bool>[]> is_blamed_;  ///< by slot
    std::vector<std::uint8_t> is_active_;             ///< by slot: has moved anew
};

}  // namespace

Fit fit_layers(const Mesh& mesh, const Walls& walls, const Band& band, const Slides& slides,
               const Growth& growth, const Heights& heights, int threads) {
    return Fitting(mesh, walls, band, slides, growth, heights, threads).run();
}

}  // namespace mortise::layers
