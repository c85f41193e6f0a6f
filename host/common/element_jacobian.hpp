// Jacobians of elements with straight edges: a bound of the least one, and the worst corner.
#pragma once

#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise {

/// A lower bound of the Jacobian, that of tetrahedra and pyramids exactly; positive: the element is valid.
/// `corners`: kElementNodes[type] points. The Jacobian is a polynomial, of hexahedra and wedges in
/// Bernstein's form of degree 2 along each axis of the cube, 1 in the wedge's triangle; its coefficients
/// bound it (Johnen, Remacle, Geuzaine, "Geometrical validity of curvilinear finite elements", 2013).
double least_straight_jacobian(ElementType type, const Vec3* corners);

/// The least triple product of unit edges at a corner, a pyramid's apex left out: as scaled_jacobians() of
/// mortise/check.hpp; 0 where an edge has no length.
double least_scaled_jacobian(ElementType type, const Vec3* corners);

}  // namespace mortise
