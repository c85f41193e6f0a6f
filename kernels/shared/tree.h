// Leaves of a tree as bitmaps over Morton codes, and the ownership rule that numbers nodes.
//
// The code of a leaf is the Morton code of its first finest cell. in_bits and nio_bits hold one bit per code;
// *_rank[w] is the number of set bits before word w, so the index of a leaf among its kind is a rank. A leaf
// is meshed if it is IN or NIO.
//
// Only pages of the bitmaps that hold a leaf are stored: 2^page_shift words each, whose codes follow one
// another. page_codes[p] << page_shift is the number of page p's first word among those of all codes, and
// ascends with p. The directory says how many pages come before each cell of a coarse level.
//
// In a uniform tree all leaves have the finest level, and a page is one cell of the directory. A graded tree
// (2:1 across faces, edges and corners, docs/design/graded.md) has pages of one word; leaf_marks tells the
// level of each meshed leaf in Morton order, and whether finer ones are around it.
//
// Ownership (invariant 6 of ARCHITECTURE.md): a grid vertex, or the single root on a leaf's edge, belongs to
// the Morton-first of the finest leaves that use it. IN leaves use their eight corners; NIO leaves use what
// their mask says: bits 0–7 corners, bits 8–19 edges, bit 20 the template's interior node. The mask is all
// that a leaf tells others. Vertices in the middle of a leaf's edge or face do not count as its own.
#ifndef MORTISE_SHARED_TREE_H
#define MORTISE_SHARED_TREE_H

#include "lattice.h"

#define kInteriorNodeBit 20
#define kNoOwner 0xffffffffffffffffUL

// A leaf's mark: its level, and kFinerAround unless no meshed leaf that touches it is finer.
#define kMarkLevel 0x1f
#define kFinerAround 0x80

#define kLeafNone 0  // OUT, or beyond the root box
#define kLeafIn 1
#define kLeafNio 2

typedef struct TreeShape {
    i32 level;            // of the finest leaves: their edge is the unit of all coordinates
    i32 graded;           // 0: uniform
    u32 words;            // of the bitmaps, as stored
    u32 directory_shift;  // from a code to its cell of the directory
    u32 page_shift;       // from a word to its page
} TreeShape;

// Pages of a uniform tree hold 2^kPageShift words, 16 × 16 × 16 cells, or all that there are.
#define kPageShift 7

typedef struct Tree {
    MORTISE_GLOBAL u32* in_bits;
    MORTISE_GLOBAL u32* nio_bits;
    MORTISE_GLOBAL u32* in_rank;
    MORTISE_GLOBAL u32* nio_rank;
    MORTISE_GLOBAL u64* page_codes;
    MORTISE_GLOBAL u32* directory;
    MORTISE_GLOBAL u8* leaf_marks;
    TreeShape shape;
} Tree;

// How kernels take a tree, and make one of what they took.
#define TREE_PARAMETERS                                                                              \
    __global const u32 *in_bits, __global const u32 *nio_bits, __global const u32 *in_rank,          \
        __global const u32 *nio_rank, __global const u64 *page_codes, __global const u32 *directory, \
        __global const u8 *leaf_marks, TreeShape shape
#define TREE_OF_PARAMETERS \
    make_tree(in_bits, nio_bits, in_rank, nio_rank, page_codes, directory, leaf_marks, shape)

MORTISE_FUNCTION Tree make_tree(MORTISE_GLOBAL u32* in_bits, MORTISE_GLOBAL u32* nio_bits,
                                MORTISE_GLOBAL u32* in_rank, MORTISE_GLOBAL u32* nio_rank,
                                MORTISE_GLOBAL u64* page_codes, MORTISE_GLOBAL u32* directory,
                                MORTISE_GLOBAL u8* leaf_marks, TreeShape shape) {
    Tree tree;
    tree.in_bits = in_bits;
    tree.nio_bits = nio_bits;
    tree.in_rank = in_rank;
    tree.nio_rank = nio_rank;
    tree.page_codes = page_codes;
    tree.directory = directory;
    tree.leaf_marks = leaf_marks;
    tree.shape = shape;
    return tree;
}

// A meshed leaf; kind kLeafNone: there is none.
typedef struct Leaf {
    u64 code;
    i32 kind;
    i32 level;
    u32 index;  // among the leaves of its kind
    u32 word;   // of the bitmaps
} Leaf;

