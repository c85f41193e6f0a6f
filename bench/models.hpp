// The models that the benchmark meshes, by name.
#pragma once

#include <cstdint>
#include <string>

#include "mortise/model.hpp"

namespace mortise::bench {

/// "sphere" (radius 1), "halves" (a cube of two regions), "lattice" (10 × 10 × 10 cells of struts),
/// "random:N" (N random primitives, the same at every call), "bracket" (the asset), or the path of a model
/// file. Throws Error(kUsage) for a count that is not a positive number.
Model make_model(const std::string& name);

/// The text of a `.csg` file: a base plate, an upright plate and a boss, of random sizes, with a hole through
/// each; about 10,000 elements in cells of kRandomBracketCell. The same for the same number.
std::string random_bracket(std::uint32_t number);

inline constexpr const char* kRandomBracketCell = "0.18";

}  // namespace mortise::bench
