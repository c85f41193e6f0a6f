// A mesh with hanging nodes, made by hand; for tests of checks and files.
#pragma once

#include "tests/quality/sample_meshes.hpp"

namespace mortise::samples {

/// Cubes of edge 2, one upon the other along z, with unit cubes all around in a box of 4 × 4 × (2 count + 2):
/// a hanging node in the middle of each of their edges and faces, but of the faces between two of them. They
/// are the last hexahedra, of another kind.
inline Mesh large_among_small(int count = 1) {
    const int height = 2 * count + 2;
    Mesh mesh = grid(4, 4, height, 1, [&](int i, int j, int k) {
        return (i == 1 || i == 2) && (j == 1 || j == 2) && k > 0 && k < height - 1 ? 0 : 1;
    });
    std::map<std::array<int, 3>, NodeId> nodes;
    const auto sum = [&](const std::array<NodeId, 4>& of) {
        std::array<int, 3> at{};
        for (const NodeId n : of) {
            for (std::size_t j = 0; j < 3; ++j)
                at[j] += static_cast<int>(mesh.points[3 * std::size_t{n} + j]);
        }
        return at;
    };
    for (NodeId n = 0; n < mesh.node_count(); ++n) nodes[sum({n, n, n, n})] = n;
    std::map<NodeId, std::array<NodeId, 4>> hanging;
    for (int c = 0; c < count; ++c) {
        std::vector<NodeId> corners;
        for (const int z : {1 + 2 * c, 3 + 2 * c}) {
            for (const auto& [x, y] : {std::pair<int, int>{1, 1}, {3, 1}, {3, 3}, {1, 3}})
                corners.push_back(nodes.at({4 * x, 4 * y, 4 * z}));
        }
        add_element(mesh, ElementType::kHexahedron, corners, 1, ElementKind::kTransition);
        for (const LocalFace& face : kHexahedronFaces) {
            std::array<NodeId, 4> masters;
            for (std::size_t k = 0; k < 4; ++k) masters[k] = corners[static_cast<std::size_t>(face[k])];
            if (nodes.count(sum(masters)) > 0) hanging[nodes.at(sum(masters))] = masters;
            for (std::size_t k = 0; k < 4; ++k) {
                const NodeId a = masters[k], b = masters[(k + 1) % 4];
                hanging[nodes.at(sum({a, b, a, b}))] = {a, b, a, b};
            }
        }
    }
    for (const auto& [at, masters] : hanging) {
        mesh.hanging.node.push_back(at);
        mesh.hanging.masters.insert(mesh.hanging.masters.end(), masters.begin(), masters.end());
    }
    // The hollow's faces were listed before the larger cubes were there.
    FacetBlock outer;
    for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
        bool is_outer = false;
        for (std::size_t j = 0; j < 3; ++j) {
            for (const double side : {0.0, j < 2 ? 4.0 : height}) {
                bool all = true;
                for (std::size_t k = 0; k < 4; ++k)
                    all = all && mesh.points[3 * std::size_t{mesh.facets.nodes[4 * i + k]} + j] == side;
                is_outer = is_outer || all;
            }
        }
        if (!is_outer) continue;
        const auto begin = mesh.facets.nodes.begin() + 4 * static_cast<std::ptrdiff_t>(i);
        outer.nodes.insert(outer.nodes.end(), begin, begin + 4);
        outer.surface.push_back(0);
        outer.inside.push_back(1);
        outer.outside.push_back(0);
    }
    mesh.facets = outer;
    return mesh;
}

}  // namespace mortise::samples
