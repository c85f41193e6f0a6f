#include "host/layers/band.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/vec3.hpp"
#include "host/layers/slides.hpp"

namespace mortise::layers {
namespace {

constexpr int kFewestRings = 3, kMostRings = 12;
constexpr double kRingsPerEdge = 2;  ///< for layers that reach as far as an edge is long

constexpr std::uint8_t kFar = 255, kFixed = 254;

using Rings = std::unique_ptr<std::atomic<std::uint8_t>[]>;

/// Calls work(type, begin, end) for chunks of all elements, by several threads.
template <class Work>
void for_element_chunks(const Mesh& mesh, int threads, const Work& work) {
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        parallel_chunks(mesh.block(type).size(), kElementChunk, threads,
                        [&](std::size_t begin, std::size_t end, int) { work(type, begin, end); });
    }
}

struct ElementNodes {
    const NodeId* first;
    const NodeId* last;
    const NodeId* begin() const { return first; }
    const NodeId* end() const { return last; }
};

ElementNodes nodes_of(const Mesh& mesh, ElementType type, std::size_t i) {
    const auto count = nodes_per(type);
    const NodeId* const first = mesh.block(type).nodes.data() + count * i;
    return {first, first + count};
}

/// By node: how many elements away from the wall it is; kFixed: at an element without layers; kFar:
/// farther. Whoever writes first writes what others would.
Rings find_rings(const Mesh& mesh, const Walls& walls, int rings, int threads) {
    Rings ring(new std::atomic<std::uint8_t>[mesh.node_count()]);
    for (std::size_t n = 0; n < mesh.node_count(); ++n) ring[n].store(kFar, std::memory_order_relaxed);
    const auto set = [&](NodeId node, int value) {
        ring[node].store(static_cast<std::uint8_t>(value), std::memory_order_relaxed);
    };
    for_element_chunks(mesh, threads, [&](ElementType type, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (walls.has_layers[mesh.block(type).region[i]] != 0) continue;
            for (const NodeId node : nodes_of(mesh, type, i)) set(node, kFixed);
        }
    });
    for (const NodeId node : walls.nodes) set(node, 0);
    for (int r = 1; r < rings; ++r) {
        for_element_chunks(mesh, threads, [&](ElementType type, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const ElementNodes nodes = nodes_of(mesh, type, i);
                const bool is_next = std::any_of(nodes.begin(), nodes.end(), [&](NodeId node) {
                    return ring[node].load(std::memory_order_relaxed) == r - 1;
                });
                if (!is_next || walls.has_layers[mesh.block(type).region[i]] == 0) continue;
                for (const NodeId node : nodes) {
                    if (ring[node].load(std::memory_order_relaxed) == kFar) set(node, r);
                }
            }
        });
    }
    return ring;
}

void find_elements(const Mesh& mesh, const Walls& walls, int threads, Band& band) {
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const std::size_t count = mesh.block(type).size();
        std::vector<std::vector<std::uint32_t>> parts(chunk_count(count, kElementChunk));
        parallel_numbered(
            count, kElementChunk, threads, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    if (walls.has_layers[mesh.block(type).region[i]] == 0) continue;
                    const ElementNodes nodes = nodes_of(mesh, type, i);
                    const bool is_in = std::any_of(nodes.begin(), nodes.end(),
                                                   [&](NodeId node) { return band.slot[node] != kNoSlot; });
                    if (is_in) parts[chunk].push_back(static_cast<std::uint32_t>(i));
                }
            });
        auto& list = band.elements[static_cast<std::size_t>(t)];
        for (const auto& part : parts) list.insert(list.end(), part.begin(), part.end());
    }
}

/// Of each type and local node the other ends of its edges.
using EdgeEnds = std::array<std::array<std::vector<std::uint8_t>, 8>, kElementTypes>;
EdgeEnds edge_ends() {
    EdgeEnds ends;
    for (int t = 0; t < kElementTypes; ++t) {
        const LocalEdges local = local_edges(static_cast<ElementType>(t));
        for (int e = 0; e < local.count; ++e) {
            const auto a = static_cast<std::uint8_t>(local.edges[e][0]);
            const auto b = static_cast<std::uint8_t>(local.edges[e][1]);
            ends[static_cast<std::size_t>(t)][a].push_back(b);
            ends[static_cast<std::size_t>(t)][b].push_back(a);
        }
    }
    return ends;
}

