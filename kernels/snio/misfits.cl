// Simple leaves that do not fit their neighbours, where formulas hold in one cell each (spatial.h): those of
// surfaces of triangles.
//
// Such formulas may disagree about a common face: at the rim of an open surface, or where a cell holds too
// many triangles. A template would not fit there; the certificate makes facets where its cell and the next
// one differ.
#include "shared/bounds.h"
#include "shared/snio.h"
#include "shared/tape.h"
#include "shared/tree.h"

// Whether the surface is active in an NIO leaf.
static int depends_on(__global const uint* tapes, const TreeNode node, uint surface) {
    for (uint i = 0; i < node.tape_length; ++i) {
        const uint word = tapes[node.tape_offset + i];
        if (tape_operation(word) == kTapeLiteral && tape_surface(word) == surface) return 1;
    }
    return 0;
}

// Marks IN leaves beside OUT leaves to be promoted. One work-item handles one word of the bitmaps.
MORTISE_KERNEL void mark_exposed(TREE_PARAMETERS, __global uint* promoted, uint items) {
    const uint word = get_global_id(0);
    if (word >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    for (uint rest = in_bits[word]; rest != 0; rest &= rest - 1) {
        const uint bit = mortise_lowest_bit(rest);
        const ulong code = word_code(&tree, word) | bit;
        const int level = leaf_level(&tree, code);
        for (int f = 0; f < 6; ++f) {
            if (leaf_beyond(&tree, code, level, f).kind == kLeafNone) promoted[word] |= 1u << bit;
        }
    }
}

// Whether a candidate's face fits what lies beyond: a cut face needs the surface there, a whole one the same
// side.
static int face_fits(const Tree* tree, __global const TreeNode* nio, __global const uint* tapes,
                     __global const SnioCandidate* candidates, const SnioCandidate candidate, ulong code,
                     int level, int f) {
    const Leaf beyond = leaf_beyond(tree, code, level, f);
    uint corners = 0;
    uint inside;
    uint outside;
    for (int i = 0; i < 4; ++i) corners |= 1u << kFaceCorners[f][i];
    inside = corners & candidate.inside & ~(uint)candidate.zero;
    outside = corners & ~(uint)candidate.inside & ~(uint)candidate.zero;
    if (beyond.kind == kLeafIn) return outside == 0;
    if (beyond.kind == kLeafNone) return inside == 0;
    if (inside && outside && !depends_on(tapes, nio[beyond.index], candidate.surface)) return 0;
    return sides_agree(inside, outside, candidates[beyond.index], f);
}

// Finds the candidates that do not fit the leaves around them: misfit[i].
//
// Reads   the tree, nio, tapes, candidates. One work-item handles one leaf.
MORTISE_KERNEL void find_misfits(TREE_PARAMETERS, __global const TreeNode* nio, __global const uint* tapes,
                                 __global const SnioCandidate* candidates, __global uchar* misfit,
                                 uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const SnioCandidate candidate = candidates[item];
    const ulong code = nio[item].morton;
    const int level = leaf_level(&tree, code);
    const uint inside = candidate.inside & ~(uint)candidate.zero;
    const uint outside = ~(uint)candidate.inside & ~(uint)candidate.zero;
    int fits = 1;
    for (int f = 0; f < 6 && fits; ++f) {
        fits = face_fits(&tree, nio, tapes, candidates, candidate, code, level, f);
    }
    for (int e = 0; e < 12 && fits; ++e) {
        const uint low = 1u << kEdgeCorners[e][0];
        const uint high = 1u << kEdgeCorners[e][1];
        const int axis = e >> 2;
        int direction[3] = {0, 0, 0};
        if (!((inside & low) && (outside & high)) && !((inside & high) && (outside & low))) continue;
        direction[first_other(axis)] = (e & 1) ? 1 : -1;
        direction[second_other(axis)] = (e & 2) ? 1 : -1;
        const Leaf beyond = leaf_beside(&tree, code, level, direction);
        fits = beyond.kind == kLeafNio && depends_on(tapes, nio[beyond.index], candidate.surface);
    }
    misfit[item] = (uchar)!fits;
}

// Leaves the misfits to the certificate. One work-item handles one leaf.
MORTISE_KERNEL void drop_misfits(__global const uchar* misfit, __global SnioCandidate* candidates,
                                 uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    if (misfit[item]) candidates[item].flags = 0;
}
