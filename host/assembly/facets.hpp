// Facets of the certificate's cells: between regions inside a cell, and where the two sides of a cell face
// differ.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/assembly/nodes.hpp"

namespace mortise::assembly {

/// One boundary or interface facet, ready for Mesh::facets.
struct AssembledFacet {
    std::array<NodeId, 4> node;  ///< outward from `inside`; a triangle repeats its last node
    std::uint32_t surface;       ///< surface of the bound model
    std::uint16_t inside;
    std::uint16_t outside;
};

/// Facets that leaf `nio` (a CNIO leaf) contributes; each facet of the mesh is contributed by one leaf.
///
/// Between two CNIO cells a facet belongs to the cell of its region `inside`; else to the CNIO cell. Both
/// sides list the facets of their common face in the same order, so they are compared one by one.
void facets_of(const Input& input, const CnioCells& cells, const NodeLookup& lookup, std::uint32_t nio,
               std::vector<AssembledFacet>& out);

/// Corners of whole faces of a CNIO leaf behind which it has no volume, but the template or IN leaf beyond
/// has: the leaf lists these facets and counts among the users of their corners, so that no piece names nodes
/// of later ones. A set; the leaf's own record must be there, those beyond need not.
std::uint32_t corners_of_facets(const Input& input, const CnioCells& cells, std::uint32_t nio);

}  // namespace mortise::assembly
