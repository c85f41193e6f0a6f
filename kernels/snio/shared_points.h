// Which leaf finds a point that several have in common (points.cl): the first of those that agree about the
// surface, by its place around the vertex or edge.
#ifndef MORTISE_SNIO_SHARED_POINTS_H
#define MORTISE_SNIO_SHARED_POINTS_H

#include "shared/snio.h"
#include "shared/surface.h"
#include "shared/tree.h"

// Whether leaves share the points of a surface.
static int is_shared(__global const Surface* surface) { return surface->kind == kSurfaceExpression; }

// Whether a leaf has the point as well: a simple one of the same size and surface.
static int has_point(__global const SnioCandidate* candidates, uint surface, int level, const Leaf leaf) {
    return leaf.kind == kLeafNio && leaf.level == level &&
           (candidates[leaf.index].flags & kCandidateSimple) != 0 &&
           candidates[leaf.index].surface == surface;
}

// Place (leaf_at_vertex) around the leaf's corner c of the first leaf that has this vertex; `own`: none is
// before this one.
static uint first_at_corner(const Tree* tree, __global const SnioCandidate* candidates, uint surface,
                            ulong code, int level, uint c, uint* first) {
    const BorderCells cells = border_cells(tree, code, level);
    for (uint d = 0; d < 7 - c; ++d) {
        const Leaf leaf = leaf_at_corner(tree, &cells, c, d);
        if (!has_point(candidates, surface, level, leaf)) continue;
        *first = leaf.index;
        return d;
    }
    return 7 - c;
}

// The same for edge e and the leaves of leaf_at_edge.
static uint first_at_edge(const Tree* tree, __global const SnioCandidate* candidates, uint surface,
                          ulong code, int level, uint e, uint* first) {
    const BorderCells cells = border_cells(tree, code, level);
    for (uint d = 0; d < 3 - (e & 3); ++d) {
        const Leaf leaf = leaf_at_edge(tree, &cells, e, d);
        if (!has_point(candidates, surface, level, leaf)) continue;
        *first = leaf.index;
        return d;
    }
    return 3 - (e & 3);
}

#endif
