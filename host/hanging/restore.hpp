// Hanging nodes: cells between others of different sizes, as hexahedra again.
//
// Such a cell's template is taken back where its elements are still those of the template, and what it shares
// with the cells around it allows that: a face that is one quadrilateral, or four that meet smaller elements,
// may stay as it is; one that is divided in another way, as only some of its edges are split, must be shared
// with a cell that is taken back, too. So a face of the mesh is conforming, or four against one; fronts of
// cells that reach other cells of their size at the boundary keep their templates.
#pragma once

#include <cstdint>

#include "host/common/leaf_grid.hpp"
#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::hanging {

/// Where the leaves of a graded tree lie.
struct Frame {
    Vec3 origin{};    ///< of the root box, model units
    double side = 0;  ///< its edge
    const LeafGrid* leaves = nullptr;
};

/// Cells that are hexahedra again.
struct Restored {
    Mesh mesh;
    std::uint64_t cells = 0;
};

/// The mesh with as many of its transition cells as possible as hexahedra of kind kTransition, at the end of
/// their block in Morton order; all other elements and facets stay, in their order. Nodes that nothing uses
/// any more are left out. The precondition is a conforming mesh; the result does not depend on threads.
Restored restore_cells(Mesh mesh, const Frame& frame, int threads);

}  // namespace mortise::hanging
