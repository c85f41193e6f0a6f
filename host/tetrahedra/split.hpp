// All-tetrahedral meshes: every element of a mixed mesh split, conformingly.
//
// Every element is coned from its node of lowest number over its faces that do not hold it; every
// quadrilateral is cut by the diagonal through its own lowest node. Both neighbours of a face cut it alike,
// and no node is needed (Dompierre, Labbé, Vallet, Camarero 1999). An element with curved faces for which
// this would turn a tetrahedron over gets one node at its centre instead, with the same faces.
#pragma once

#include "mortise/mesh.hpp"

namespace mortise::tetrahedra {

/// Splits all elements and facets. Regions, kinds, facet surfaces and the order of elements carry over.
/// Nodes are compared by `rank`, then by number; null: by number alone. Faces whose nodes have the same ranks
/// are cut alike. Throws Error(kMeshing) if an element cannot be split into positive tetrahedra even from its
/// centre.
Mesh split(const Mesh& mesh, const std::vector<NodeId>* rank = nullptr);

}  // namespace mortise::tetrahedra
