// The models that the benchmark meshes, by name.
#pragma once

#include <string>

#include "mortise/model.hpp"

namespace mortise::bench {

/// "sphere" (radius 1), "halves" (a cube of two regions), "lattice" (10 × 10 × 10 cells of
/// struts), "random:N" (N random primitives, the same at every
/// call), "bracket" (the asset), or the path of a model file. Throws Error(kUsage) for a count that is not a
/// positive number.
Model make_model(const std::string& name);

}  // namespace mortise::bench
