// All-tetrahedral meshes: every element of a mixed mesh split, conformingly.
//
// Every element is coned from its node of lowest number over its faces that do not hold it; every
// quadrilateral is cut by the diagonal through its own lowest node. Both neighbours of a face cut it alike,
// and no node is needed (Dompierre, Labbé, Vallet, Camarero 1999). An element with curved faces for which
// this would turn a tetrahedron over gets one node at its centre instead, with the same faces.
#pragma once

#include "host/common/index_run.hpp"
#include "mortise/mesh.hpp"

namespace mortise::tetrahedra {

/// Splits all elements and facets. Regions, kinds, facet surfaces and the order of elements carry over.
/// Hexahedra of kind kIn must be cubes. `cube_pieces`, if wanted, receives the tetrahedra they are split
/// into. Nodes are compared by `rank`, then by number; null: by number alone. Faces whose nodes have the same
/// ranks are cut alike. `threads` host threads, 0: all cores; the result does not depend on them. Throws
/// Error(kMeshing) if an element cannot be split into positive tetrahedra even from its centre. `old`, if
/// not null: a mesh that nobody needs; its tetrahedra's memory is used, and it gets that of the elements
/// that were split.
Mesh split(Mesh mesh, int threads, const std::vector<NodeId>* rank = nullptr,
           IndexRuns* cube_pieces = nullptr, Mesh* old = nullptr);

}  // namespace mortise::tetrahedra
