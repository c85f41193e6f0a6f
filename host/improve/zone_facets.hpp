// Which faces of the zone's tetrahedra are facets of the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/improve/zone.hpp"

namespace mortise::improve {

/// The two triangles of a quadrilateral, cut through its lowest node of the mesh.
std::array<std::array<NodeId, 3>, 2> halves(const NodeId* node);

/// Facets with a node in the zone, ascending. Fills in the facets' chunks of `known`.
std::vector<std::uint32_t> find_near_facets(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                                            const ZoneNodes& place, int threads, Known& known);

/// Tags the faces of the zone's tetrahedra that are facets of the mesh, and marks the facets that the zone
/// takes (Zone::facets_taken, Gone::facet). `held` as Options::held. `place`: the zone's nodes; `near_facets`
/// from the function above. Needs Zone::stratum. The result does not depend on `threads`.
void tag_faces(const Mesh& mesh, const ZoneNodes& place, const std::vector<std::uint32_t>& near_facets,
               const std::vector<std::uint8_t>* held, int threads, std::vector<std::uint8_t>& is_gone,
               Zone& zone);

}  // namespace mortise::improve
