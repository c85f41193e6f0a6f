// Bitmaps of a uniform tree's leaves (kernels/shared/tree.h), from its node lists.
#include "shared/bounds.h"
#include "shared/tree.h"

// Sets the bits of all finest cells below each IN node.
//
// Reads in_nodes; writes bits (zeroed before). One work-item handles one node: nodes of the last two levels
// set part of a word by atomics, whose order does not matter; larger ones own whole words.
MORTISE_KERNEL void mark_in(__global const InNode* in_nodes, __global uint* bits, int level, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const InNode node = in_nodes[item];
        const uint depth = (uint)level - node.level;
        const ulong first = node.morton << (3 * depth);
        if (depth == 0) {
            atomic_or(bits + (first >> 5), 1u << (first & 31));
        } else if (depth == 1) {
            atomic_or(bits + (first >> 5), 0xffu << (first & 31));
        } else {
            const ulong words = 1UL << (3 * depth - 5);
            for (ulong w = 0; w < words; ++w) bits[(first >> 5) + w] = 0xffffffffu;
        }
    }
}

// Sets the bit of each NIO leaf. Reads nodes; writes bits (zeroed before). One work-item handles one leaf.
MORTISE_KERNEL void mark_nio(__global const TreeNode* nodes, __global uint* bits, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const ulong morton = nodes[item].morton;
        atomic_or(bits + (morton >> 5), 1u << (morton & 31));
    }
}

// counts[w] = set bits of word w: their exclusive scan is the rank. One work-item handles one word.
MORTISE_KERNEL void count_word(__global const uint* bits, __global uint* counts, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    counts[item] = popcount(bits[item]);
}
