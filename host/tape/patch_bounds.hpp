// What a cell knows of a patch (kernels/shared/patch.h): bounds by its triangles.
#pragma once

#include <cstdint>

#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"

namespace mortise::tape {

/// Sign of a patch over a cell that lies away from its triangles: -1, +1; 0: it may pass. Beyond its rim,
/// where a patch is no distance, right within some cells of it.
int classify_patch(const BoundModel& model, std::uint32_t surface, const Cell& cell);

enum class PatchState : std::uint8_t { kAbsent, kSteady, kTurning };

/// Whether the patch has triangles in the closed cell, and their normals lie within about 45° of one
/// direction: then it is a graph there, with no second sheet.
PatchState patch_in(const BoundModel& model, std::uint32_t surface, const Cell& cell);

}  // namespace mortise::tape
