// The quality report of a mesh against its model.
//
// Nothing here is used to make meshes: leaves, points and corners of the solid are found anew, by the host
// reference of the classification and by Newton's method. Samples come from a generator of our own with fixed
// seeds; results do not depend on the number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "host/common/leaf_grid.hpp"
#include "host/tape/compile.hpp"
#include "mortise/quality.hpp"

namespace mortise::report {

struct Options {
    int level = 6;  ///< of the finest leaves of the tree that made the mesh: the unit of distances
    int worst = kWorstElements;
    int threads = 0;                   ///< 0: all cores
    const LeafGrid* leaves = nullptr;  ///< null or empty: a uniform tree
};

/// The whole report of a named mesh; facet_surface[i] is facet i's surface in `model`.
QualityReport assess(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                     const tape::BoundModel& model, const Features& features, const Options& options);

}  // namespace mortise::report
