// The spatial table: solids that are given by triangles, as formulas over planes that hold in one cell each.
//
// A polyhedron has no short formula over its planes, but it has one in every cell that few of them cross. So
// it is divided by an octree over the root cube, in step with the descent: the tape names the node of the
// cell, and where the cell is split, each child takes its own entry.
//
// A node is eight words, the entry of child c (Morton order) at place + c:
//   kSpatialOut, kSpatialIn       the closed child holds no triangle
//   kSpatialFormula | place       a formula: its number of words, then words of a tape (literals, and, or)
//   place                         the child's own node; never 0 or 1
#ifndef MORTISE_SHARED_SPATIAL_H
#define MORTISE_SHARED_SPATIAL_H

#include "platform.h"
#include "tape.h"

#define kSpatialOut 0u
#define kSpatialIn 1u
#define kSpatialFormula 0x80000000u

// The word of the complement.
MORTISE_FUNCTION u32 negate_word(u32 word) {
    const u32 operation = tape_operation(word);
    if (operation == kTapeAnd) return make_operation(kTapeOr, 0, 0);
    if (operation == kTapeOr) return make_operation(kTapeAnd, 0, 0);
    return word ^ (1u << 28);
}

#endif
