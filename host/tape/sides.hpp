// The sides of a model's solids: surfaces that are joined by one operation.
#pragma once

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Fills CompiledModel::sides and sides_of from the tape.
void find_sides(CompiledModel& model);

}  // namespace mortise::tape
