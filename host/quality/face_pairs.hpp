// Whether the faces of a mesh fit together, cheaply enough for every run.
#pragma once

#include "mortise/mesh.hpp"

namespace mortise::quality {

/// Whether the faces of the elements lie in opposite pairs, but for those that are the outer boundary's
/// facets, in their order: each face counts with a hash of its nodes, negative the other way round, and the
/// sum must vanish. One pass and no memory; check_mesh tells which faces do not fit. Precondition: node
/// numbers are in range. A mesh that is not conforming passes by chance once in 2^60 times or less.
bool faces_are_paired(const Mesh& mesh, int threads);

}  // namespace mortise::quality
