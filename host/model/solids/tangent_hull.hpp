// The hull of solids some of which are round, as a polytope of many facets.
#pragma once

#include <optional>
#include <vector>

#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/convex_pieces.hpp"

namespace mortise::model_reader {

/// Facets of a full circle in hulls of discs, cylinders and cones; of spheres kFacets.
inline constexpr int kDiscFacets = 192;

/// The hull of the pieces' points: those given, and points all around the round pieces. Planes that touch one
/// point of each round piece are the hull's own to rounding, whatever the number of facets: parts of models
/// often share them. Nothing if the hull is flat.
std::optional<Polytope> tangent_hull(const std::vector<ConvexPiece>& pieces);

}  // namespace mortise::model_reader
