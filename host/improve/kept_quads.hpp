// The quadrilaterals between the zone and the elements left alone.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/improve/places.hpp"

namespace mortise::improve {

/// The four nodes of a quadrilateral, ascending.
using QuadKey = std::array<NodeId, 4>;

/// An element of the mesh that the zone takes.
struct ElementRef {
    std::uint8_t type;
    std::size_t index;
    CellId cell;
    std::uint8_t kept;  ///< bit f: the quadrilateral face f stays whole
};

/// The quadrilateral facets of the outer boundary, ascending; of a uniform tree those near the set.
/// Of `known` gone facets and chunks of facets are looked at.
std::vector<QuadKey> outer_quads(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int threads,
                                 Known& known);

/// Those on held surfaces (Options::held; null: none), ascending.
std::vector<QuadKey> held_quads(const Mesh& mesh, const std::vector<std::uint8_t>* held);

/// Marks the quadrilaterals that stay whole: held ones, and those that an element outside also has. `outer`
/// and `held` from the functions above.
void mark_kept_quads(const Mesh& mesh, const std::vector<QuadKey>& outer, const std::vector<QuadKey>& held,
                     int threads, std::vector<ElementRef>& elements);

}  // namespace mortise::improve
