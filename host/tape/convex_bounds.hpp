// A box of a model from the convex sets that its parts lie in.
#pragma once

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Axis-aligned box that holds the solid: every intersection is put between the planes around its convex
/// surfaces (half-spaces, cylinders, cones, tori, rounded solids, wherever they stand), and linear programs
/// say how far it reaches; unions take the box around their parts. Infinite where it has no end, and where
/// nothing is known (formulas, complements of curved solids); some percent too large at curved surfaces.
/// Empty (a minimum above its maximum): no point can be solid.
Box3 convex_bounds(const CompiledModel& compiled);

}  // namespace mortise::tape
