// Second order: a node in the middle of each edge, on the model where the edge lies on it.
//
// An edge of facets is curved onto their surfaces: one (a face), two (a crease). It stays straight where its
// ends do not lie on them (nodes beside the model, features finer than cells), where Newton's method does not
// reach them within a quarter of the edge's length, and inside regions. Elements whose Jacobian a bound does
// not tell positive (jacobian_bound.hpp) have their edges bent half as far, a quarter, an eighth, then
// straight: a valid mesh of first order stays valid. Everything is decided by an edge alone, or for all
// elements at once; no order matters.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"
#include "mortise/quality.hpp"

namespace mortise::second_order {

struct Counts {
    std::uint64_t nodes = 0;    ///< in the middles of edges
    std::uint64_t curved = 0;   ///< edges that are not straight
    std::uint64_t relaxed = 0;  ///< edges that lie beside the model for the sake of the elements at them
};

/// Gives a mesh of first order the nodes of second order; `features` tell which of them lie on creases, and
/// their model_dimension gets the new nodes, too. `facet_surface`: by facet, the surface of the model. Throws
/// Error(kMeshing) if there are too many nodes.
Counts raise_order(Mesh& mesh, const std::vector<std::uint32_t>& facet_surface, const tape::BoundModel& model,
                   Features& features, int threads);

}  // namespace mortise::second_order
