// Surfaces of the primitives that are one smooth surface of a closed form.
#pragma once

#include "kernels/shared/surface.h"
#include "mortise/model.hpp"

namespace mortise::tape {

/// Gives a surface, whose map takes model coordinates to those of the primitive, the primitive's shape: a
/// sphere's, a cylinder's, a cone's or a torus'.
void set_shape(const Primitive& primitive, Surface& surface);

}  // namespace mortise::tape
