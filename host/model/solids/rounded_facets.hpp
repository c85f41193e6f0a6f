// Rounded solids as points and flat faces: for sections, shadows, and hulls that are not rounded solids
// themselves.
#pragma once

#include <vector>

#include "host/model/outlines/contours.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Points on the surface whose hull stands for the solid, kFacets to a circle; flat faces are exact. Of a
/// column (and a plate without rounding) those at both heights.
std::vector<Vec3> points_of(const RoundedSolid& solid);

/// The same hull's faces as triangles; empty if it is flat.
TriangleSurface facets_of(const RoundedSolid& solid);

/// A column's outline, counter-clockwise.
std::vector<Vec2> outline_of(const RoundedSolid& solid);

/// A box that holds the solid; a column is unbounded along z.
Box3 box_of(const RoundedSolid& solid);

}  // namespace mortise::model_reader
