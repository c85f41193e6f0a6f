// One piece of the mesh: extraction and assembly of one Morton range.
#pragma once

#include "host/assembly/assembly.hpp"
#include "host/pipeline/prepare.hpp"

namespace mortise::pipeline {

/// How many pieces keep each array that the device sees below its largest allocation, bytes: nodes of
/// hexahedra, and coordinates.
std::uint64_t pieces_needed(const octree::Octree& tree, std::uint64_t largest);

/// Code before which the first p of `count` pieces with about as many leaves each end.
std::uint64_t piece_end(const octree::Octree& tree, std::uint64_t p, std::uint64_t count);

/// Makes the piece of a range; `extracted` counts it. `progress` from `begin` to `end`. `arena`: as
/// assembly::Input::arena.
assembly::Piece make_piece(device::Device& device, const MeshOptions& options, Prepared& prepared,
                           const octree::InRegions& in_regions, const assembly::MortonRange& range,
                           Stages& stages, double begin, double end, Extracted& extracted,
                           assembly::Arena* arena = nullptr);

}  // namespace mortise::pipeline
