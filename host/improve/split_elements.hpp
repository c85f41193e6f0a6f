// The zone's elements as tetrahedra and, where a quadrilateral stays whole, pyramids.
#pragma once

#include <cstdint>
#include <vector>

#include "host/improve/kept_quads.hpp"
#include "host/improve/places.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Splits each element into cones from its lowest node, or from a new one at its centroid: the elements of
/// the zone, which has none yet. Appends the new nodes to the zone's. Returns the cells of the elements that
/// cannot be split, in order; these are not in the zone then. `place`: the zone's nodes, all that the
/// elements have among them. The result does not depend on the threads.
std::vector<CellId> split_elements(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                                   const std::vector<ElementRef>& elements, const ZoneNodes& place,
                                   int threads, Zone& zone);

}  // namespace mortise::improve
