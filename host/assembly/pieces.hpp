// Neighbourhoods of Morton ranges.
#pragma once

#include "host/assembly/assembly.hpp"

namespace mortise::assembly {

/// Whether one of the up to 26 neighbours of a cell lies on the other side of the range's ends than the cell
/// itself.
bool touches_outside(int level, const MortonRange& range, std::uint64_t morton);

}  // namespace mortise::assembly
