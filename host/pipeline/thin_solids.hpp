// Thin rounded solids with a surface for each side.
#pragma once

#include <optional>

#include "mortise/model.hpp"

namespace mortise::pipeline {

/// A plate whose rim is round is one smooth surface (RoundedSolid), of which a cell sees both sides at once
/// or neither: where it is not much thicker than cells the mesh falls apart. Such a solid K, convex, is the
/// intersection of K swept along its thin direction and K swept the other way, whose surfaces lie on one side
/// each and touch along the rim.
///
/// The same solids, with rounded ones thinner than `thickness` (model units), and twice as wide at least,
/// parted so; none if there is nothing to part.
std::optional<Model> part_thin_solids(const Model& model, double thickness);

}  // namespace mortise::pipeline
