#include "host/layers/walls.hpp"

#include <algorithm>
#include <tuple>

#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/common/small_groups.hpp"

namespace mortise::layers {
namespace {

bool holds(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

void choose_facets(const Mesh& mesh, const std::vector<std::string>& names, Walls& walls) {
    const bool any_region = std::any_of(mesh.region_names.begin(), mesh.region_names.end(),
                                        [&](const std::string& region) { return holds(names, region); });
    walls.has_layers.assign(mesh.region_names.size() + 1, 0);
    for (std::size_t r = 0; r < mesh.region_names.size(); ++r)
        walls.has_layers[r + 1] = !any_region || holds(names, mesh.region_names[r]);
    // A surface may be called that the mesh does not have.
    const bool any_surface = std::any_of(
        names.begin(), names.end(), [&](const std::string& name) { return !holds(mesh.region_names, name); });
    std::vector<std::uint8_t> is_named(mesh.surface_names.size());
    for (std::size_t s = 0; s < is_named.size(); ++s) is_named[s] = holds(names, mesh.surface_names[s]);
    const FacetBlock& facets = mesh.facets;
    walls.role.resize(facets.size());
    for (std::size_t f = 0; f < facets.size(); ++f) {
        const bool inside = walls.has_layers[facets.inside[f]] != 0;
        const bool outside = walls.has_layers[facets.outside[f]] != 0;
        FacetRole& role = walls.role[f];
        if (inside == outside) {
            role = inside ? FacetRole::kInner : FacetRole::kAway;
        } else if (!any_surface || is_named[facets.surface[f]] != 0) {
            role = FacetRole::kWall;
        } else {
            role = facets.outside[f] == 0 ? FacetRole::kOpen : FacetRole::kClosed;
        }
        if (role != FacetRole::kWall) continue;
        WallFacet wall;
        std::copy_n(facets.nodes.data() + 4 * f, 4, wall.node.begin());
        wall.facet = static_cast<std::uint32_t>(f);
        wall.region = inside ? facets.inside[f] : facets.outside[f];
        if (!inside) {  // the layers are on the other side
            const std::size_t corners = wall.corners();
            std::reverse(wall.node.begin(), wall.node.begin() + static_cast<int>(corners));
            if (corners == 3) wall.node[3] = wall.node[2];
        }
        walls.facets.push_back(wall);
    }
    for (const std::string& name : names) {
        const auto is_called = [&](const WallFacet& wall) {
            return name == mesh.region_names[wall.region - 1u] ||
                   name == mesh.surface_names[facets.surface[wall.facet]];
        };
        if (std::none_of(walls.facets.begin(), walls.facets.end(), is_called)) walls.unused.push_back(name);
    }
}

void number_nodes(std::size_t count, Walls& walls) {
    walls.place.assign(count, kNoWallNode);
    for (const WallFacet& facet : walls.facets) {
        for (const NodeId node : facet.node) walls.place[node] = 0;
    }
    for (std::size_t node = 0; node < count; ++node) {
        if (walls.place[node] == kNoWallNode) continue;
        walls.place[node] = static_cast<std::uint32_t>(walls.nodes.size());
        walls.nodes.push_back(static_cast<NodeId>(node));
    }
    walls.is_bare.assign(walls.nodes.size(), 0);
}

/// An edge of a facet, in the facet's order.
struct FacetEdge {
    NodeId low, high;
    std::uint32_t facet;
    FacetRole role;
    bool ascends;

    bool operator<(const FacetEdge& other) const {
        return std::tie(low, high, facet) < std::tie(other.low, other.high, other.facet);
    }
    bool joins(const FacetEdge& other) const { return low == other.low && high == other.high; }
};

/// Nodes of facets towards regions without layers are bare.
void look_at_closed(const Mesh& mesh, Walls& walls) {
    const FacetBlock& facets = mesh.facets;
    for (std::size_t f = 0; f < facets.size(); ++f) {
        if (walls.role[f] != FacetRole::kClosed) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::uint32_t place = walls.place[facets.nodes[4 * f + k]];
            if (place != kNoWallNode) walls.is_bare[place] = 1;
        }
    }
}

/// All edges between wall nodes.
std::vector<FacetEdge> list_edges(const Mesh& mesh, const Walls& walls, int threads) {
    const FacetBlock& facets = mesh.facets;
    std::vector<std::vector<FacetEdge>> parts(chunk_count(facets.size(), kElementChunk));
    parallel_chunks(facets.size(), kElementChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        std::vector<FacetEdge>& part = parts[begin / kElementChunk];
        for (std::size_t f = begin; f < end; ++f) {
            if (walls.role[f] == FacetRole::kAway) continue;
            const FacetNodes node = facets.facet(f);
            for (std::size_t k = 0; k < node.size(); ++k) {
                const NodeId a = node[k], b = node.after(k);
                if (walls.place[a] == kNoWallNode || walls.place[b] == kNoWallNode) continue;
                part.push_back(
                    {std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(f), walls.role[f], a < b});
            }
        }
    });
    std::vector<FacetEdge> edges;
    for (const auto& part : parts) edges.insert(edges.end(), part.begin(), part.end());
    parallel_sort(edges, threads);
    return edges;
}

/// Rims, and bare ends of edges at which neither two walls meet nor a wall and one other facet.
void look_at_edges(const std::vector<FacetEdge>& edges, Walls& walls) {
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        std::array<std::size_t, 5> count{};
        for (end = begin; end < edges.size() && edges[end].joins(edges[begin]); ++end)
            ++count[static_cast<std::size_t>(edges[end].role)];
        const auto of = [&](FacetRole role) { return count[static_cast<std::size_t>(role)]; };
        const std::size_t wall = of(FacetRole::kWall), open = of(FacetRole::kOpen),
                          inner = of(FacetRole::kInner);
        if (wall == 0) continue;
        const bool is_rim = (wall == 2 && open == 0 && inner == 1) || (wall == 1 && open == 1 && inner == 0);
        const bool is_fine = is_rim || (wall == 2 && open == 0 && inner == 0);
        for (std::size_t e = begin; e < end; ++e) {
            const FacetEdge& edge = edges[e];
            if (!is_fine) {
                walls.is_bare[walls.place[edge.low]] = 1;
                walls.is_bare[walls.place[edge.high]] = 1;
            } else if (is_rim && edge.role != FacetRole::kWall) {
                walls.rims.push_back(
                    {edge.ascends ? edge.low : edge.high, edge.ascends ? edge.high : edge.low, edge.facet});
            }
        }
    }
}

