// Small meshes made by hand, with facet lists found by brute force; shared by tests/quality and tests/io.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::samples {

inline NodeId add_node(Mesh& mesh, double x, double y, double z) {
    mesh.points.insert(mesh.points.end(), {x, y, z});
    return static_cast<NodeId>(mesh.node_count() - 1);
}

inline void add_element(Mesh& mesh, ElementType type, const std::vector<NodeId>& nodes,
                        std::uint16_t region = 1, ElementKind kind = ElementKind::kIn) {
    ElementBlock& block = mesh.block(type);
    block.nodes.insert(block.nodes.end(), nodes.begin(), nodes.end());
    block.region.push_back(region);
    block.kind.push_back(static_cast<std::uint8_t>(kind));
}

/// Replaces the facet list by the true one. Surface index: outside region, so interfaces get their own.
inline void list_facets(Mesh& mesh) {
    struct Side {
        std::vector<NodeId> nodes;
        std::uint16_t region;
    };
    std::map<std::vector<NodeId>, std::vector<Side>> sides;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const LocalFaces faces = local_faces(static_cast<ElementType>(t));
        const std::size_t per_element = static_cast<std::size_t>(kElementNodes[t]);
        for (std::size_t i = 0; i < block.size(); ++i) {
            for (int f = 0; f < faces.count; ++f) {
                Side side{{}, block.region[i]};
                for (const int local : faces.faces[f]) {
                    if (local >= 0)
                        side.nodes.push_back(block.nodes[per_element * i + static_cast<std::size_t>(local)]);
                }
                std::vector<NodeId> key = side.nodes;
                std::sort(key.begin(), key.end());
                sides[key].push_back(side);
            }
        }
    }
    mesh.facets = {};
    for (const auto& [key, both] : sides) {
        const std::uint16_t outside = both.size() == 2 ? both[1].region : std::uint16_t{0};
        if (outside == both[0].region) continue;
        std::vector<NodeId> nodes = both[0].nodes;
        if (nodes.size() == 3) nodes.push_back(nodes.back());
        mesh.facets.nodes.insert(mesh.facets.nodes.end(), nodes.begin(), nodes.end());
        mesh.facets.surface.push_back(outside);
        mesh.facets.inside.push_back(both[0].region);
        mesh.facets.outside.push_back(outside);
    }
}

inline void name_regions(Mesh& mesh, int count) {
    for (int r = 1; r <= count; ++r) mesh.region_names.push_back("region_" + std::to_string(r));
    mesh.surface_names.push_back("wall");
    for (int r = 1; r <= count; ++r) mesh.surface_names.push_back("interface_" + std::to_string(r));
}

/// One element in the reference position of mesh.hpp; apexes and tops at height 1.
inline Mesh unit_element(ElementType type) {
    Mesh mesh;
    switch (type) {
        case ElementType::kHexahedron:
            mesh.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
            break;
        case ElementType::kWedge: mesh.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1}; break;
        case ElementType::kPyramid: mesh.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 1}; break;
        case ElementType::kTetrahedron: mesh.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}; break;
    }
    std::vector<NodeId> nodes;
    for (std::size_t i = 0; i < mesh.node_count(); ++i) nodes.push_back(static_cast<NodeId>(i));
    add_element(mesh, type, nodes);
    name_regions(mesh, 1);
    list_facets(mesh);
    return mesh;
}

/// nx × ny × nz unit cubes; region_of(i, j, k) >= 1, or 0 to leave the cube out (its nodes stay out too).
inline Mesh grid(
    int nx, int ny, int nz, int regions,
    const std::function<int(int, int, int)>& region_of = [](int, int, int) { return 1; }) {
    Mesh mesh;
    std::map<std::vector<int>, NodeId> ids;
    const auto node = [&](int i, int j, int k) {
        const auto [at, is_new] = ids.insert({{k, j, i}, static_cast<NodeId>(mesh.node_count())});
        if (is_new) add_node(mesh, i, j, k);
        return at->second;
    };
    for (int k = 0; k < nz; ++k) {
        for (int j = 0; j < ny; ++j) {
            for (int i = 0; i < nx; ++i) {
                const int region = region_of(i, j, k);
                if (region == 0) continue;
                std::vector<NodeId> nodes;
                for (int up = 0; up < 2; ++up) {
                    nodes.insert(nodes.end(), {node(i, j, k + up), node(i + 1, j, k + up),
                                               node(i + 1, j + 1, k + up), node(i, j + 1, k + up)});
                }
                add_element(mesh, ElementType::kHexahedron, nodes, static_cast<std::uint16_t>(region));
            }
        }
    }
    name_regions(mesh, regions);
    list_facets(mesh);
    return mesh;
}

