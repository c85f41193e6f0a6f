// The triangles of a patch (kernels/shared/patch.h) that lie in a cell.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"

namespace mortise::sizing {

enum class PatchState : std::uint8_t { kAbsent, kSteady, kTurning };

/// Whether the patch has triangles in the closed cell, and their normals lie within about 45° of one
/// direction: then it is a graph there, with no second sheet.
PatchState patch_in(const tape::BoundModel& model, std::uint32_t surface, const tape::Cell& cell);

}  // namespace mortise::sizing
