// Numbers of the nodes of leaves (number.cl): of one leaf, from what the leaves before it own, or of a block
// of cells at once. `owned` and `base` are those of the piece's leaves.
#ifndef MORTISE_ASSEMBLY_NODE_IDS_H
#define MORTISE_ASSEMBLY_NODE_IDS_H

#include "shared/leaves_before.h"
#include "shared/tree.h"
#include "shared/tree_blocks.h"

// Whether a word holds 32 IN leaves that own one node each, their last corner; `base` of the first of them.
static int is_plain(uint in, __global const uint* base) {
    return in == 0xffffffffu && base[32] - base[0] == 32;
}

// Number of the node that `owner` has as `bit`.
static uint node_id(const Tree* tree, __global const uint* owned, __global const uint* base,
                    __global const ulong* foreign, PieceRange range, ulong owner, uint bit) {
    if (owner < range.begin || owner >= range.end) {
        const ulong key = node_key(owner, bit);
        uint low = 0;
        uint high = range.foreign_count;
        while (low < high) {
            const uint middle = (low + high) / 2;
            if (foreign[middle] < key) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        return range.nodes + low;
    }
    const uint rank = meshed_rank(tree, owner) - range.first_in - range.first_nio;
    return base[rank] + mask_rank(owned[rank], bit);
}

// Numbers of the nodes in `mask` that leaves of this piece own, by what each of these owns: ids[bit] of a
// leaf of a uniform tree. Returns the other nodes.
static uint uniform_ids(const Tree* tree, __global const uint* owned, __global const uint* base,
                        PieceRange range, ulong code, uint rank, uint mask, uint* ids) {
    const uint first_rank = range.first_in + range.first_nio;
    const BorderCells cells = border_cells(tree, code, tree->shape.level);
    const uint own = owned[rank - first_rank];
    for (uint hits = mask & own; hits != 0; hits &= hits - 1) {
        const uint bit = mortise_lowest_bit(hits);
        ids[bit] = base[rank - first_rank] + mask_rank(own, bit);
    }
    mask &= ~own;
    for (uint k = 0; k < kLeavesBefore && mask != 0; ++k) {
        const uint across = kLeafBefore[k].across;
        ulong other;
        Leaf leaf;
        uint theirs;
        uint first;
        if ((mask & kLeafBefore[k].shared) == 0) continue;
        other = code_before(&cells, code, k);
        if (other == kNoOwner || other < range.begin) continue;
        leaf = leaf_at(tree, other);
        if (leaf.kind == kLeafNone) continue;
        first = meshed_rank(tree, other) - first_rank;
        theirs = owned[first];
        first = base[first];
        for (uint hits = mask & kLeafBefore[k].shared & nodes_across(theirs, across); hits != 0;
             hits &= hits - 1) {
            const uint hit = hits & -hits;
            ids[mortise_lowest_bit(hit)] = first + popcount(theirs & (nodes_across(hit, across) - 1u));
            mask &= ~hit;
        }
    }
    return mask;
}

// Numbers of the nodes in `mask`, which the meshed leaf of this code and rank uses: ids[bit].
MORTISE_NOINLINE void find_ids(const Tree* tree, __global const uint* used, __global const uint* owned,
                               __global const uint* base, __global const ulong* foreign, PieceRange range,
                               ulong code, uint rank, uint mask, uint* ids) {
    const uint mark = leaf_mark(tree, rank);
    const int level = (int)(mark & kMarkLevel);
    const uint edge = leaf_edge(tree, level);
    const uint x = gather_bits(code);
    const uint y = gather_bits(code >> 1);
    const uint z = gather_bits(code >> 2);
    uint rest = mask;
    if (!tree->shape.graded) rest = uniform_ids(tree, owned, base, range, code, rank, mask, ids);
    for (; rest != 0; rest &= rest - 1) {
        const uint own_bit = mortise_lowest_bit(rest);
        uint bit = own_bit;
        ulong owner = code;  // of the interior node
        if (own_bit < 8) {
            owner = corner_owner(tree, used, code, mark, x, y, z, edge, own_bit, &bit);
        } else if (own_bit < kInteriorNodeBit) {
            owner = own_edge_owner(tree, used, code, level, own_bit - 8, &bit);
        }
        ids[own_bit] = node_id(tree, owned, base, foreign, range, owner, bit);
    }
}

typedef uint2 Pair __attribute__((aligned(4)));
#define PAIR_AT(low, offset) (*(const Pair*)((low) + (offset)))

// Numbers of the last corners of IN cells in a block and of those behind it, x first; index 0 is behind.
MORTISE_NOINLINE void block_ids(const Tree* tree, const TreeBlock* block, __global const uint* base,
                                PieceRange range, uint* ids) {
    uint rank[8];
    uint plain = 0;
    for (uint a = 0; a < 8; ++a) {
        const uint word = block->word[a];
        rank[a] = word != kNoWord ? tree->in_rank[word] + tree->nio_rank[word] : 0;
        rank[a] -= range.first_in + range.first_nio;
        plain += word != kNoWord && is_plain(block->in[a], base + rank[a]);
    }
    if (plain == 8) {  // nearly all of them
        for (uint z = 0; z < 3; ++z) {
            for (uint y = 0; y < 5; ++y) {
                const uint a = ((y == 0) << 1) | ((z == 0) << 2);
                const uint place = place_in_block(0, (y + 3) & 3, (z + 1) & 1);
                uint* row = ids + (z * 5 + y) * 5;
                row[0] = base[rank[a | 1]] + (place | place_in_block(3, 0, 0));
                for (uint x = 0; x < 4; ++x) row[x + 1] = base[rank[a]] + (place | place_in_block(x, 0, 0));
            }
        }
        return;
    }
    for (uint z = 0; z < 3; ++z) {
        for (uint y = 0; y < 5; ++y) {
            for (uint x = 0; x < 5; ++x) {
                const uint a = (x == 0) | ((y == 0) << 1) | ((z == 0) << 2);
                const uint place = place_in_block((x + 3) & 3, (y + 3) & 3, (z + 1) & 1);
                uint id = 0;
                if ((block->in[a] >> place) & 1) {
                    // An IN cell's last corner is the last of its nodes.
                    id = base[rank[a] + popcount(block->meshed[a] & ((1u << place) - 1u)) + 1] - 1;
                }
                ids[(z * 5 + y) * 5 + x] = id;
            }
        }
    }
}

// The hexahedron of an inner cell of a block.
static uint8 block_hexahedron(const uint* ids, uint bit) {
    // Pairs along x: from single numbers compilers make a gather instruction, which is slow.
    const uint* low = ids + (block_z(bit) * 5 + block_y(bit)) * 5 + block_x(bit);
    const uint2 a = PAIR_AT(low, 0);
    const uint2 b = PAIR_AT(low, 5);
    const uint2 c = PAIR_AT(low, 25);
    const uint2 d = PAIR_AT(low, 30);
    return (uint8)(a.x, a.y, b.y, b.x, c.x, c.y, d.y, d.x);
}

#endif
