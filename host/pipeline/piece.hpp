// One piece of the mesh: extraction and assembly of one Morton range.
#pragma once

#include "host/assembly/assembly.hpp"
#include "host/pipeline/prepare.hpp"

namespace mortise::pipeline {

/// Makes the piece of a range; `extracted` counts it. `progress` from `begin` to `end`.
assembly::Piece make_piece(device::Device& device, const MeshOptions& options, Prepared& prepared,
                           const octree::InRegions& in_regions, const assembly::MortonRange& range,
                           Stages& stages, double begin, double end, Extracted& extracted);

}  // namespace mortise::pipeline
