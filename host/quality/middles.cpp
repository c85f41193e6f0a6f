// Nodes in the middles of edges, of meshes of second order: one for each edge, and for nothing else.
#include <algorithm>
#include <atomic>
#include <memory>

#include "host/common/parallel.hpp"
#include "host/quality/passes.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kMiddleChunk = 16384;

std::string edge_text(std::uint64_t ends, const Mesh& mesh) {
    const auto a = static_cast<NodeId>(ends >> 32), b = static_cast<NodeId>(ends);
    return "edge (" + std::to_string(a) + ", " + std::to_string(b) + ") at " + point_text(mesh, a);
}

/// The edges that nodes are in the middle of, as elements tell.
class Ends {
  public:
    Ends(const Mesh& mesh, int threads)
        : mesh_(mesh), threads_(threads), of_node_(new std::atomic<std::uint64_t>[mesh.node_count()]()) {}

    void add_elements(DefectLog& log) {
        for (int t = 0; t < kElementTypes; ++t) {
            const auto type = static_cast<ElementType>(t);
            const ElementBlock& block = mesh_.block(type);
            std::vector<DefectLog> logs(chunk_count(block.size(), kMiddleChunk));
            parallel_numbered(block.size(), kMiddleChunk, threads_,
                              [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                                  for (std::size_t i = begin; i < end; ++i) add_element(type, i, logs[chunk]);
                              });
            for (const DefectLog& part : logs) log.merge(part);
        }
    }

    /// Nodes that are in the middle of an edge and a corner, and edges with several middles.
    std::vector<EdgeMiddle> list(DefectLog& log) const {
        std::vector<bool> is_corner(mesh_.node_count(), false);
        for (const ElementBlock& block : mesh_.elements) {
            for (const NodeId node : block.nodes) is_corner[node] = true;
        }
        std::vector<EdgeMiddle> middles;
        for (std::size_t n = 0; n < mesh_.node_count(); ++n) {
            const std::uint64_t ends = of_node_[n];
            if (ends == kNoEdge) continue;
            middles.push_back({ends, static_cast<NodeId>(n)});
            if (is_corner[n])
                log.add(DefectKind::kMiddleShared, [&] {
                    return "node " + std::to_string(n) + " at " + point_text(mesh_, middles.back().node) +
                           ", a corner of an element, too";
                });
        }
        std::sort(middles.begin(), middles.end());
        for (std::size_t i = 1; i < middles.size(); ++i) {
            if (middles[i].ends == middles[i - 1].ends)
                log.add(DefectKind::kMiddleTwice, [&] { return edge_text(middles[i].ends, mesh_); });
        }
        return middles;
    }

    void check_facets(DefectLog& log) const {
        const FacetBlock& facets = mesh_.facets;
        for (std::size_t f = 0; f < facets.size(); ++f) {
            const FacetNodes node = facets.facet(f);
            for (std::size_t k = 0; k < node.size(); ++k) {
                if (of_node_[facets.middles[4 * f + k]] == edge_ends(node[k], node.after(k))) continue;
                log.add(DefectKind::kListedMiddle,
                        [&] { return facet_text(mesh_, node.begin(), static_cast<int>(node.size())); });
                break;
            }
        }
    }

  private:
    static constexpr std::uint64_t kNoEdge = 0;  // no edge has node 0 at both ends

    void add_element(ElementType type, std::size_t i, DefectLog& log) {
        const LocalEdges edges = local_edges(type);
        const ElementBlock& block = mesh_.block(type);
        const auto corners = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
        for (int e = 0; e < edges.count; ++e) {
            const NodeId* const node = block.nodes.data() + corners * i;
            const std::uint64_t ends = edge_ends(node[edges.edges[e][0]], node[edges.edges[e][1]]);
            const NodeId middle =
                block.middles[static_cast<std::size_t>(edges.count) * i + static_cast<std::size_t>(e)];
            std::uint64_t found = kNoEdge;
            if (!of_node_[middle].compare_exchange_strong(found, ends) && found != ends)
                log.add(DefectKind::kMiddleShared, [&] {
                    return "node " + std::to_string(middle) + " at " + point_text(mesh_, middle) +
                           ", of another edge, too";
                });
        }
    }

    const Mesh& mesh_;
    const int threads_;
    std::unique_ptr<std::atomic<std::uint64_t>[]> of_node_;
};

}  // namespace

std::vector<EdgeMiddle> check_middles(const Mesh& mesh, int threads, DefectLog& log) {
    if (!mesh.is_second_order()) return {};
    Ends ends(mesh, threads);
    ends.add_elements(log);
    ends.check_facets(log);
    return ends.list(log);
}

}  // namespace mortise::quality
