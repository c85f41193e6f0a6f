// Bitmaps of a uniform tree's leaves (kernels/shared/tree.h), from its node lists.
#include "shared/bounds.h"
#include "shared/tree.h"

// The word for a code, which is stored.
static uint word_of(__global const uint* directory, TreeShape shape, ulong code) {
    const uint page = directory[code >> shape.directory_shift];
    return (page << shape.page_shift) | ((uint)(code >> 5) & ((1u << shape.page_shift) - 1u));
}

// Sets is_stored (zeroed before) of the pages that hold IN nodes. One work-item handles one node. Those of
// one page follow one another within their level, and the first marks it.
MORTISE_KERNEL void store_in(__global const InNode* in_nodes, __global uint* is_stored, TreeShape shape,
                             uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const InNode node = in_nodes[item];
    const uint depth = (uint)shape.level - node.level;
    const ulong first = (node.morton << (3 * depth)) >> shape.directory_shift;
    const ulong last = (((node.morton + 1) << (3 * depth)) - 1) >> shape.directory_shift;
    if (item > 0 && in_nodes[item - 1].level == node.level &&
        (in_nodes[item - 1].morton << (3 * depth)) >> shape.directory_shift == first) {
        return;
    }
    for (ulong page = first; page <= last; ++page) atomic_or(is_stored + page, 1u);
}

// The same for NIO leaves.
MORTISE_KERNEL void store_nio(__global const TreeNode* nodes, __global uint* is_stored, TreeShape shape,
                              uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const ulong page = nodes[item].morton >> shape.directory_shift;
    if (item > 0 && nodes[item - 1].morton >> shape.directory_shift == page) return;
    atomic_or(is_stored + page, 1u);
}

// page_codes of the pages that the directory, a scan of is_stored, tells. One work-item handles one cell of
// it.
MORTISE_KERNEL void list_pages(__global const uint* directory, __global ulong* page_codes, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    if (directory[item + 1] != directory[item]) page_codes[directory[item]] = item;
}

// Sets the bits of all finest cells below each IN node.
//
// Reads in_nodes, directory; writes bits (zeroed before). One work-item handles one node: nodes of the last
// two levels set part of a word by atomics, whose order does not matter; larger ones own whole words, which
// follow one another also where they cover several pages.
MORTISE_KERNEL void mark_in(__global const InNode* in_nodes, __global const uint* directory,
                            __global uint* bits, TreeShape shape, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const InNode node = in_nodes[item];
    const uint depth = (uint)shape.level - node.level;
    const ulong first = node.morton << (3 * depth);
    __global uint* own = bits + word_of(directory, shape, first);
    if (depth == 0) {
        atomic_or(own, 1u << (first & 31));
    } else if (depth == 1) {
        atomic_or(own, 0xffu << (first & 31));
    } else {
        const ulong words = 1UL << (3 * depth - 5);
        for (ulong w = 0; w < words; ++w) own[w] = 0xffffffffu;
    }
}

// Sets the bit of each NIO leaf. Reads nodes, directory; writes bits (zeroed before). One work-item handles
// one leaf.
MORTISE_KERNEL void mark_nio(__global const TreeNode* nodes, __global const uint* directory,
                             __global uint* bits, TreeShape shape, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const ulong morton = nodes[item].morton;
    atomic_or(bits + word_of(directory, shape, morton), 1u << (morton & 31));
}

// counts[w] = set bits of word w: their exclusive scan is the rank. One work-item handles one word.
MORTISE_KERNEL void count_word(__global const uint* bits, __global uint* counts, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    counts[item] = popcount(bits[item]);
}
