// Decompositions of a cell's inside part without a new node: exact cover by backtracking.
//
// The state is the set of open facets, each still waiting for the element behind it. The facet with the
// fewest elements that fit is filled next; branches whose rank cannot beat the best one found are cut off.
// Elements that are positive and whose facets close up to exactly the given boundary cannot overlap, since
// the boundary's winding number is 1.
#pragma once

#include <optional>
#include <vector>

#include "host/templates/rank.hpp"

namespace mortise::templates {

/// The best decomposition for each boundary; none where no decomposition exists. Each boundary holds the
/// pattern's face meshes and facets of the surface. If the surface is planar at every sample (a separable
/// pattern), elements with a facet in it must use one of the given ones.
std::vector<std::optional<Candidate>> best_tilings(Pattern pattern, bool planar_surface,
                                                   const std::vector<std::vector<Facet>>& boundaries,
                                                   const std::vector<Positions>& positions);

}  // namespace mortise::templates
