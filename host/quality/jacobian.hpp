// The Jacobian determinant of an element over its whole volume: is it positive everywhere, and its integral.
//
// Element maps: hexahedron trilinear; wedge linear on the triangle times linear in height; pyramid
// (1 - w) Q(u, v) + w apex with a bilinear base Q; tetrahedron affine. Adjoining elements of any two types
// map a shared face alike, so volumes add up without gaps.
//
// "Positive" means above the rounding noise of the determinant: 1e-14 times the product of the lengths of its
// three vectors (about 45 units of roundoff; coordinates are taken as exact).
#pragma once

#include "host/quality/vector.hpp"

namespace mortise::quality {

struct JacobianFigures {
    bool positive = false;
    double minimum = 0;  ///< where not positive: the smallest value or bound found, else a lower bound
    double volume = 0;   ///< integral of the Jacobian, exact for the maps above up to rounding
};

JacobianFigures jacobian_figures(ElementType type, const Corners& corners);

}  // namespace mortise::quality
