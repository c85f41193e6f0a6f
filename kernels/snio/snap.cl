// Decides which grid vertices are moved onto the surface (algorithms.md §4).
//
// A vertex may move only if all leaves around it know one surface at most (IN and OUT leaves: none), the same
// one, and if each of them keeps a valid template whichever of its own vertices move. So one pass decides, in
// any order: nothing depends on what another vertex does. Leaves of the certificate never have a moved
// corner.
//
// IN leaves with a corner on the surface are promoted: they join the NIO leaves, with an empty tape, and get
// a template like them.
#include "shared/bounds.h"
#include "shared/leaf_template.h"

#define NO_LEAF 0xffffffffu

// Leaves around grid vertex (x, y, z) in the order of d of vertex_owner (tree.h): leaf d has it as corner 7 -
// d. kind: 0 OUT or beyond the root box, 1 IN, 2 NIO; `index`: of the NIO leaf.
int leaf_at_vertex(__global const uint* in_bits, __global const uint* nio_bits, __global const uint* nio_rank,
                   int level, uint x, uint y, uint z, uint d, ulong* morton, uint* index) {
    const uint size = 1u << level;
    const uint cx = x - 1 + (d & 1);
    const uint cy = y - 1 + ((d >> 1) & 1);
    const uint cz = z - 1 + (d >> 2);
    if (cx >= size || cy >= size || cz >= size) return 0;
    *morton = morton_encode(cx, cy, cz);
    if (test_bit(in_bits, *morton)) return 1;
    if (!test_bit(nio_bits, *morton)) return 0;
    *index = rank_of(nio_bits, nio_rank, *morton);
    return 2;
}

// Takes those corners out of `near` that may not move for what their leaves are, and marks IN leaves to be
// promoted.
//
// Reads the tree and candidates; writes near[i] and sets bits of `promoted` (atomics, order does not matter).
// One work-item handles one NIO leaf.
MORTISE_KERNEL void mark_vertices(__global const uint* in_bits, __global const uint* nio_bits,
                                  __global const uint* nio_rank, __global const TreeNode* nio,
                                  __global const SnioCandidate* candidates, __global uchar* near,
                                  __global uint* promoted, int level, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const SnioCandidate candidate = candidates[item];
        const ulong own = nio[item].morton;
        const uint corners = (candidate.flags & kCandidateSimple) ? candidate.near | candidate.zero : 0;
        uint kept = candidate.near;
        for (uint c = 0; c < 8; ++c) {
            ulong in_leaves[8];
            uint in_count = 0;
            int allowed = 1;
            if (((corners >> c) & 1) == 0) continue;
            for (uint d = 0; d < 8; ++d) {
                ulong morton;
                uint index;
                const int kind =
                    leaf_at_vertex(in_bits, nio_bits, nio_rank, level, gather_bits(own) + (c & 1),
                                   gather_bits(own >> 1) + ((c >> 1) & 1), gather_bits(own >> 2) + (c >> 2),
                                   d, &morton, &index);
                if (kind == 1) in_leaves[in_count++] = morton;
                if (kind == 2) {
                    const SnioCandidate other = candidates[index];
                    allowed = allowed && (other.flags & kCandidateSimple) != 0 &&
                              other.surface == candidate.surface && other.region == candidate.region;
                }
            }
            if (!allowed) kept &= ~(1u << c);
            if (!allowed && ((candidate.zero >> c) & 1) == 0) continue;
            for (uint i = 0; i < in_count; ++i) {
                atomic_or(promoted + (in_leaves[i] >> 5), 1u << (in_leaves[i] & 31));
            }
        }
        near[item] = (uchar)kept;
    }
}

// Moves promoted leaves from the IN to the NIO bitmap; old_nio_bits keeps what NIO was.
// One work-item handles one word.
MORTISE_KERNEL void promote_words(__global uint* in_bits, __global uint* nio_bits,
                                  __global uint* old_nio_bits, __global const uint* promoted, uint items) {
    const uint word = get_global_id(0);
    if (word >= items) return;
    old_nio_bits[word] = nio_bits[word];
    nio_bits[word] |= promoted[word];
    in_bits[word] &= ~promoted[word];
}

