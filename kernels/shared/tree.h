// Leaves of a uniform tree as bitmaps over Morton codes, and the ownership rule that numbers nodes.
//
// in_bits and nio_bits hold one bit per finest cell in Morton order; *_rank[w] is the number of set bits
// before word w, so the index of a leaf among its kind is a rank. A leaf is meshed if it is IN or NIO.
//
// Ownership (algorithms.md §2): a grid vertex, or the single root on a grid edge, belongs to the Morton-first
// leaf that uses it. IN leaves use their eight corners; NIO leaves use what their mask says: bits 0–7
// corners, bits 8–19 edges, bit 20 the template's interior node. The mask is all that a leaf tells others.
#ifndef MORTISE_SHARED_TREE_H
#define MORTISE_SHARED_TREE_H

#include "lattice.h"

#define kInteriorNodeBit 20
#define kNoOwner 0xffffffffffffffffUL

MORTISE_FUNCTION u32 count_bits(u32 x) {
#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
    return popcount(x);
#else
    return (u32)__builtin_popcount(x);
#endif
}

MORTISE_FUNCTION u32 test_bit(MORTISE_GLOBAL u32* bits, u64 morton) {
    return (bits[morton >> 5] >> (morton & 31)) & 1u;
}

MORTISE_FUNCTION u32 rank_of(MORTISE_GLOBAL u32* bits, MORTISE_GLOBAL u32* rank, u64 morton) {
    const u64 word = morton >> 5;
    return rank[word] + count_bits(bits[word] & ((1u << (morton & 31)) - 1u));
}

// Whether the leaf with this code uses its node `bit`. Cells outside the root box have no code: test before.
MORTISE_FUNCTION u32 leaf_uses(MORTISE_GLOBAL u32* in_bits, MORTISE_GLOBAL u32* nio_bits,
                               MORTISE_GLOBAL u32* nio_rank, MORTISE_GLOBAL u32* used, u64 morton, u32 bit) {
    if (test_bit(in_bits, morton)) return bit < 8;
    if (!test_bit(nio_bits, morton)) return 0;
    return (used[rank_of(nio_bits, nio_rank, morton)] >> bit) & 1u;
}

// Owner of grid vertex (x, y, z), 0 <= x <= 2^level: its Morton code, and the vertex's bit in the owner's
// mask.
MORTISE_FUNCTION u64 vertex_owner(MORTISE_GLOBAL u32* in_bits, MORTISE_GLOBAL u32* nio_bits,
                                  MORTISE_GLOBAL u32* nio_rank, MORTISE_GLOBAL u32* used, i32 level, u32 x,
                                  u32 y, u32 z, u32* bit) {
    const u32 size = 1u << level;
    u64 owner = kNoOwner;
    for (u32 d = 0; d < 8; ++d) {
        // Wraps below zero, so one comparison tests both ends.
        const u32 cx = x - 1 + (d & 1);
        const u32 cy = y - 1 + ((d >> 1) & 1);
        const u32 cz = z - 1 + (d >> 2);
        if (cx < size && cy < size && cz < size) {
            const u64 code = morton_encode(cx, cy, cz);
            if (code < owner && leaf_uses(in_bits, nio_bits, nio_rank, used, code, 7 - d)) {
                owner = code;
                *bit = 7 - d;
                // The cell behind in all three directions precedes all others.
                if (d == 0) return owner;
            }
        }
    }
    return owner;
}

// Owner of the single root on the grid edge along `axis` from vertex (x, y, z).
MORTISE_FUNCTION u64 edge_owner(MORTISE_GLOBAL u32* in_bits, MORTISE_GLOBAL u32* nio_bits,
                                MORTISE_GLOBAL u32* nio_rank, MORTISE_GLOBAL u32* used, i32 level, u32 axis,
                                u32 x, u32 y, u32 z, u32* bit) {
    const u32 size = 1u << level;
    u64 owner = kNoOwner;
    for (u32 d = 0; d < 4; ++d) {
        // d counts the two other axes in increasing order; the edge is number 3 - d of its axis in the cell.
        const u32 first = (d & 1) - 1;
        const u32 second = (d >> 1) - 1;
        const u32 cx = axis == 0 ? x : x + first;
        const u32 cy = axis == 1 ? y : axis == 0 ? y + first : y + second;
        const u32 cz = axis == 2 ? z : z + second;
        if (cx < size && cy < size && cz < size) {
            const u64 code = morton_encode(cx, cy, cz);
            const u32 edge_bit = 8 + 4 * axis + (3 - d);
            if (code < owner && leaf_uses(in_bits, nio_bits, nio_rank, used, code, edge_bit)) {
                owner = code;
                *bit = edge_bit;
            }
        }
    }
    return owner;
}

// What numbers the nodes of one piece of a mesh: the leaves in [begin, end), which own `nodes` nodes. Nodes
// of other owners follow, by their place in a sorted list of foreign_count keys (node_key).
typedef struct PieceRange {
    u64 begin;
    u64 end;
    u32 nodes;
    u32 foreign_count;
} PieceRange;

// Name of a grid vertex or single root across pieces: its owner and its bit there.
MORTISE_FUNCTION u64 node_key(u64 owner, u32 bit) { return (owner << 5) | bit; }

// Position of a node in its owner's mask.
MORTISE_FUNCTION u32 mask_rank(u32 mask, u32 bit) { return count_bits(mask & ((1u << bit) - 1u)); }

#endif
