#include "host/features/hinges.hpp"

#include <algorithm>

#include "host/common/index_set.hpp"
#include "host/common/parallel.hpp"

namespace mortise::features {
namespace {

constexpr std::size_t kChunk = 8192;

/// A facet at a node: it runs from `from` through the node on to `to`.
struct Corner {
    NodeId from, to;
};

/// The outer facets' corners, node by node: those of node[i] are corner[begin[i]] … corner[begin[i + 1]].
struct Corners {
    std::vector<NodeId> node;  ///< those on outer facets, ascending
    std::vector<std::uint32_t> begin;
    std::vector<Corner> corner;
};

Corners list_corners(const FacetBlock& facets, std::size_t nodes) {
    Corners list;
    IndexSet outer(nodes);
    const auto for_corners = [&facets](const auto& visit) {
        for (std::size_t f = 0; f < facets.size(); ++f) {
            if (facets.outside[f] != 0) continue;
            const FacetNodes n = facets.facet(f);
            for (std::size_t k = 0; k < n.size(); ++k) visit(n[k], Corner{n.before(k), n.after(k)});
        }
    };
    for_corners([&](NodeId node, const Corner&) { outer.insert(node); });
    outer.number();
    list.node = outer.members();
    list.begin.assign(outer.size() + 1, 0);
    for_corners([&](NodeId node, const Corner&) { ++list.begin[outer.place(node) + 1]; });
    for (std::size_t i = 0; i < outer.size(); ++i) list.begin[i + 1] += list.begin[i];
    list.corner.resize(list.begin.back());
    std::vector<std::uint32_t> next(list.begin.begin(), list.begin.end() - 1);
    for_corners([&](NodeId node, const Corner& corner) { list.corner[next[outer.place(node)]++] = corner; });
    return list;
}

/// Whether the facets at a node are one fan: each begins where another one ends.
bool is_one_fan(const Corner* corner, std::size_t count) {
    NodeId at = corner[0].to;
    std::size_t passed = 1;
    while (at != corner[0].from && passed <= count) {
        const Corner* end = corner + count;
        const Corner* next = std::find_if(corner, end, [at](const Corner& c) { return c.from == at; });
        if (next == end) return false;
        at = next->to;
        ++passed;
    }
    return passed == count;
}

/// Edges to higher nodes that more than two facets share, and whether there are any to lower ones.
struct Crowded {
    std::uint64_t higher = 0;
    bool any = false;
};
Crowded find_crowded(NodeId node, const Corner* corner, std::size_t count) {
    Crowded result;
    for (std::size_t i = 0; i < count; ++i) {
        const NodeId other = corner[i].to;
        std::size_t leaving = 0, before = 0;
        for (std::size_t j = 0; j < count; ++j) {
            leaving += corner[j].to == other ? 1 : 0;
            before += j < i && corner[j].to == other ? 1 : 0;
        }
        if (leaving < 2 || before > 0) continue;
        result.any = true;
        result.higher += other > node ? 1 : 0;
    }
    return result;
}

}  // namespace

Hinges find_hinges(const FacetBlock& facets, std::size_t nodes, int threads) {
    const Corners corners = list_corners(facets, nodes);
    std::vector<Hinges> found(chunk_count(corners.node.size(), kChunk));
    parallel_chunks(corners.node.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        Hinges& hinges = found[begin / kChunk];
        for (std::size_t i = begin; i < end; ++i) {
            const Corner* corner = corners.corner.data() + corners.begin[i];
            const std::size_t count = corners.begin[i + 1] - corners.begin[i];
            if (is_one_fan(corner, count)) continue;
            const Crowded crowded = find_crowded(corners.node[i], corner, count);
            hinges.edges += crowded.higher;
            hinges.nodes += crowded.any ? 0 : 1;
            if (!hinges.first) hinges.first = corners.node[i];
        }
    });
    Hinges result;
    for (const Hinges& part : found) {
        result.edges += part.edges;
        result.nodes += part.nodes;
        if (!result.first) result.first = part.first;
    }
    return result;
}

}  // namespace mortise::features
