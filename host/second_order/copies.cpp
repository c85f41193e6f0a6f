#include "host/second_order/copies.hpp"

#include <algorithm>
#include <map>

#include "host/common/periodic_originals.hpp"

namespace mortise::second_order {
namespace {

std::size_t axis_of(const PeriodicNodes& pair) {
    return static_cast<std::size_t>(
        std::find_if(pair.shift.begin(), pair.shift.end(), [](double along) { return along != 0; }) -
        pair.shift.begin());
}

}  // namespace

std::vector<EdgeCopy> find_edge_copies(const Mesh& mesh, const Edges& edges) {
    std::vector<EdgeCopy> copies;
    for (std::size_t pair = 0; pair < mesh.periodic.size(); ++pair) {
        const std::vector<NodeId> original = originals_of(mesh.periodic[pair], mesh.node_count());
        edges.visit(0, mesh.node_count(), [&](std::size_t edge, NodeId a, NodeId b) {
            if (original[a] == kNoOriginal || original[b] == kNoOriginal) return;
            const std::size_t image = edges.find(original[a], original[b]);
            if (image != edges.size()) copies.push_back({edge, image, pair});
        });
    }
    return copies;
}

void copy_curves(const Mesh& mesh, const std::vector<EdgeCopy>& copies, std::vector<CurvedEdge>& curved) {
    if (copies.empty()) return;
    std::map<std::size_t, Vec3> displacement;  // by edge
    for (const CurvedEdge& edge : curved) displacement[edge.edge] = edge.displacement;
    // An original may be a copy across another axis, whose turn comes later.
    for (std::size_t round = 0; round < mesh.periodic.size(); ++round) {
        for (const EdgeCopy& edge : copies) {
            const auto original = displacement.find(edge.original);
            if (original == displacement.end()) {
                displacement.erase(edge.copy);
                continue;
            }
            original->second[axis_of(mesh.periodic[edge.pair])] = 0;
            displacement[edge.copy] = original->second;
        }
    }
    curved.clear();
    for (const auto& [edge, moved] : displacement) curved.push_back({edge, moved});
}

void pair_middles(const std::vector<EdgeCopy>& copies, std::size_t corners, Mesh& mesh) {
    for (const EdgeCopy& edge : copies) {
        mesh.periodic[edge.pair].node.push_back(static_cast<NodeId>(corners + edge.copy));
        mesh.periodic[edge.pair].original.push_back(static_cast<NodeId>(corners + edge.original));
    }
}

}  // namespace mortise::second_order
