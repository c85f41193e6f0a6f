// Small pieces of the finished mesh that the model does not have apart: what cells show of a pin that is
// thinner than they are, and closed hollows where a hole goes on.
//
// Samples may see a thin pin here and there. Where they do, cells hold what they saw, with true facets around
// it and nothing between: no cell is wrong by itself, and no facet false (false_facets.hpp). But then the
// mesh has a small piece on its own, and the model tells whether it goes on beyond it. Not all small
// pieces are looked at: thick ones are bodies of their own, and so is the largest of each region.
#pragma once

#include <cstdint>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::probe {

/// Pieces of a region, and hollows in the solid, that few facets bound, where the model goes on beyond them:
/// what is there, how long the piece is, how thick the model; by their lowest facets. `points` of the facets'
/// nodes, model units. Those of the `missed` features around which the mesh has such a piece that the model
/// has, too, are kept.
std::vector<MissedFeature> find_torn_pieces(const tape::BoundModel& model, const octree::Octree& tree,
                                            const std::vector<double>& points, const FacetBlock& facets,
                                            int threads, std::vector<MissedFeature>& missed);

}  // namespace mortise::probe
