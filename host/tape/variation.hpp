// Small normal variation: the test that tells a leaf which a smooth surface merely grazes from one that may
// hide a whole feature of it.
#pragma once

#include <cstdint>

#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"

namespace mortise::tape {

/// Whether no two normals of a surface's level sets in the closed cell are 90° or more apart, by bounds of
/// the gradient (Plantinga & Vegter 2004). Then the surface is a graph there: it has no closed component in
/// the cell, no two sheets and no axis, and what the cell's samples miss of it is a shallow cap. May say no
/// where it is so, never yes where it is not.
bool has_small_variation(const BoundModel& model, std::uint32_t surface, const Cell& cell);

/// Box that holds a surface's gradients over the closed cell; planes and patches: none, false.
struct GradientBox {
    double low[3];
    double high[3];
};
bool gradient_box(const BoundModel& model, std::uint32_t surface, const Cell& cell, GradientBox& box);

/// From the surface's own frame to box-local coordinates.
GradientBox to_local(const Surface& surface, const GradientBox& gradient);

/// Whether the inner product of any two vectors of the box is positive. Ends that are not numbers: no.
bool keeps_direction(const GradientBox& box);

}  // namespace mortise::tape
