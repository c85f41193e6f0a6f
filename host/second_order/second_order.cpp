#include "host/second_order/second_order.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>

#include "host/common/element_jacobian.hpp"
#include "host/common/index_set.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"
#include "host/second_order/copies.hpp"
#include "host/second_order/curves.hpp"
#include "host/second_order/edges.hpp"
#include "host/second_order/jacobian_bound.hpp"

namespace mortise::second_order {
namespace {

constexpr std::size_t kChunk = 4096;
constexpr std::uint8_t kMostHalvings = 4;  ///< then an edge is straight

/// The Jacobian of a curved element is at least this much of the least one of the element with straight
/// edges.
constexpr double kLeastShare = 0.2;

constexpr std::uint8_t kCrease = 1, kFace = 2, kRegion = 3;  ///< see Features::model_dimension

/// Numbers the nodes in the middles of all edges, of elements and facets.
void set_middles(Mesh& mesh, const Edges& edges, std::size_t corners, int threads) {
    const auto middle = [&](NodeId a, NodeId b) { return static_cast<NodeId>(corners + edges.number(a, b)); };
    for (int t = 0; t < kElementTypes; ++t) {
        ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        const LocalEdges local = local_edges(static_cast<ElementType>(t));
        const auto nodes = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        const auto count = static_cast<std::size_t>(local.count);
        resize_large(block.middles, count * block.size(), threads);
        parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                const NodeId* const node = block.nodes.data() + nodes * i;
                for (std::size_t e = 0; e < count; ++e)
                    block.middles[count * i + e] = middle(node[local.edges[e][0]], node[local.edges[e][1]]);
            }
        });
    }
    FacetBlock& facets = mesh.facets;
    facets.middles.resize(4 * facets.size());
    parallel_chunks(facets.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t f = begin; f < end; ++f) {
            for_sides(facets, f,
                      [&](std::size_t k, NodeId a, NodeId b) { facets.middles[4 * f + k] = middle(a, b); });
        }
    });
}

/// Puts the middle of every edge half-way between its ends.
void place_middles(Mesh& mesh, const Edges& edges, std::size_t corners, int threads) {
    resize_large(mesh.points, 3 * (corners + edges.size()), threads);
    double* const points = mesh.points.data();
    parallel_chunks(corners, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        edges.visit(begin, end, [&](std::size_t edge, NodeId a, NodeId b) {
            for (std::size_t j = 0; j < 3; ++j)
                points[3 * (corners + edge) + j] =
                    0.5 * points[3 * std::size_t{a} + j] + 0.5 * points[3 * std::size_t{b} + j];
        });
    });
}

/// Straightens edges until every element is valid.
class Relaxation {
  public:
    Relaxation(const Mesh& mesh, const std::vector<CurvedEdge>& curved, const std::vector<EdgeCopy>& copies,
               std::size_t corners, std::size_t edges, int threads)
        : mesh_(mesh), curved_(curved), corners_(corners), is_curved_(edges), threads_(threads) {
        for (const CurvedEdge& c : curved) is_curved_.insert(c.edge);
        is_curved_.number();
        halvings_.assign(curved.size(), 0);
        for (const EdgeCopy& edge : copies) {
            if (is_curved_.holds(edge.copy) && is_curved_.holds(edge.original))
                twins_.emplace_back(is_curved_.place(edge.copy), is_curved_.place(edge.original));
        }
        find_elements();
    }

    void run() {
        using Marks = std::unique_ptr<std::atomic<bool>[]>;
        Marks blamed(new std::atomic<bool>[curved_.size()]), changed(new std::atomic<bool>[curved_.size()]);
        for (std::size_t i = 0; i < curved_.size(); ++i) changed[i] = true;
        for (std::atomic<bool> any{true}; any; std::swap(blamed, changed)) {
            any = false;
            for (std::size_t i = 0; i < curved_.size(); ++i) blamed[i] = false;
            for_elements([&](const ElementNumber& element) {
                // What was valid may not be so any more, even if its edges are straighter.
                bool is_new = false;
                for_curved(element,
                           [&](std::size_t, std::size_t place) { is_new = is_new || changed[place]; });
                if (!is_new || is_valid(element)) return;
                any = true;
                for_curved(element, [&](std::size_t, std::size_t place) { blamed[place] = true; });
            });
            for (std::size_t i = 0; i < curved_.size(); ++i) {
                if (blamed[i] && halvings_[i] < kMostHalvings) ++halvings_[i];
            }
            while (level_twins(blamed.get())) continue;
        }
    }

    /// Of the i-th curved edge.
    Vec3 displacement(std::size_t i) const {
        if (halvings_[i] == kMostHalvings) return {};
        return scaled(curved_[i].displacement, std::ldexp(1.0, -int{halvings_[i]}));
    }
    bool is_relaxed(std::size_t i) const { return halvings_[i] > 0; }

  private:
    struct ElementNumber {
        ElementType type;
        std::uint32_t index;
    };

