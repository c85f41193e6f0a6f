// Which grid vertices beside complex leaves are snapped (docs/design/snapping.md).
#pragma once

#include <cstdint>
#include <vector>

#include "host/octree/octree.hpp"

namespace mortise::snapping {

/// Vertices of the leaves `complex` that snap, ascending by code. `strict`: leaves none of whose vertices do.
/// Both are indices into Octree::nio, ascending.
std::vector<octree::SnappedVertex> find_snapped(const tape::BoundModel& model, const octree::Octree& tree,
                                                const std::vector<std::uint32_t>& complex,
                                                const std::vector<std::uint32_t>& strict, int threads);

}  // namespace mortise::snapping
