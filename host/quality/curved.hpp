// Elements of second order: the Jacobian at many points, and the volume.
//
// The shape functions are found as what they are known for: each is 1 at its node, 0 at the others, and a sum
// of the type's basis: powers of the coordinates (serendipity), and for the pyramid three of them over its
// height (Bedrosian 1992).
#pragma once

#include "host/quality/jacobian.hpp"

namespace mortise::quality {

/// Nodes in the middles of edges, by local_edges(); slots beyond their count stay zero.
struct Middles {
    Vector p[12];
};

/// Whether an edge is not straight, or its middle node not half-way: by more than rounding.
bool is_curved(ElementType type, const Corners& corners, const Middles& middles);

/// `positive` and `minimum` are of 125 points, the ends of edges and their middles among them, and of those
/// of the quadrature; the volume is exact but for rounding.
JacobianFigures curved_figures(ElementType type, const Corners& corners, const Middles& middles);

/// Area of a facet of three or four corners, with the middle of the edge from each to the next: by 6 × 6
/// Gauss points.
double curved_area(const Vector* corners, const Vector* middles, int count);

}  // namespace mortise::quality