    /// Calls visit(local edge, place among the curved ones).
    template <class Visit>
    void for_curved(const ElementNumber& element, const Visit& visit) const {
        const auto count = static_cast<std::size_t>(kElementEdges[static_cast<std::size_t>(element.type)]);
        const NodeId* const middle = mesh_.block(element.type).middles.data() + count * element.index;
        for (std::size_t e = 0; e < count; ++e) {
            const std::size_t edge = middle[e] - corners_;
            if (is_curved_.holds(edge)) visit(e, is_curved_.place(edge));
        }
    }

    template <class Work>
    void for_elements(const Work& work) const {
        parallel_chunks(elements_.size(), kChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) work(elements_[i]);
        });
    }

    /// Those with a curved edge.
    void find_elements() {
        for (int t = 0; t < kElementTypes; ++t) {
            const auto type = static_cast<ElementType>(t);
            const std::size_t count = mesh_.block(type).size();
            std::vector<std::vector<ElementNumber>> parts(chunk_count(count, kChunk));
            parallel_chunks(count, kChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    const ElementNumber element = {type, static_cast<std::uint32_t>(i)};
                    bool any = false;
                    for_curved(element, [&](std::size_t, std::size_t) { any = true; });
                    if (any) parts[begin / kChunk].push_back(element);
                }
            });
            for (const auto& part : parts) elements_.insert(elements_.end(), part.begin(), part.end());
        }
    }

    /// Copies stay as straight as their originals: the straighter of the two is both's. Whether any became
    /// straighter, which `blamed` learns.
    bool level_twins(std::atomic<bool>* blamed) {
        bool any = false;
        for (const auto& [a, b] : twins_) {
            if (halvings_[a] == halvings_[b]) continue;
            blamed[halvings_[a] < halvings_[b] ? a : b] = any = true;
            halvings_[a] = halvings_[b] = std::max(halvings_[a], halvings_[b]);
        }
        return any;
    }

    bool is_valid(const ElementNumber& element) const {
        std::array<Vec3, 12> displacements{};
        bool any = false;
        for_curved(element, [&](std::size_t e, std::size_t place) {
            displacements[e] = displacement(place);
            any = any || halvings_[place] < kMostHalvings;
        });
        if (!any) return true;
        const auto count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(element.type)]);
        const NodeId* const node = mesh_.block(element.type).nodes.data() + count * element.index;
        std::array<Vec3, 8> corners{};
        for (std::size_t n = 0; n < count; ++n) {
            const double* const p = mesh_.points.data() + 3 * std::size_t{node[n]};
            corners[n] = {p[0], p[1], p[2]};
        }
        if (element.type == ElementType::kTetrahedron &&
            is_surely_valid(corners.data(), displacements.data(), kLeastShare))
            return true;
        const double straight = least_straight_jacobian(element.type, corners.data());
        return straight > 0 &&
               least_jacobian(element.type, corners.data(), displacements.data()) >= kLeastShare * straight;
    }

    const Mesh& mesh_;
    const std::vector<CurvedEdge>& curved_;
    const std::size_t corners_;
    IndexSet is_curved_;  ///< by edge
    const int threads_;
    std::vector<std::uint8_t> halvings_;                      ///< by curved edge
    std::vector<std::pair<std::size_t, std::size_t>> twins_;  ///< curved edges, copy and original
    std::vector<ElementNumber> elements_;
};

/// Gives the new nodes their dimensions.
void set_dimensions(const Mesh& mesh, const Edges& edges, std::size_t corners, Features& features) {
    std::vector<std::uint8_t>& dimension = features.model_dimension;
    dimension.resize(corners + edges.size(), kRegion);
    for (const NodeId node : mesh.facets.middles) dimension[node] = kFace;
    for (const FeatureCurve& curve : features.curves) {
        const std::size_t count = curve.nodes.size();
        for (std::size_t i = 0; i + (curve.closed ? 0 : 1) < count; ++i)
            dimension[corners + edges.number(curve.nodes[i], curve.nodes[(i + 1) % count])] = kCrease;
    }
}

}  // namespace

Counts raise_order(Mesh& mesh, const std::vector<std::uint32_t>& facet_surface, const tape::BoundModel& model,
                   Features& features, int threads) {
    const std::size_t corners = mesh.node_count();
    const Edges edges(mesh, threads);
    std::vector<CurvedEdge> curved = find_curved_edges(mesh, facet_surface, model, edges, threads);
    const std::vector<EdgeCopy> copies = find_edge_copies(mesh, edges);
    copy_curves(mesh, copies, curved);
    set_middles(mesh, edges, corners, threads);
    Relaxation relaxation(mesh, curved, copies, corners, edges.size(), threads);
    relaxation.run();
    place_middles(mesh, edges, corners, threads);
    Counts counts;
    counts.nodes = edges.size();
    for (std::size_t i = 0; i < curved.size(); ++i) {
        const Vec3 moved = relaxation.displacement(i);
        double* const point = mesh.points.data() + 3 * (corners + curved[i].edge);
        for (std::size_t j = 0; j < 3; ++j) point[j] += moved[j];
        counts.curved += squared_length(moved) > 0;
        counts.relaxed += relaxation.is_relaxed(i);
    }
    pair_middles(copies, corners, mesh);
    set_dimensions(mesh, edges, corners, features);
    mesh.model_dimension = features.model_dimension;
    return counts;
}

}  // namespace mortise::second_order