MORTISE_FUNCTION Leaf no_leaf(i32 level) {
    Leaf leaf;
    leaf.code = kNoOwner;
    leaf.kind = kLeafNone;
    leaf.level = level;
    leaf.index = 0;
    leaf.word = 0;
    return leaf;
}

MORTISE_FUNCTION u32 count_bits(u32 x) {
#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
    return popcount(x);
#else
    // Plain x86-64 has no instruction for it, and compilers call a library.
    x -= (x >> 1) & 0x55555555u;
    x = (x & 0x33333333u) + ((x >> 2) & 0x33333333u);
    return (((x + (x >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24;
#endif
}

MORTISE_FUNCTION u32 highest_bit(u32 x) {
#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
    return 31u - clz(x);
#else
    return 31u - (u32)__builtin_clz(x);
#endif
}

// Code of bit 0 of a word.
MORTISE_FUNCTION u64 word_code(const Tree* tree, u32 word) {
    const u32 shift = tree->shape.page_shift;
    return ((tree->page_codes[word >> shift] << shift) | (word & ((1u << shift) - 1u))) << 5;
}

// Number of words before the one for `code`, and whether that one is stored.
MORTISE_FUNCTION u32 find_word(const Tree* tree, u64 code, u32* is_stored) {
    const u64 cell = code >> tree->shape.directory_shift;
    u32 low = tree->directory[cell];
    u32 high = tree->directory[cell + 1];
    const u32 end = high;
    if (!tree->shape.graded) {
        const u32 shift = tree->shape.page_shift;
        *is_stored = low != high;
        return (low << shift) | (low != high ? (u32)(code >> 5) & ((1u << shift) - 1u) : 0);
    }
    while (low < high) {
        const u32 middle = (low + high) / 2;
        if (tree->page_codes[middle] < code >> 5) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    *is_stored = low < end && tree->page_codes[low] == code >> 5;
    return low;
}

// Number of leaves of a kind with codes below `code`; bits and rank of that kind.
MORTISE_FUNCTION u32 count_before(const Tree* tree, MORTISE_GLOBAL u32* bits, MORTISE_GLOBAL u32* rank,
                                  u64 code) {
    u32 is_stored;
    const u32 word = find_word(tree, code, &is_stored);
    return rank[word] + (is_stored ? count_bits(bits[word] & ((1u << (code & 31)) - 1u)) : 0);
}

// Number of meshed leaves with codes below `code`: the place of the leaf with this code among them.
MORTISE_FUNCTION u32 meshed_rank(const Tree* tree, u64 code) {
    u32 is_stored;
    const u32 word = find_word(tree, code, &is_stored);
    const u32 rank = tree->in_rank[word] + tree->nio_rank[word];
    if (!is_stored) return rank;
    return rank + count_bits((tree->in_bits[word] | tree->nio_bits[word]) & ((1u << (code & 31)) - 1u));
}

// The meshed leaf that holds finest cell `code`.
MORTISE_FUNCTION Leaf leaf_at(const Tree* tree, u64 code) {
    Leaf leaf = no_leaf(tree->shape.level);
    u32 is_stored;
    u32 word = find_word(tree, code, &is_stored);
    u32 bit = (u32)(code & 31);
    leaf.code = code;
    if (!tree->shape.graded) {
        if (!is_stored) return leaf;
    } else {
        u32 bits = 0;
        if (is_stored) bits = (tree->in_bits[word] | tree->nio_bits[word]) & (0xffffffffu >> (31 - bit));
        if (bits == 0) {
            if (word == 0) return leaf;
            --word;
            bits = tree->in_bits[word] | tree->nio_bits[word];
        }
        bit = highest_bit(bits);
        leaf.code = (tree->page_codes[word] << 5) | bit;
        leaf.level =
            tree->leaf_marks[tree->in_rank[word] + tree->nio_rank[word] + count_bits(bits) - 1] & kMarkLevel;
        if (((leaf.code ^ code) >> (3 * (tree->shape.level - leaf.level))) != 0) return leaf;
    }
    {
        const u32 below = (1u << bit) - 1u;
        leaf.word = word;
        if ((tree->in_bits[word] >> bit) & 1) {
            leaf.kind = kLeafIn;
            leaf.index = tree->in_rank[word] + count_bits(tree->in_bits[word] & below);
        } else if ((tree->nio_bits[word] >> bit) & 1) {
            leaf.kind = kLeafNio;
            leaf.index = tree->nio_rank[word] + count_bits(tree->nio_bits[word] & below);
        }
    }
    return leaf;
}

// Mark of the meshed leaf of this rank.
MORTISE_FUNCTION u32 leaf_mark(const Tree* tree, u32 rank) {
    return tree->shape.graded ? tree->leaf_marks[rank] : (u32)tree->shape.level;
}

// Level of the leaf with this code.
MORTISE_FUNCTION i32 leaf_level(const Tree* tree, u64 code) {
    return tree->shape.graded ? (i32)(leaf_mark(tree, meshed_rank(tree, code)) & kMarkLevel)
                              : tree->shape.level;
}

// Edge of a leaf of this level, in finest cells.
MORTISE_FUNCTION u32 leaf_edge(const Tree* tree, i32 level) { return 1u << (tree->shape.level - level); }

// Code of the cell at (x, y, z), in finest cells; kNoOwner beyond the root box, where sums have wrapped.
MORTISE_FUNCTION u64 code_at(const Tree* tree, u32 x, u32 y, u32 z) {
    const u32 size = 1u << tree->shape.level;
    return x < size && y < size && z < size ? morton_encode(x, y, z) : kNoOwner;
}

// The bits of axis a in a code.
#define MORTISE_AXIS_BITS(a) (0x1249249249249249UL << (a))

// Those of the finest cell before `code` along axis a; kNoOwner beyond the root box. The bits of one axis
// count down alone if the others' are zero.
MORTISE_FUNCTION u64 axis_behind(u64 code, u32 a) {
    const u64 own = code & MORTISE_AXIS_BITS(a);
    return own != 0 ? (own - (1UL << a)) & MORTISE_AXIS_BITS(a) : kNoOwner;
}

// The same for the cell after it: they count up alone if the others' are one.
MORTISE_FUNCTION u64 axis_ahead(const Tree* tree, u64 code, u32 a) {
    const u64 bits = MORTISE_AXIS_BITS(a) & ((1UL << (3 * tree->shape.level)) - 1);
    const u64 ahead = ((code | ~bits) + (1UL << a)) & bits;
    return ahead != 0 ? ahead : kNoOwner;
}

// The finest cell one step back from `code` along the axes whose bits are set; kNoOwner beyond the root box.
MORTISE_FUNCTION u64 cell_behind(u64 code, u32 axes) {
    for (u32 a = 0; a < 3; ++a) {
        const u64 behind = axis_behind(code, a);
        if (((axes >> a) & 1) == 0) continue;
        if (behind == kNoOwner) return kNoOwner;
        code = (code & ~MORTISE_AXIS_BITS(a)) | behind;
    }
    return code;
}

// Finest cells at the border of a cell: the bits along each axis of the code of those just behind it, of its
// first and last ones, and of those just ahead; kNoOwner beyond the root box. In a uniform tree, where first
// and last are one, they are the codes of all leaves around.
typedef struct BorderCells {
    u64 axis[3][4];
} BorderCells;

// Those of the cell of this level whose first finest cell is `code`.
MORTISE_FUNCTION BorderCells border_cells(const Tree* tree, u64 code, i32 level) {
    const u64 cells = 1UL << (3 * (tree->shape.level - level));
    BorderCells result;
    for (u32 a = 0; a < 3; ++a) {
        const u64 last = code | (MORTISE_AXIS_BITS(a) & (cells - 1));
        result.axis[a][0] = axis_behind(code, a);
        result.axis[a][1] = code & MORTISE_AXIS_BITS(a);
        result.axis[a][2] = last & MORTISE_AXIS_BITS(a);
        result.axis[a][3] = axis_ahead(tree, last, a);
    }
    return result;
}

// The cell that is number x, y, z of these along the axes.
MORTISE_FUNCTION u64 border_cell(const BorderCells* cells, u32 x, u32 y, u32 z) {
    return cells->axis[0][x] | cells->axis[1][y] | cells->axis[2][z];
}

// The leaf that holds the first cell of the place beside a leaf: the place has the leaf's own size and lies
// one step along each axis of `direction`. In a graded tree that leaf may be larger, or one of several
// smaller ones.
MORTISE_FUNCTION Leaf leaf_beside(const Tree* tree, u64 code, i32 level, const i32* direction) {
    u64 other;
    if (tree->shape.graded) {
        const u32 edge = leaf_edge(tree, level);
        other = code_at(tree, gather_bits(code) + edge * (u32)direction[0],
                        gather_bits(code >> 1) + edge * (u32)direction[1],
                        gather_bits(code >> 2) + edge * (u32)direction[2]);
    } else {
        const BorderCells cells = border_cells(tree, code, level);
        u32 step[3];
        for (u32 a = 0; a < 3; ++a) step[a] = direction[a] < 0 ? 0 : direction[a] == 0 ? 1 : 3;
        other = border_cell(&cells, step[0], step[1], step[2]);
    }
    return other != kNoOwner ? leaf_at(tree, other) : no_leaf(level);
}

// The same beyond face f of a leaf.
MORTISE_FUNCTION Leaf leaf_beyond(const Tree* tree, u64 code, i32 level, i32 f) {
    i32 direction[3] = {0, 0, 0};
    direction[f / 2] = (f & 1) != 0 ? 1 : -1;
    return leaf_beside(tree, code, level, direction);
}

// Leaf d of those around grid vertex (x, y, z), in finest cells: it lies behind the vertex along each axis
// whose bit of d is clear. If it has the vertex as a corner, that is corner 7 - d.
MORTISE_FUNCTION Leaf leaf_at_vertex(const Tree* tree, u32 x, u32 y, u32 z, u32 d) {
    const u64 code = code_at(tree, x - 1 + (d & 1), y - 1 + ((d >> 1) & 1), z - 1 + (d >> 2));
    return code != kNoOwner ? leaf_at(tree, code) : no_leaf(tree->shape.level);
}

// Whether a leaf uses its node `bit`; `used` are the masks of NIO leaves.
MORTISE_FUNCTION u32 leaf_uses(MORTISE_GLOBAL u32* used, const Leaf leaf, u32 bit) {
    if (leaf.kind == kLeafIn) return bit < 8;
    return leaf.kind == kLeafNio ? (used[leaf.index] >> bit) & 1u : 0;
}

// Leaf d of those around corner c of the cell.
MORTISE_FUNCTION Leaf leaf_at_corner(const Tree* tree, const BorderCells* cells, u32 c, u32 d) {
    const u64 code = border_cell(cells, 2 * (c & 1) + (d & 1), 2 * ((c >> 1) & 1) + ((d >> 1) & 1),
                                 2 * (c >> 2) + (d >> 2));
    return code != kNoOwner ? leaf_at(tree, code) : no_leaf(tree->shape.level);
}

// Leaf d of those around edge e of the cell, at the edge's first finest cell. d counts the two other axes in
// increasing order: the edge is number 3 - d of its axis in a leaf of the cell's size there.
MORTISE_FUNCTION Leaf leaf_at_edge(const Tree* tree, const BorderCells* cells, u32 e, u32 d) {
    const u32 axis = e >> 2;
    const u32 first = 2 * (e & 1) + (d & 1);
    const u32 second = 2 * ((e >> 1) & 1) + (d >> 1);
    const u64 code = border_cell(cells, axis == 0 ? 1 : first,
                                 axis == 1   ? 1
                                 : axis == 0 ? first
                                             : second,
                                 axis == 2 ? 1 : second);
    return code != kNoOwner ? leaf_at(tree, code) : no_leaf(tree->shape.level);
}

// Makes leaf d of those around a grid vertex its owner, if it uses the vertex and is finer than the owner so
// far, or as fine and before it in Morton order.
MORTISE_FUNCTION void claim_vertex(MORTISE_GLOBAL u32* used, const Leaf leaf, u32 d, u64* owner, i32* level,
                                   u32* bit) {
    if (leaf.kind == kLeafNone || leaf.level < *level) return;
    if ((leaf.level > *level || leaf.code < *owner) && leaf_uses(used, leaf, 7 - d)) {
        *owner = leaf.code;
        *level = leaf.level;
        *bit = 7 - d;
    }
}

// Owner of grid vertex (x, y, z), in finest cells: its code, and the vertex's bit in the owner's mask.
MORTISE_FUNCTION u64 vertex_owner(const Tree* tree, MORTISE_GLOBAL u32* used, u32 x, u32 y, u32 z, u32* bit) {
    u64 owner = kNoOwner;
    i32 level = 0;
    for (u32 d = 0; d < 8; ++d) {
        const Leaf leaf = leaf_at_vertex(tree, x, y, z, d);
        if (((x | y | z) & (leaf_edge(tree, leaf.level) - 1)) != 0) continue;
        claim_vertex(used, leaf, d, &owner, &level, bit);
        // In a uniform tree the cell behind in all three directions precedes all others.
        if (owner != kNoOwner && d == 0 && !tree->shape.graded) break;
    }
    return owner;
}

// Owner of corner c, which the leaf with this code and mark uses: vertex_owner, but quick where the cell
// behind in all three directions owns it, since all leaves around are of one level, or coarser.
MORTISE_FUNCTION u64 corner_owner(const Tree* tree, MORTISE_GLOBAL u32* used, u64 code, u32 mark, u32 x,
                                  u32 y, u32 z, u32 edge, u32 c, u32* bit) {
    if ((mark & kFinerAround) == 0) {
        *bit = 7;
        if (c == 7) return code;
        const Leaf behind =
            leaf_at_vertex(tree, x + (c & 1) * edge, y + ((c >> 1) & 1) * edge, z + (c >> 2) * edge, 0);
        if (behind.level == (i32)(mark & kMarkLevel) && leaf_uses(used, behind, 7)) return behind.code;
    }
    return vertex_owner(tree, used, x + (c & 1) * edge, y + ((c >> 1) & 1) * edge, z + (c >> 2) * edge, bit);
}

// Makes a leaf, place d of those around an edge along `axis` of leaves of `edge_level`, the owner of its
// root, if it uses it and comes before the owner so far.
MORTISE_FUNCTION void claim_edge(MORTISE_GLOBAL u32* used, const Leaf leaf, i32 edge_level, u32 axis, u32 d,
                                 u64* owner, u32* bit) {
    const u32 edge_bit = 8 + 4 * axis + (3 - d);
    if (leaf.level == edge_level && leaf.code < *owner && leaf_uses(used, leaf, edge_bit)) {
        *owner = leaf.code;
        *bit = edge_bit;
    }
}

// Owner of the single root on the edge of leaves of `edge_level` along `axis` from vertex (x, y, z), in
// finest cells. Places around it count as in leaf_at_edge.
MORTISE_FUNCTION u64 edge_owner(const Tree* tree, MORTISE_GLOBAL u32* used, i32 edge_level, u32 axis, u32 x,
                                u32 y, u32 z, u32* bit) {
    const u32 edge = leaf_edge(tree, edge_level);
    u64 owner = kNoOwner;
    for (u32 d = 0; d < 4; ++d) {
        const u32 first = edge * ((d & 1) - 1);
        const u32 second = edge * ((d >> 1) - 1);
        const u64 code = code_at(tree, axis == 0 ? x : x + first,
                                 axis == 1   ? y
                                 : axis == 0 ? y + first
                                             : y + second,
                                 axis == 2 ? z : z + second);
        if (code != kNoOwner) claim_edge(used, leaf_at(tree, code), edge_level, axis, d, &owner, bit);
    }
    return owner;
}

// The same for edge e of the leaf with this code and level.
MORTISE_FUNCTION u64 own_edge_owner(const Tree* tree, MORTISE_GLOBAL u32* used, u64 code, i32 level, u32 e,
                                    u32* bit) {
    const BorderCells cells = border_cells(tree, code, level);
    u64 owner = kNoOwner;
    for (u32 d = 0; d < 4; ++d)
        claim_edge(used, leaf_at_edge(tree, &cells, e, d), level, e >> 2, d, &owner, bit);
    return owner;
}

// What numbers the nodes of one piece of a mesh: the leaves with codes in [begin, end), which own `nodes`
// nodes. Nodes of other owners follow, by their place in a sorted list of foreign_count keys (node_key).
// Arrays over the piece's own leaves begin with its first: IN leaf `first_in`, NIO leaf `first_nio`; arrays
// by meshed rank with the sum of the two.
typedef struct PieceRange {
    u64 begin;
    u64 end;
    u32 nodes;
    u32 foreign_count;
    u32 first_in;
    u32 first_nio;
} PieceRange;

// Name of a grid vertex or single root across pieces: its owner and its bit there.
#define kNodeBits 5
MORTISE_FUNCTION u64 node_key(u64 owner, u32 bit) { return (owner << kNodeBits) | bit; }

// Position of a node in its owner's mask.
MORTISE_FUNCTION u32 mask_rank(u32 mask, u32 bit) { return count_bits(mask & ((1u << bit) - 1u)); }

#endif
