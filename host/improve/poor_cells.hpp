// Which cells hold poor elements.
#pragma once

#include <cstdint>
#include <vector>

#include "host/improve/places.hpp"

namespace mortise::improve {

/// Rounding of volumes (tetrahedron_quality) in a tree whose finest leaves have this size class.
double volume_rounding(const CellFrame& frame, int finest_class);

/// Cells of the elements of less quality than `least`, and of those with an edge too short for them,
/// ascending; only new elements are looked at. Of `places` only node_class is used.
std::vector<CellId> poor_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                               const Places& places, double rounding, double least, int threads,
                               const Known& known = {});

/// Elements of less quality than `least`.
std::uint64_t count_below(const Mesh& mesh, const CellFrame& frame, double least, int threads);

}  // namespace mortise::improve