/// Mesh::periodic of a mesh of the unit cube, across x and y: nodes are paired by their places.
inline void pair_nodes(Mesh& mesh) {
    mesh.periodic.clear();
    for (std::size_t axis = 0; axis < 2; ++axis) {
        std::map<std::vector<double>, NodeId> low;
        const auto place = [&](std::size_t node) {
            std::vector<double> at(mesh.points.begin() + static_cast<std::ptrdiff_t>(3 * node),
                                   mesh.points.begin() + static_cast<std::ptrdiff_t>(3 * node + 3));
            at[axis] = 0;
            return at;
        };
        for (std::size_t n = 0; n < mesh.node_count(); ++n) {
            if (mesh.points[3 * n + axis] == 0) low[place(n)] = static_cast<NodeId>(n);
        }
        PeriodicNodes pair;
        pair.shift[axis] = 1;
        for (std::size_t n = 0; n < mesh.node_count(); ++n) {
            if (mesh.points[3 * n + axis] != 1) continue;
            pair.node.push_back(static_cast<NodeId>(n));
            pair.original.push_back(low.at(place(n)));
        }
        mesh.periodic.push_back(pair);
    }
}

/// The unit cube as n³ cubes, n a power of two, with the surfaces xmin, xmax, ymin, ymax and others, in no
/// order that one would expect, and periodic across x and y.
inline Mesh periodic_grid(int n) {
    Mesh mesh = grid(n, n, n, 1);
    for (double& x : mesh.points) x /= n;
    mesh.surface_names = {"xmax", "others", "ymin", "xmin", "ymax"};
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const auto all = [&](std::size_t axis, double at) {
            const FacetNodes nodes = mesh.facets.facet(f);
            return std::all_of(nodes.begin(), nodes.end(),
                               [&](NodeId node) { return mesh.points[3 * node + axis] == at; });
        };
        mesh.facets.surface[f] = all(0, 1) ? 0 : all(1, 0) ? 2 : all(0, 0) ? 3 : all(1, 1) ? 4 : 1;
    }
    pair_nodes(mesh);
    return mesh;
}

/// A unit cube with a pyramid (volume 1/3) on top, a wedge (1/2) at x = 1 and a tetrahedron at the pyramid's
/// x side; cube and wedge are region 1, the others region 2. The cube is hexahedron 0; nodes 0-7 are its own.
inline Mesh mixed() {
    Mesh mesh = unit_element(ElementType::kHexahedron);
    mesh.region_names.clear();
    mesh.surface_names.clear();
    const NodeId apex = add_node(mesh, 0.5, 0.5, 2);
    const NodeId front = add_node(mesh, 2, 0, 0), back = add_node(mesh, 2, 1, 0);
    const NodeId tip = add_node(mesh, 2, 0.5, 2);
    add_element(mesh, ElementType::kWedge, {1, 5, front, 2, 6, back}, 1, ElementKind::kSnio);
    add_element(mesh, ElementType::kPyramid, {4, 5, 6, 7, apex}, 2, ElementKind::kCnio);
    add_element(mesh, ElementType::kTetrahedron, {5, 6, apex, tip}, 2, ElementKind::kSnio);
    name_regions(mesh, 2);
    list_facets(mesh);
    return mesh;
}

/// Makes a mesh of first order one of second order with straight edges.
inline Mesh with_middles(Mesh mesh) {
    std::map<std::pair<NodeId, NodeId>, NodeId> middles;
    const auto middle = [&](NodeId a, NodeId b) {
        const auto [at, is_new] = middles.insert({std::minmax(a, b), static_cast<NodeId>(mesh.node_count())});
        if (is_new) {
            for (std::size_t j = 0; j < 3; ++j)
                mesh.points.push_back(0.5 * (mesh.points[3 * a + j] + mesh.points[3 * b + j]));
        }
        return at->second;
    };
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        ElementBlock& block = mesh.elements[t];
        const LocalEdges edges = local_edges(static_cast<ElementType>(t));
        for (std::size_t i = 0; i < block.size(); ++i) {
            const NodeId* const node = block.nodes.data() + static_cast<std::size_t>(kElementNodes[t]) * i;
            for (int e = 0; e < edges.count; ++e)
                block.middles.push_back(middle(node[edges.edges[e][0]], node[edges.edges[e][1]]));
        }
    }
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const FacetNodes node = mesh.facets.facet(f);
        for (std::size_t k = 0; k < node.size(); ++k)
            mesh.facets.middles.push_back(middle(node[k], node.after(k)));
        if (node.size() == 3) mesh.facets.middles.push_back(mesh.facets.middles.back());
    }
    mesh.model_dimension.clear();
    return mesh;
}

}  // namespace mortise::samples
