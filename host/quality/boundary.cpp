// The boundary as a surface: closed, no quadrilateral against triangles, area, Euler characteristic.
#include <algorithm>
#include <array>

#include "host/quality/curved.hpp"
#include "host/quality/passes.hpp"
#include "host/quality/vector.hpp"

namespace mortise::quality {
namespace {

struct EdgeFigures {
    std::uint64_t edges = 0;
    std::uint64_t not_two = 0;  ///< edges with other than two facets
    std::uint64_t odd = 0;
    NodeId first_odd[2] = {0, 0};
};

/// Counts the facets at each edge. `facet(i)` gives facet i.
template <class Facet>
EdgeFigures count_edges(std::size_t facets, const Facet& facet) {
    std::vector<std::uint64_t> edges;
    for (std::size_t i = 0; i < facets; ++i) {
        const BoundaryFacet f = facet(i);
        const int count = f.count();
        for (int k = 0; k < count; ++k) {
            edges.push_back(edge_ends(f.nodes[k], f.nodes[(k + 1) % count]));
        }
    }
    std::sort(edges.begin(), edges.end());
    EdgeFigures figures;
    for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
        while (j < edges.size() && edges[j] == edges[i]) ++j;
        ++figures.edges;
        figures.not_two += j - i != 2;
        if ((j - i) % 2 == 0) continue;
        if (figures.odd++ == 0) {
            figures.first_odd[0] = static_cast<NodeId>(edges[i] >> 32);
            figures.first_odd[1] = static_cast<NodeId>(edges[i]);
        }
    }
    return figures;
}

void report_open_edges(const Mesh& mesh, const EdgeFigures& figures, DefectKind kind, DefectLog& log) {
    for (std::uint64_t i = 0; i < figures.odd; ++i) {
        log.add(kind, [&] {
            const NodeId* edge = figures.first_odd;
            return "edge (" + std::to_string(edge[0]) + ", " + std::to_string(edge[1]) + ") from " +
                   point_text(mesh, edge[0]) + " to " + point_text(mesh, edge[1]);
        });
    }
}

/// Of a facet of second order, whose edges may be curved.
double area_between(const Mesh& mesh, const BoundaryFacet& facet, const std::vector<EdgeMiddle>& middles) {
    const int count = facet.count();
    Vector corner[4], middle[4];
    for (int k = 0; k < count; ++k) {
        const std::uint64_t ends = edge_ends(facet.nodes[k], facet.nodes[(k + 1) % count]);
        const auto found = std::lower_bound(middles.begin(), middles.end(), EdgeMiddle{ends, 0});
        corner[k] = point_of(mesh, facet.nodes[k]);
        if (found != middles.end() && found->ends == ends) middle[k] = point_of(mesh, found->node);
    }
    return curved_area(corner, middle, count);
}

/// Area of a triangle, or of the bilinear patch over a quadrilateral by 3×3 Gauss points (exact if plane).
double area(const Mesh& mesh, const BoundaryFacet& facet) {
    const Vector p[4] = {point_of(mesh, facet.nodes[0]), point_of(mesh, facet.nodes[1]),
                         point_of(mesh, facet.nodes[2]), point_of(mesh, facet.nodes[3])};
    if (facet.count() == 3) return 0.5 * length(cross(p[1] - p[0], p[2] - p[0]));
    constexpr double points[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
    constexpr double weights[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const double u = points[i], v = points[j];
            const Vector along_u = (1 - v) * (p[1] - p[0]) + v * (p[2] - p[3]);
            const Vector along_v = (1 - u) * (p[3] - p[0]) + u * (p[2] - p[1]);
            sum += weights[i] * weights[j] * length(cross(along_u, along_v));
        }
    }
    return sum;
}

using Triangle = std::array<NodeId, 3>;

Triangle sorted(NodeId a, NodeId b, NodeId c) {
    Triangle triangle{a, b, c};
    std::sort(triangle.begin(), triangle.end());
    return triangle;
}

/// A quadrilateral left without partner, and a triangle on three of its nodes also left without partner: the
/// two sides of that face do not conform.
void check_quadrilaterals(const Mesh& mesh, const std::vector<BoundaryFacet>& boundary, DefectLog& log) {
    std::vector<Triangle> triangles;
    for (const BoundaryFacet& facet : boundary) {
        if (facet.count() == 3) triangles.push_back(sorted(facet.nodes[0], facet.nodes[1], facet.nodes[2]));
    }
    std::sort(triangles.begin(), triangles.end());
    for (const BoundaryFacet& facet : boundary) {
        if (facet.count() == 3) continue;
        const NodeId* n = facet.nodes;
        for (int skip = 0; skip < 4; ++skip) {
            const Triangle half = sorted(n[(skip + 1) % 4], n[(skip + 2) % 4], n[(skip + 3) % 4]);
            if (!std::binary_search(triangles.begin(), triangles.end(), half)) continue;
            log.add(DefectKind::kFacetQuadrilateralTriangles, [&] { return facet_text(mesh, n, 4); });
            break;
        }
    }
}

}  // namespace

void check_boundary(const Mesh& mesh, const std::vector<BoundaryFacet>& boundary,
                    const std::vector<EdgeMiddle>& middles, DefectLog& log, CheckReport& report) {
    const EdgeFigures edges = count_edges(boundary.size(), [&](std::size_t i) { return boundary[i]; });
    report_open_edges(mesh, edges, DefectKind::kBoundaryOpen, log);
    report.nonmanifold_edges = edges.not_two;

    std::vector<NodeId> nodes;
    double total_area = 0;
    for (const BoundaryFacet& facet : boundary) {
        nodes.insert(nodes.end(), facet.nodes, facet.nodes + facet.count());
        total_area += middles.empty() ? area(mesh, facet) : area_between(mesh, facet, middles);
    }
    std::sort(nodes.begin(), nodes.end());
    const auto end = std::unique(nodes.begin(), nodes.end());
    report.boundary_area = total_area;
    report.euler_characteristic = (end - nodes.begin()) - static_cast<std::int64_t>(edges.edges) +
                                  static_cast<std::int64_t>(boundary.size());

    check_quadrilaterals(mesh, boundary, log);

    std::vector<BoundaryFacet> listed;
    for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
        if (mesh.facets.outside[i] != 0) continue;
        const NodeId* n = mesh.facets.nodes.data() + 4 * i;
        listed.push_back({{n[0], n[1], n[2], n[3]}});
    }
    const EdgeFigures list_edges = count_edges(listed.size(), [&](std::size_t i) { return listed[i]; });
    report_open_edges(mesh, list_edges, DefectKind::kListedOpen, log);
}

}  // namespace mortise::quality
