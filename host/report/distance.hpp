// Distances between a mesh's facets and the surface of the solid, both ways, and angles of normals.
#pragma once

#include "host/report/leaves.hpp"
#include "mortise/quality.hpp"

namespace mortise::report {

/// From sample points of every facet (corners, middles of edges, points inside) to the facet's own surface,
/// by Newton's method along the gradient; and the angle between facet and surface normal.
void report_facets(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                   const tape::BoundModel& model, int threads, QualityReport& report);

/// Points of the solid's boundary in a leaf: where the region changes along three random lines, one along
/// each axis.
void sample_boundary(const tape::BoundModel& model, const Leaf& leaf, std::vector<Vector>& points);

/// From points (box-local) to the nearest facet.
DistanceFigures distance_to_facets(const Mesh& mesh, const tape::BoundModel& model, int level,
                                   const std::vector<Vector>& points, int threads);

}  // namespace mortise::report
