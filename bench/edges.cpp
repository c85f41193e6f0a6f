// See edges.hpp.
#include "bench/edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "mortise/error.hpp"

namespace mortise::bench {

double mean_edge_length(const Mesh& mesh) {
    std::vector<std::uint64_t> edges;
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        const LocalFaces faces = local_faces(static_cast<ElementType>(t));
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        for (std::size_t e = 0; e < block.size(); ++e) {
            for (int f = 0; f < faces.count; ++f) {
                const LocalFace& face = faces.faces[f];
                const std::size_t corners = corner_count(face);
                for (std::size_t i = 0; i < corners; ++i) {
                    const int from = face[i];
                    const int to = face[(i + 1) % corners];
                    if (from > to) continue;  // the neighbouring face has it the other way round
                    const std::uint64_t a = block.nodes[e * size + static_cast<std::size_t>(from)];
                    const std::uint64_t b = block.nodes[e * size + static_cast<std::size_t>(to)];
                    edges.push_back(a < b ? a << 32 | b : b << 32 | a);
                }
            }
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    double sum = 0;
    for (const std::uint64_t edge : edges) {
        const double* a = &mesh.points[3 * (edge >> 32)];
        const double* b = &mesh.points[3 * (edge & 0xffffffffu)];
        sum += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
    return sum / static_cast<double>(edges.size());
}

void write_surface(const Mesh& mesh, const std::string& path) {
    std::vector<std::uint32_t> number(mesh.node_count(), 0);  // from 1; 0: not on the boundary
    std::vector<NodeId> nodes;
    std::size_t triangles = 0;
    const FacetBlock& facets = mesh.facets;
    for (std::size_t f = 0; f < facets.size(); ++f) {
        for (std::size_t i = 0; i < 4; ++i) {
            const NodeId node = facets.nodes[4 * f + i];
            if (number[node] != 0) continue;
            nodes.push_back(node);
            number[node] = static_cast<std::uint32_t>(nodes.size());
        }
        triangles += facets.nodes[4 * f + 3] == facets.nodes[4 * f + 2] ? 1 : 2;
    }
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr) throw Error(ExitCode::kFiles, "cannot write '" + path + "'");
    std::fprintf(file, "%zu 3 0 0\n", nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double* p = &mesh.points[3 * std::size_t{nodes[i]}];
        std::fprintf(file, "%zu %.17g %.17g %.17g\n", i + 1, p[0], p[1], p[2]);
    }
    std::fprintf(file, "%zu 0\n", triangles);
    for (std::size_t f = 0; f < facets.size(); ++f) {
        const NodeId* n = &facets.nodes[4 * f];
        std::fprintf(file, "3 %u %u %u\n", number[n[0]], number[n[1]], number[n[2]]);
        if (n[3] != n[2]) std::fprintf(file, "3 %u %u %u\n", number[n[0]], number[n[2]], number[n[3]]);
    }
    std::fputs("0\n0\n", file);  // no holes, no regions
    if (std::fclose(file) != 0) throw Error(ExitCode::kFiles, "cannot write '" + path + "'");
}

}  // namespace mortise::bench
