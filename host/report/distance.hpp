// Distances between a mesh's facets and the surface of the solid, both ways, and angles of normals.
#pragma once

#include "host/report/leaves.hpp"
#include "mortise/quality.hpp"

namespace mortise::report {

/// From sample points of every facet (corners, middles of edges, points inside) to the facet's own surface,
/// by Newton's method along the gradient; and the angle between facet and surface normal. Formulas may jump
/// or be no number there: if Newton's method fails, or ends farther off than usual, the nearest change of
/// sign is looked for along lines, up to the facet's size; samples without either are counted only.
void report_facets(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                   const tape::BoundModel& model, int threads, QualityReport& report);

/// A point of the solid's boundary.
struct BoundaryPoint {
    Vector local;
    double weight = 1;  ///< in means: the square of its leaf's edge, in edges of the deepest leaves
};

/// Points of the solid's boundary in a leaf: where the region changes along three random lines, one along
/// each axis.
void sample_boundary(const tape::BoundModel& model, const Leaf& leaf, const Depth& depth,
                     std::vector<BoundaryPoint>& points);

/// From points to the nearest facet.
DistanceFigures distance_to_facets(const Mesh& mesh, const tape::BoundModel& model,
                                   const std::vector<BoundaryPoint>& points, int threads);

}  // namespace mortise::report
