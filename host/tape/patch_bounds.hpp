// What a cell knows of a patch (kernels/shared/patch.h): bounds by its triangles.
#pragma once

#include <cstdint>

#include "host/tape/reference.hpp"
#include "host/tape/variation.hpp"

namespace mortise::tape {

/// Sign of a patch over a cell that lies away from its triangles: -1, +1; 0: it may pass.
int classify_patch(const BoundModel& model, std::uint32_t surface, const Cell& cell);

/// Box of the unit normals, in the patch's own frame, of the triangles that meet the closed cell; false if
/// there are none.
bool patch_normals(const BoundModel& model, std::uint32_t surface, const Cell& cell, GradientBox& box);

}  // namespace mortise::tape
