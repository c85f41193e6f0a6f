// Random CSG models with a large share of special positions. Lengths are such that a cell of a level-5 mesh
// is about 1, before the model as a whole is scaled and moved.
#pragma once

#include <cstdint>
#include <string>

#include "mortise/model.hpp"

namespace mortise::test {

struct RandomModel {
    Model model;
    std::string style;  ///< which recipe made it
};

/// The same seed gives the same model on every platform, up to the rounding of sin and cos.
RandomModel make_random_model(std::uint64_t seed);

/// Rounded solids with others, many with faces in common.
RandomModel make_random_hulls(std::uint64_t seed);

}  // namespace mortise::test
