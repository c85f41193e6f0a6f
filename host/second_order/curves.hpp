// Where the middles of edges on the model lie.
#pragma once

#include <cstdint>
#include <vector>

#include "host/second_order/edges.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::second_order {

/// An edge of a facet, and how it is curved.
struct CurvedEdge {
    std::size_t edge;   ///< number in Edges
    Vec3 displacement;  ///< of its middle from the middle between its ends, model units; not zero
};

/// The edges of facets that are not straight on the model, ascending.
std::vector<CurvedEdge> find_curved_edges(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                          const tape::BoundModel& model, const Edges& edges, int threads);

}  // namespace mortise::second_order
