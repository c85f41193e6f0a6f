#include "host/tetrahedra/split.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "mortise/error.hpp"

namespace mortise::tetrahedra {
namespace {

using Tetrahedron = std::array<NodeId, 4>;

double determinant(const std::vector<double>& points, const Tetrahedron& t) {
    const double* o = points.data() + 3 * std::size_t{t[0]};
    double edge[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
        const double* p = points.data() + 3 * std::size_t{t[i + 1]};
        for (std::size_t j = 0; j < 3; ++j) edge[i][j] = p[j] - o[j];
    }
    return edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) +
           edge[0][1] * (edge[1][2] * edge[2][0] - edge[1][0] * edge[2][2]) +
           edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
}

/// Order of the nodes of a mesh; nodes without a rank come last.
struct Order {
    const std::vector<NodeId>* rank;

    bool operator()(NodeId a, NodeId b) const {
        const auto of = [this](NodeId n) { return rank != nullptr && n < rank->size() ? (*rank)[n] : n; };
        return of(a) != of(b) ? of(a) < of(b) : a < b;
    }
};

/// Triangles of a facet of three or four nodes, cut through its lowest node; the orientation stays.
void triangulate(const NodeId* node, int count, const Order& less, std::vector<std::array<NodeId, 3>>& out) {
    if (count == 3) {
        out.push_back({node[0], node[1], node[2]});
        return;
    }
    const auto low = static_cast<std::size_t>(std::min_element(node, node + 4, less) - node);
    for (std::size_t k = 1; k < 3; ++k) {
        out.push_back({node[low], node[(low + k) % 4], node[(low + k + 1) % 4]});
    }
}

/// Tetrahedra from `apex` over the faces that do not hold it. Outward triangles make a positive one as (a, c,
/// b, apex).
void cone(ElementType type, const NodeId* node, NodeId apex, const Order& less,
          std::vector<Tetrahedron>& out) {
    std::vector<std::array<NodeId, 3>> triangles;
    const LocalFaces faces = local_faces(type);
    for (int f = 0; f < faces.count; ++f) {
        NodeId corner[4];
        int count = 0;
        bool holds = false;
        for (const int i : faces.faces[f]) {
            if (i < 0) continue;
            corner[count++] = node[i];
            holds = holds || node[i] == apex;
        }
        if (!holds) triangulate(corner, count, less, triangles);
    }
    for (const auto& t : triangles) out.push_back({t[0], t[2], t[1], apex});
}

bool all_positive(const std::vector<double>& points, const std::vector<Tetrahedron>& list) {
    return std::all_of(list.begin(), list.end(),
                       [&](const Tetrahedron& t) { return determinant(points, t) > 0; });
}

}  // namespace

Mesh split(const Mesh& mesh, const std::vector<NodeId>* rank) {
    const Order less{rank};
    Mesh result;
    result.points = mesh.points;
    result.region_names = mesh.region_names;
    result.surface_names = mesh.surface_names;
    ElementBlock& out = result.block(ElementType::kTetrahedron);
    std::vector<Tetrahedron> pieces;
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const ElementBlock& block = mesh.block(type);
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        for (std::size_t i = 0; i < block.size(); ++i) {
            const NodeId* node = block.nodes.data() + i * size;
            pieces.clear();
            if (type == ElementType::kTetrahedron) {
                pieces.push_back({node[0], node[1], node[2], node[3]});
            } else {
                cone(type, node, *std::min_element(node, node + size, less), less, pieces);
                if (!all_positive(result.points, pieces)) {
                    pieces.clear();
                    const auto centre = static_cast<NodeId>(result.node_count());
                    for (std::size_t j = 0; j < 3; ++j) {
                        double sum = 0;
                        for (std::size_t k = 0; k < size; ++k)
                            sum += mesh.points[3 * std::size_t{node[k]} + j];
                        result.points.push_back(sum / static_cast<double>(size));
                    }
                    cone(type, node, centre, less, pieces);
                    if (!all_positive(result.points, pieces)) {
                        throw Error(ExitCode::kMeshing,
                                    "element " + std::to_string(i) + " of type " + std::to_string(t) +
                                        " cannot be split into positive tetrahedra; use --elements hex");
                    }
                }
            }
            for (const Tetrahedron& piece : pieces) {
                out.nodes.insert(out.nodes.end(), piece.begin(), piece.end());
                out.region.push_back(block.region[i]);
                out.kind.push_back(block.kind[i]);
            }
        }
    }
    const FacetBlock& facets = mesh.facets;
    std::vector<std::array<NodeId, 3>> triangles;
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const NodeId* node = facets.nodes.data() + 4 * i;
        triangles.clear();
        triangulate(node, node[3] == node[2] ? 3 : 4, less, triangles);
        for (const auto& triangle : triangles) {
            result.facets.nodes.insert(result.facets.nodes.end(), triangle.begin(), triangle.end());
            result.facets.nodes.push_back(triangle[2]);
            result.facets.surface.push_back(facets.surface[i]);
            result.facets.inside.push_back(facets.inside[i]);
            result.facets.outside.push_back(facets.outside[i]);
        }
    }
    return result;
}

}  // namespace mortise::tetrahedra
