// Where a mesh hangs together by edges or nodes only: a solver sees hinges and loose parts there.
#include <algorithm>

#include "host/common/disjoint_sets.hpp"
#include "host/quality/passes.hpp"

namespace mortise::quality {
namespace {

/// A facet of the boundary at a node, and the two other ends of its edges there.
struct Corner {
    NodeId node;
    NodeId other[2];
    bool operator<(const Corner& c) const { return node < c.node; }
};

/// Whether the facets at a node, joined by edges, are several fans.
bool has_several_fans(const Corner* corners, std::size_t count) {
    DisjointSets sets(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = 0; j < i; ++j) {
            for (const NodeId a : corners[i].other) {
                for (const NodeId b : corners[j].other) {
                    if (a == b) sets.join(i, j);
                }
            }
        }
    }
    for (std::uint32_t i = 1; i < count; ++i) {
        if (sets.find(i) != 0) return true;
    }
    return false;
}

std::uint64_t count_hinges(const std::vector<BoundaryFacet>& boundary) {
    std::vector<Corner> corners;
    for (const BoundaryFacet& facet : boundary) {
        const int count = facet.count();
        for (int k = 0; k < count; ++k) {
            const NodeId before = facet.nodes[(k + count - 1) % count];
            const NodeId after = facet.nodes[(k + 1) % count];
            corners.push_back({facet.nodes[k], {before, after}});
        }
    }
    std::sort(corners.begin(), corners.end());
    std::uint64_t hinges = 0;
    for (std::size_t i = 0, j = 0; i < corners.size(); i = j) {
        while (j < corners.size() && corners[j].node == corners[i].node) ++j;
        hinges += has_several_fans(corners.data() + i, j - i) ? 1 : 0;
    }
    return hinges;
}

/// Parts of the mesh that share not even a node.
std::uint64_t count_parts(const Mesh& mesh) {
    DisjointSets sets(mesh.node_count());
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const std::vector<NodeId>& nodes = mesh.elements[t].nodes;
        const auto stride = static_cast<std::size_t>(kElementNodes[t]);
        for (std::size_t i = 0; i < nodes.size(); ++i) sets.join(nodes[i - i % stride], nodes[i]);
    }
    std::vector<std::uint8_t> used(mesh.node_count(), 0);
    for (const ElementBlock& block : mesh.elements) {
        for (const NodeId node : block.nodes) used[node] = 1;
    }
    std::uint64_t parts = 0;
    for (NodeId node = 0; node < mesh.node_count(); ++node) parts += used[node] != 0 && sets.is_first(node);
    return parts;
}

}  // namespace

void check_hinges(const Mesh& mesh, const std::vector<BoundaryFacet>& boundary, CheckReport& report) {
    report.nonmanifold_nodes = count_hinges(boundary);
    report.parts = count_parts(mesh);
}

}  // namespace mortise::quality
