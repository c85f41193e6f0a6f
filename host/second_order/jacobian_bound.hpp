// A lower bound of the Jacobian of a curved element of second order.
//
// The element's map is that of its corners plus, for each edge, the edge's displacement (of its middle node
// from the middle between its ends) times the shape function of that node. In coordinates of the unit cube,
// collapsed for wedges, pyramids and tetrahedra, the Jacobian with respect to the reference element is a
// polynomial for all four types, so its Bernstein coefficients bound it from below. Source: Johnen, Remacle,
// Geuzaine, "Geometrical validity of curvilinear finite elements" (2013); pyramids: Bedrosian, "Shape
// functions and integration formulas for three-dimensional finite element analysis" (1992).
#pragma once

#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::second_order {

/// A lower bound of the Jacobian of an element with curved edges. `corners`: kElementNodes[type] points;
/// `displacements`: kElementEdges[type] vectors by local_edges().
double least_jacobian(ElementType type, const Vec3* corners, const Vec3* displacements);

/// Whether the Jacobian of a tetrahedron with curved edges is surely at least `share` of the straight one's:
/// a short test that most tetrahedra pass whose edges are curved a little.
bool is_surely_valid(const Vec3* corners, const Vec3* displacements, double share);

}  // namespace mortise::second_order
