// Regions that overlap. The mesh does not show it, since a point belongs to the first region that holds it;
// so the regions' own formulas are asked, in the cells where two of them may hold.
#pragma once

#include <cstdint>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"

namespace mortise::probe {

struct Overlap {
    std::int32_t first = 0;   ///< regions, from 1; the first has what both claim
    std::int32_t second = 0;  ///< more than `first`
    Vec3 at{};                ///< a point in both, in model coordinates
    double depth = 0;         ///< about how deep in both it lies, model units
};

/// Each pair of regions that overlap once, ascending. The same result for any number of threads.
///
/// Found for certain are overlaps that hold a ball of a leaf's diagonal, thinner ones, as between two
/// surfaces, as a rule. Regions that only touch are none: what is less deep than 1e-6 of the root box is
/// rounding.
std::vector<Overlap> find_overlaps(const tape::BoundModel& model, const octree::Octree& tree, int threads);

}  // namespace mortise::probe
