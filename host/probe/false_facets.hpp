// Facets of the finished mesh where the model has no boundary: the film that closes a hole, the ends of a bar
// that is torn.
//
// Templates and certificate know a surface by its signs at samples. A surface that folds back within a cell
// may be seen by some of them and lost beside them, which no look at the samples tells. But then facets lie
// deep in the solid or outside of it, and the model itself tells that.
#pragma once

#include <cstdint>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::probe {

/// Facets with a point around which the model is the same in all directions, with a film behind it through
/// which it stays so, joined where they lie within a cell of each other. `folded`: codes of the leaves to
/// look at (Probe::folded); `points` of the facets' nodes, model units. Features are lost, in the order of
/// their first facets.
std::vector<MissedFeature> find_false_facets(const tape::BoundModel& model, const octree::Octree& tree,
                                             const std::vector<std::uint64_t>& folded,
                                             const std::vector<double>& points, const FacetBlock& facets,
                                             int threads);

}  // namespace mortise::probe
