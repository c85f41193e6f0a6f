// All-tetrahedral meshes: every element of a mixed mesh split, conformingly.
//
// Every element is coned from its node of lowest number over its faces that do not hold it; every
// quadrilateral is cut by the diagonal through its own lowest node. Both neighbours of a face cut it alike,
// and no node is needed (Dompierre, Labbé, Vallet, Camarero 1999). An element with curved faces for which
// this would turn a tetrahedron over gets one node at its centre instead, with the same faces.
//
// Cubes, which are most of a large mesh, can be left for last: what is made better in between deals with a
// tenth of the elements.
#pragma once

#include "host/common/index_run.hpp"
#include "mortise/mesh.hpp"

namespace mortise::tetrahedra {

/// Splits all elements but cubes (hexahedra of kind kIn), and all facets. Regions, kinds, facet surfaces and
/// the order of elements carry over. Nodes are compared by `rank`, then by number; null: by number alone.
/// Faces whose nodes have the same ranks are cut alike; cubes with nodes whose rank is not their number are
/// split, too. `followed`, cubes, is brought up to date; it may be null. `threads` host threads, 0: all
/// cores; the result does not depend on them. Throws Error(kMeshing) if an element cannot be split into
/// positive tetrahedra even from its centre.
Mesh split_around_cubes(Mesh mesh, int threads, const std::vector<NodeId>* rank = nullptr,
                        IndexRuns* followed = nullptr);

/// Splits the cubes of a mesh whose other elements are tetrahedra: their pieces come first, six for each.
/// `sixths`, if wanted, receives those of them that are alike: three edges along the axes one behind the
/// other, as long as the cube's, of all cubes but those in `moved`. `old`, if not null: a mesh that nobody
/// needs; its tetrahedra's memory is used, and it gets that of the cubes.
Mesh split_cubes(Mesh mesh, int threads, const IndexRuns& moved = {}, IndexRuns* sixths = nullptr,
                 Mesh* old = nullptr);

}  // namespace mortise::tetrahedra
