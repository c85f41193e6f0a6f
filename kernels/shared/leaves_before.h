// Ownership (tree.h) in a uniform tree, asked of the leaves around instead of the nodes: of the leaves that
// share a node and use it the Morton-first one owns it, so a leaf owns what none of those before it uses, and
// each of these tells of up to eight nodes at once.
#ifndef MORTISE_SHARED_LEAVES_BEFORE_H
#define MORTISE_SHARED_LEAVES_BEFORE_H

#include "tree.h"

// A leaf around another that may be before it: `step` is its place among BorderCells along each axis,
// `across` the axes along which it lies behind or ahead; `shared` are the other's nodes (bits as in masks)
// that both have.
typedef struct LeafBefore {
    u8 step[3];
    u8 across;
    u32 shared;
} LeafBefore;

#define kLeavesBefore 19
// Those behind along all axes that they are across are before, others only at some codes.
MORTISE_TABLE LeafBefore kLeafBefore[kLeavesBefore] = {
    {{0, 1, 1}, 1, 0x55055}, {{1, 0, 1}, 2, 0x30533}, {{1, 1, 0}, 4, 0x0330f}, {{0, 0, 1}, 3, 0x10011},
    {{0, 1, 0}, 5, 0x01005}, {{1, 0, 0}, 6, 0x00103}, {{0, 0, 0}, 7, 0x00001}, {{0, 1, 3}, 5, 0x04050},
    {{1, 0, 3}, 6, 0x00430}, {{0, 3, 1}, 3, 0x40044}, {{3, 0, 1}, 3, 0x20022}, {{1, 3, 0}, 6, 0x0020c},
    {{3, 1, 0}, 5, 0x0200a}, {{0, 3, 3}, 7, 0x00040}, {{3, 0, 3}, 7, 0x00020}, {{0, 0, 3}, 7, 0x00010},
    {{3, 3, 0}, 7, 0x00008}, {{0, 3, 0}, 7, 0x00004}, {{3, 0, 0}, 7, 0x00002}};

// What the nodes of a mask are to the leaf one step away along these axes. Only those that both have mean
// anything. The interior node is no one else's.
MORTISE_FUNCTION u32 nodes_across(u32 mask, u32 axes) {
    if (axes & 1) mask = ((mask & 0x55055u) << 1) | ((mask >> 1) & 0x55055u);
    if (axes & 2) {
        mask = ((mask & 0x30033u) << 2) | ((mask >> 2) & 0x30033u) | ((mask & 0x500u) << 1) |
               ((mask >> 1) & 0x500u);
    }
    if (axes & 4)
        mask =
            ((mask & 0xfu) << 4) | ((mask >> 4) & 0xfu) | ((mask & 0x3300u) << 2) | ((mask >> 2) & 0x3300u);
    return mask;
}

// The code of leaf k of kLeafBefore from `code`; kNoOwner if that is beyond the root box or not before.
MORTISE_FUNCTION u64 code_before(const BorderCells* cells, u64 code, u32 k) {
    const u64 other =
        border_cell(cells, kLeafBefore[k].step[0], kLeafBefore[k].step[1], kLeafBefore[k].step[2]);
    return other < code ? other : kNoOwner;
}

// Those of the nodes in `mask`, which the leaf uses, that it owns; `used` are the masks of NIO leaves.
MORTISE_FUNCTION u32 owned_of_uniform(const Tree* tree, MORTISE_GLOBAL u32* used, u64 code, u32 mask) {
    const BorderCells cells = border_cells(tree, code, tree->shape.level);
    for (u32 k = 0; k < kLeavesBefore; ++k) {
        const u32 shared = mask & kLeafBefore[k].shared;
        u64 other;
        Leaf leaf;
        if (shared == 0) continue;
        other = code_before(&cells, code, k);
        if (other == kNoOwner) continue;
        leaf = leaf_at(tree, other);
        if (leaf.kind == kLeafNone) continue;
        mask &=
            ~(shared & nodes_across(leaf.kind == kLeafIn ? 0xffu : used[leaf.index], kLeafBefore[k].across));
    }
    return mask;
}

#endif
