#include "host/second_order/edges.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <string>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "mortise/error.hpp"

namespace mortise::second_order {
namespace {

constexpr std::size_t kElementChunk = 8192;
constexpr std::size_t kNodeChunk = 16384;

/// Calls visit(lower node, upper node) for each edge of each element, by several threads.
template <class Visit>
void visit_element_edges(const Mesh& mesh, int threads, const Visit& visit) {
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const ElementBlock& block = mesh.block(type);
        const LocalEdges local = local_edges(type);
        const auto nodes = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        parallel_chunks(block.size(), kElementChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                const NodeId* const node = block.nodes.data() + nodes * i;
                for (int e = 0; e < local.count; ++e) {
                    const NodeId a = node[local.edges[e][0]], b = node[local.edges[e][1]];
                    visit(std::min(a, b), std::max(a, b));
                }
            }
        });
    }
}

}  // namespace

Edges::Edges(const Mesh& mesh, int threads) {
    const std::size_t nodes = mesh.node_count();
    // Upper ends by lower node, as often as elements have the edge, in whatever order threads come.
    const std::unique_ptr<std::atomic<std::uint32_t>[]> count(new std::atomic<std::uint32_t>[nodes]());
    visit_element_edges(mesh, threads,
                        [&](NodeId lower, NodeId) { count[lower].fetch_add(1, std::memory_order_relaxed); });
    first_.resize(nodes + 1);
    for (std::size_t n = 0; n < nodes; ++n) {
        first_[n + 1] = first_[n] + count[n];
        count[n].store(0, std::memory_order_relaxed);
    }
    std::vector<NodeId> ends;
    resize_large(ends, first_[nodes], threads);
    visit_element_edges(mesh, threads, [&](NodeId lower, NodeId upper) {
        ends[first_[lower] + count[lower].fetch_add(1, std::memory_order_relaxed)] = upper;
    });
    // Each once, ascending.
    parallel_chunks(nodes, kNodeChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t n = begin; n < end; ++n) {
            const auto from = ends.begin() + static_cast<std::ptrdiff_t>(first_[n]);
            const auto to = ends.begin() + static_cast<std::ptrdiff_t>(first_[n + 1]);
            std::sort(from, to);
            count[n].store(static_cast<std::uint32_t>(std::unique(from, to) - from),
                           std::memory_order_relaxed);
        }
    });
    std::size_t edges = 0;
    for (std::size_t n = 0; n < nodes; ++n) edges += count[n];
    if (nodes + edges > std::numeric_limits<NodeId>::max())
        throw Error(ExitCode::kMeshing, "a mesh of second order would have " + std::to_string(nodes + edges) +
                                            " nodes, more than can be numbered; choose larger cells");
    touch_large(upper_, edges, threads);
    for (std::size_t n = 0; n < nodes; ++n) {
        const auto from = ends.begin() + static_cast<std::ptrdiff_t>(first_[n]);
        first_[n] = upper_.size();
        upper_.insert(upper_.end(), from, from + static_cast<std::ptrdiff_t>(count[n]));
    }
    first_[nodes] = upper_.size();
}

std::size_t Edges::find(NodeId a, NodeId b) const {
    const std::size_t edge = number(a, b);
    const bool is_there = edge < first_[std::size_t{std::min(a, b)} + 1] && upper_[edge] == std::max(a, b);
    return is_there ? edge : size();
}

std::size_t Edges::number(NodeId a, NodeId b) const {
    const NodeId lower = std::min(a, b), upper = std::max(a, b);
    const auto from = upper_.begin() + static_cast<std::ptrdiff_t>(first_[lower]);
    const auto to = upper_.begin() + static_cast<std::ptrdiff_t>(first_[std::size_t{lower} + 1]);
    return static_cast<std::size_t>(std::lower_bound(from, to, upper) - upper_.begin());
}

}  // namespace mortise::second_order
