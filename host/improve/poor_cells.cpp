#include "host/improve/poor_cells.hpp"

#include "host/common/parallel.hpp"
#include "kernels/shared/lattice.h"

namespace mortise::improve {
namespace {

constexpr std::size_t kChunk = 4096;
/// A hexahedron, wedge or pyramid with an edge shorter than this, in cells, counts as poor: it may have right
/// angles and still make its neighbours flat.
constexpr double kShortestEdge = 0.35;

double element_quality(const Mesh& mesh, const CellFrame& frame, const Element& e) {
    std::array<Point, 8> p;
    for (std::size_t k = 0; k < e.count; ++k) p[k] = in_cells(mesh, frame, e.node[k]);
    const auto corner = [&](std::size_t o, std::size_t a, std::size_t b, std::size_t c) {
        return corner_quality(p[a] - p[o], p[b] - p[o], p[c] - p[o]);
    };
    double worst = 2;
    switch (e.type) {
        case ElementType::kTetrahedron: return tetrahedron_quality(p[0], p[1], p[2], p[3]);
        case ElementType::kPyramid: return pyramid_quality({p[0], p[1], p[2], p[3], p[4]});
        case ElementType::kWedge:
            for (std::size_t i = 0; i < 3; ++i) {
                worst = std::min(worst, corner(i, (i + 1) % 3, (i + 2) % 3, i + 3));
                worst = std::min(worst, corner(i + 3, 3 + (i + 2) % 3, 3 + (i + 1) % 3, i));
            }
            return worst;
        case ElementType::kHexahedron:
            for (std::size_t i = 0; i < 4; ++i) {
                worst = std::min(worst, corner(i, (i + 1) % 4, (i + 3) % 4, i + 4));
                worst = std::min(worst, corner(i + 4, 4 + (i + 3) % 4, 4 + (i + 1) % 4, i));
            }
            return worst;
    }
    return worst;
}

/// Whether an element that is no tetrahedron is too flat to be split into good ones.
bool is_flat(const Mesh& mesh, const CellFrame& frame, const Element& e) {
    const LocalFaces faces = local_faces(e.type);
    for (int f = 0; f < faces.count; ++f) {
        const LocalFace& face = faces.faces[f];
        const std::size_t count = face[3] < 0 ? 3 : 4;
        for (std::size_t k = 0; k < count; ++k) {
            const Point edge =
                in_cells(mesh, frame, e.node[face[k]]) - in_cells(mesh, frame, e.node[face[(k + 1) % count]]);
            if (squared_length(edge) < kShortestEdge * kShortestEdge) return true;
        }
    }
    return false;
}

}  // namespace

Element element(const Mesh& mesh, int t, std::size_t i) {
    const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
    return {static_cast<ElementType>(t), mesh.elements[static_cast<std::size_t>(t)].nodes.data() + i * size,
            size};
}

/// Nodes lie on the lattice of 2^-26 of a cell: rounding takes away what the map to model coordinates added.
Point in_cells(const Mesh& mesh, const CellFrame& frame, NodeId node) {
    Point p;
    for (std::size_t j = 0; j < 3; ++j) {
        const double x = (mesh.points[3 * std::size_t{node} + j] - frame.origin[j]) / frame.cell;
        p[j] = std::rint(x * kCellUnits) / kCellUnits;
    }
    return p;
}

Point centroid(const Mesh& mesh, const CellFrame& frame, const Element& e) {
    Point sum = {0, 0, 0};
    for (std::size_t k = 0; k < e.count; ++k) sum = sum + in_cells(mesh, frame, e.node[k]);
    return (1.0 / static_cast<double>(e.count)) * sum;
}

Point place_of(const Mesh& mesh, const CellFrame& frame, int type, std::size_t i) {
    const ElementBlock& block = mesh.elements[static_cast<std::size_t>(type)];
    if (type == 0 && block.kind[i] == static_cast<std::uint8_t>(ElementKind::kIn)) {
        return in_cells(mesh, frame, block.nodes[8 * i]) + Point{0.5, 0.5, 0.5};
    }
    return centroid(mesh, frame, element(mesh, type, i));
}

std::vector<std::size_t> poor_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                                    int threads) {
    std::vector<std::size_t> poor;
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        std::vector<std::vector<std::size_t>> found(chunk_count(block.size(), kChunk));
        parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            std::vector<std::size_t>& list = found[begin / kChunk];
            for (std::size_t i = begin; i < end; ++i) {
                // Hexahedra of IN cells are cubes.
                if (t == 0 && block.kind[i] == static_cast<std::uint8_t>(ElementKind::kIn)) continue;
                const Element e = element(mesh, t, i);
                if (element_quality(mesh, frame, e) < kPoorQuality || (t < 3 && is_flat(mesh, frame, e)))
                    list.push_back(cells.index(centroid(mesh, frame, e)));
            }
        });
        for (const auto& list : found) poor.insert(poor.end(), list.begin(), list.end());
    }
    std::sort(poor.begin(), poor.end());
    poor.erase(std::unique(poor.begin(), poor.end()), poor.end());
    return poor;
}

}  // namespace mortise::improve
