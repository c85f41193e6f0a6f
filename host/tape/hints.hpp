// Hints and periodic pairs of a model, from primitives to the surfaces that they have got.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Fills CompiledModel::hints and periodic. `surface_node`: per surface the primitive that it is of.
void find_hints(const Model& model, const std::vector<std::uint32_t>& surface_node, CompiledModel& compiled);

}  // namespace mortise::tape
