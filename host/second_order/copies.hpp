// Edges of periodic planes (Mesh::periodic): copies are curved as their originals, and their middles are
// pairs.
#pragma once

#include <cstddef>
#include <vector>

#include "host/second_order/curves.hpp"
#include "host/second_order/edges.hpp"
#include "mortise/mesh.hpp"

namespace mortise::second_order {

/// An edge of a second plane, and that of the first which it is a copy of.
struct EdgeCopy {
    std::size_t copy;
    std::size_t original;
    std::size_t pair;  ///< index into Mesh::periodic
};

/// All of them, pair by pair, by the number of the copy.
std::vector<EdgeCopy> find_edge_copies(const Mesh& mesh, const Edges& edges);

/// Gives copies the displacements of their originals, within the plane.
void copy_curves(const Mesh& mesh, const std::vector<EdgeCopy>& copies, std::vector<CurvedEdge>& curved);

/// Adds the middles to Mesh::periodic; the first edge's has the number `corners`.
void pair_middles(const std::vector<EdgeCopy>& copies, std::size_t corners, Mesh& mesh);

}  // namespace mortise::second_order
