// Neighbourhoods of Morton ranges.
#pragma once

#include "host/assembly/assembly.hpp"

namespace mortise::assembly {

/// Room for one node more for this many: improvement adds some, and need not move the others then.
inline constexpr std::uint64_t kSpareNodes = 16;

/// Whether a place around a leaf, of its own size, or a leaf there, reaches beyond the range's ends, seen
/// from the leaf.
bool touches_outside(const octree::Octree& tree, const MortonRange& range, std::uint64_t code);

/// Codes, ascending, of the meshed leaves of the range that touch others outside it.
std::vector<std::uint64_t> border_leaves(const octree::Octree& tree, const MortonRange& range, int threads);

}  // namespace mortise::assembly
