// Boxes around surfaces' halves, to find where a model lies before it is bound to a root box.
#pragma once

#include <limits>

#include "kernels/shared/surface.h"
#include "mortise/model.hpp"

namespace mortise::tape {

/// Axis-aligned box around the half f <= 0 of a surface in model units (f >= 0 if `negated`), infinite where
/// the half is or where nothing is known.
Box3 half_bounds(const Surface& surface, bool negated);

/// A distance from the origin within which the surface shows its shape.
double reach(const Surface& surface);

/// Axis-aligned box around the image of a box, which may be infinite.
Box3 map_box(const Box3& box, const Affine& map);

/// Intersection; empty boxes have a minimum above their maximum.
void shrink(Box3& box, const Box3& by);

/// The box around both; kNothing changes nothing.
void grow(Box3& box, const Box3& by);

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr Box3 kEverything{{-kUnbounded, -kUnbounded, -kUnbounded}, {kUnbounded, kUnbounded, kUnbounded}};
constexpr Box3 kNothing{{kUnbounded, kUnbounded, kUnbounded}, {-kUnbounded, -kUnbounded, -kUnbounded}};

}  // namespace mortise::tape