void find_neighbours(const Mesh& mesh, int threads, Band& band) {
    // Elements at each slot, all types in one count.
    std::array<std::size_t, kElementTypes + 1> first{};
    for (std::size_t t = 0; t < kElementTypes; ++t) first[t + 1] = first[t] + band.elements[t].size();
    const SmallGroups elements_at(band.node.size(), [&](const auto& found) {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            for (std::size_t e = 0; e < band.elements[t].size(); ++e) {
                for (const NodeId node : nodes_of(mesh, static_cast<ElementType>(t), band.elements[t][e])) {
                    if (band.slot[node] != kNoSlot) found(band.slot[node], first[t] + e);
                }
            }
        }
    });
    /// Edges of a chunk of slots.
    struct Edges {
        std::vector<std::uint32_t> count, end;  ///< by slot; all ends one after the other
        std::vector<float> conductance;
    };
    const EdgeEnds ends = edge_ends();
    std::vector<Edges> chunks(chunk_count(band.node.size(), kNodeChunk));
    band.weight.resize(band.node.size());
    parallel_numbered(
        band.node.size(), kNodeChunk, threads, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
            Edges& edges = chunks[chunk];
            std::vector<NodeId> near;
            for (std::size_t slot = begin; slot < end; ++slot) {
                near.clear();
                for (const std::uint32_t e : elements_at[slot]) {
                    std::size_t t = 0;
                    while (e >= first[t + 1]) ++t;
                    const auto type = static_cast<ElementType>(t);
                    const NodeId* const node = nodes_of(mesh, type, band.elements[t][e - first[t]]).first;
                    std::size_t k = 0;
                    while (node[k] != band.node[slot]) ++k;
                    for (const std::uint8_t other : ends[t][k]) near.push_back(node[other]);
                }
                sort_unique(near);
                const std::size_t before = edges.end.size();
                const Vec3 at = point_of(mesh, band.node[slot]);
                for (const NodeId node : near) {
                    const auto conductance =
                        static_cast<float>(1 / length(difference(point_of(mesh, node), at)));
                    band.weight[slot] += double{conductance};
                    if (band.slot[node] == kNoSlot) continue;
                    edges.end.push_back(band.slot[node]);
                    edges.conductance.push_back(conductance);
                }
                edges.count.push_back(static_cast<std::uint32_t>(edges.end.size() - before));
            }
        });
    band.neighbours = SmallGroups(band.node.size(), [&](const auto& found) {
        for (std::size_t slot = 0, at = 0; slot < band.node.size(); ++slot) {
            const Edges& edges = chunks[slot / kNodeChunk];
            if (slot % kNodeChunk == 0) at = 0;
            for (std::uint32_t k = 0; k < edges.count[slot % kNodeChunk]; ++k) found(slot, edges.end[at++]);
        }
    });
    for (const Edges& edges : chunks)
        band.conductance.insert(band.conductance.end(), edges.conductance.begin(), edges.conductance.end());
}

}  // namespace

int rings_for(const Growth& growth) {
    double most = 0;
    for (std::size_t i = 0; i < growth.reach.size(); ++i)
        most = std::max(most, length(growth.reach[i]) / growth.edges[i]);
    const double wanted = kFewestRings + std::ceil(kRingsPerEdge * std::min(most, double{kMostRings}));
    return std::min(static_cast<int>(wanted), kMostRings);
}

Band find_band(const Mesh& mesh, const Walls& walls, int rings, int threads) {
    const Rings ring = find_rings(mesh, walls, rings, threads);
    Band band;
    band.slot.assign(mesh.node_count(), kNoSlot);
    band.node = walls.nodes;
    band.ring = {0, walls.nodes.size()};
    std::vector<std::vector<NodeId>> by_ring(static_cast<std::size_t>(rings));
    for (std::size_t n = 0; n < mesh.node_count(); ++n) {
        const std::uint8_t r = ring[n].load(std::memory_order_relaxed);
        if (r > 0 && r < rings) by_ring[r].push_back(static_cast<NodeId>(n));
    }
    for (int r = 1; r < rings; ++r) {
        const std::vector<NodeId>& nodes = by_ring[static_cast<std::size_t>(r)];
        band.node.insert(band.node.end(), nodes.begin(), nodes.end());
        band.ring.push_back(band.node.size());
    }
    for (std::size_t s = 0; s < band.node.size(); ++s)
        band.slot[band.node[s]] = static_cast<std::uint32_t>(s);
    find_elements(mesh, walls, threads, band);
    find_neighbours(mesh, threads, band);
    return band;
}

}  // namespace mortise::layers