/// Nodes at which the boundary of the regions with layers is several fans of facets.
void look_at_fans(const Mesh& mesh, int threads, Walls& walls) {
    const FacetBlock& facets = mesh.facets;
    // Facets of that boundary at each wall node.
    const auto visit = [&](const auto& found) {
        for (std::size_t f = 0; f < facets.size(); ++f) {
            if (walls.role[f] == FacetRole::kAway || walls.role[f] == FacetRole::kInner) continue;
            for (const NodeId node : facets.facet(f)) {
                if (walls.place[node] != kNoWallNode) found(walls.place[node], f);
            }
        }
    };
    const SmallGroups at(walls.nodes.size(), visit);
    parallel_chunks(walls.nodes.size(), kNodeChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        std::vector<std::array<NodeId, 2>> open;
        for (std::size_t i = begin; i < end; ++i) {
            // Of each facet the two neighbours of the node; chained by common ones, all must be one ring.
            open.clear();
            for (const std::uint32_t f : at[i]) {
                const FacetNodes node = facets.facet(f);
                const auto k = static_cast<std::size_t>(std::find(node.begin(), node.end(), walls.nodes[i]) -
                                                        node.begin());
                open.push_back({node.before(k), node.after(k)});
            }
            const NodeId first = open.back()[0];
            NodeId next = open.back()[1];
            open.pop_back();
            while (next != first) {
                const auto found = std::find_if(open.begin(), open.end(), [&](const auto& pair) {
                    return pair[0] == next || pair[1] == next;
                });
                if (found == open.end()) break;
                next = (*found)[0] == next ? (*found)[1] : (*found)[0];
                open.erase(found);
            }
            if (next != first || !open.empty()) walls.is_bare[i] = 1;
        }
    });
}

}  // namespace

Walls find_walls(const Mesh& mesh, const std::vector<std::string>& names, int threads) {
    Walls walls;
    choose_facets(mesh, names, walls);
    number_nodes(mesh.node_count(), walls);
    look_at_closed(mesh, walls);
    look_at_edges(list_edges(mesh, walls, threads), walls);
    look_at_fans(mesh, threads, walls);
    return walls;
}

}  // namespace mortise::layers