// Leaves and candidates of the new NIO bitmap, in Morton order.
//
// Reads the old lists and `near`; writes new_nio and new_candidates. A promoted leaf takes surface, region
// and the states of its corners from the old leaves around it; if these are not of one surface it is not
// simple, and keeps its corners. One work-item handles one word.
MORTISE_KERNEL void promote_leaves(__global const uint* nio_bits, __global const uint* nio_rank,
                                   __global const uint* old_nio_bits, __global const uint* old_nio_rank,
                                   __global const TreeNode* nio, __global const SnioCandidate* candidates,
                                   __global const uchar* near, __global TreeNode* new_nio,
                                   __global SnioCandidate* new_candidates, int level, uint items) {
    const uint word = get_global_id(0);
    if (word >= items) return;
    {
        uint to = nio_rank[word];
        for (uint rest = nio_bits[word]; rest != 0; rest &= rest - 1, ++to) {
            const uint bit = popcount((rest & -rest) - 1u);
            const ulong own = ((ulong)word << 5) | bit;
            TreeNode node;
            SnioCandidate candidate;
            int mixed = 0;
            if ((old_nio_bits[word] >> bit) & 1) {
                const uint from = rank_of(old_nio_bits, old_nio_rank, own);
                node = nio[from];
                candidate = candidates[from];
                candidate.near = near[from];
            } else {
                node.morton = own;
                node.tape_offset = 0;
                node.tape_length = 0;
                candidate.surface = NO_LEAF;
                candidate.region = 0;
                candidate.inside = 0xff;
                candidate.zero = 0;
                candidate.near = 0;
                candidate.flags = kCandidateSimple | kCandidatePromoted;
                candidate.padding[0] = 0;
                candidate.padding[1] = 0;
                for (uint c = 0; c < 8; ++c) {
                    for (uint d = 0; d < 8; ++d) {
                        ulong morton;
                        uint index;
                        SnioCandidate other;
                        if (leaf_at_vertex(old_nio_bits, old_nio_bits, old_nio_rank, level,
                                           gather_bits(own) + (c & 1), gather_bits(own >> 1) + ((c >> 1) & 1),
                                           gather_bits(own >> 2) + (c >> 2), d, &morton, &index) == 0) {
                            continue;
                        }
                        index = rank_of(old_nio_bits, old_nio_rank, morton);
                        other = candidates[index];
                        if ((other.flags & kCandidateSimple) == 0) continue;
                        if ((((other.zero | near[index]) >> (7 - d)) & 1) == 0) continue;
                        if (candidate.surface == NO_LEAF) {
                            candidate.surface = other.surface;
                            candidate.region = other.region;
                        }
                        if (candidate.surface != other.surface) mixed = 1;
                        candidate.zero |= ((other.zero >> (7 - d)) & 1u) << c;
                        candidate.near |= ((near[index] >> (7 - d)) & 1u) << c;
                    }
                }
                candidate.inside = (uchar)(0xff & ~candidate.zero);
                if (mixed) candidate.flags = kCandidatePromoted;
            }
            new_nio[to] = node;
            new_candidates[to] = candidate;
        }
    }
}

// Whether a leaf has a template as it is (kCandidateSimple stays), and whichever of its near corners move
// (kCandidateSafe). One work-item handles one leaf.
MORTISE_KERNEL void test_subsets(__global const TreeNode* nio, __global const Surface* surfaces,
                                 __global const ExpressionOp* ops, __global SnioCandidate* candidates,
                                 int level, int snap, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const SnioCandidate candidate = candidates[item];
        const ulong morton = nio[item].morton;
        const uint x = gather_bits(morton);
        const uint y = gather_bits(morton >> 1);
        const uint z = gather_bits(morton >> 2);
        const double cell = 1.0 / (double)(1u << level);
        const uint near = candidate.near;
        double p[kCellNodes][3];
        double moved[8][3];
        uint subset = 0;
        int valid = 1;
        if ((candidate.flags & kCandidateSimple) == 0) return;
        leaf_positions(surfaces + candidate.surface, ops, x, y, z, cell,
                       cut_edges(candidate.inside, candidate.zero), p);
        for (uint c = 0; c < 8; ++c) {
            for (int j = 0; j < 3; ++j) moved[c][j] = p[c][j];
            if ((near >> c) & 1) {
                double corner[3];
                int displacement[3];
                corner[0] = (x + (c & 1)) * cell;
                corner[1] = (y + ((c >> 1) & 1)) * cell;
                corner[2] = (z + (c >> 2)) * cell;
                snap_displacement(surfaces + candidate.surface, ops, corner, cell, displacement);
                for (int j = 0; j < 3; ++j) moved[c][j] += (double)displacement[j] / (double)kCellUnits;
            }
        }
        // All subsets of `near`, the empty one first.
        do {
            const uint on = candidate.zero | subset;
            for (uint c = 0; c < 8; ++c) {
                const int is_moved = (subset >> c) & 1;
                p[c][0] = is_moved ? moved[c][0] : (double)(c & 1);
                p[c][1] = is_moved ? moved[c][1] : (double)((c >> 1) & 1);
                p[c][2] = is_moved ? moved[c][2] : (double)(c >> 2);
            }
            valid = has_template(candidate.inside & ~on, on, p, !snap) ||
                    (subset == 0 && (candidate.flags & kCandidatePromoted) != 0);
            if (subset == 0 && !valid) {
                candidates[item].flags = candidate.flags & ~kCandidateSimple;
                return;
            }
            subset = (subset - near) & near;
        } while (valid && subset != 0);
        if (valid) candidates[item].flags = candidate.flags | kCandidateSafe;
    }
}

// Final states: the corners that move.
//
// Reads the tree and candidates; writes moved[i]. One work-item handles one NIO leaf.
MORTISE_KERNEL void decide(__global const uint* in_bits, __global const uint* nio_bits,
                           __global const uint* nio_rank, __global const TreeNode* nio,
                           __global const SnioCandidate* candidates, __global uchar* moved, int level,
                           uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const SnioCandidate candidate = candidates[item];
        const ulong own = nio[item].morton;
        uint kept = (candidate.flags & kCandidateSafe) ? candidate.near : 0;
        for (uint c = 0; c < 8; ++c) {
            if (((kept >> c) & 1) == 0) continue;
            for (uint d = 0; d < 8; ++d) {
                ulong morton;
                uint index;
                const int kind =
                    leaf_at_vertex(in_bits, nio_bits, nio_rank, level, gather_bits(own) + (c & 1),
                                   gather_bits(own >> 1) + ((c >> 1) & 1), gather_bits(own >> 2) + (c >> 2),
                                   d, &morton, &index);
                if (kind == 2 && (candidates[index].flags & kCandidateSafe) == 0) kept &= ~(1u << c);
            }
        }
        moved[item] = (uchar)kept;
    }
}
