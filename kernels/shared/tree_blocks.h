// Words of a uniform tree's bitmaps as blocks of cells: the 32 codes of a word are 4 x 4 x 2 cells, so what
// lies around all of them comes from eight words and a few shifts.
#ifndef MORTISE_SHARED_TREE_BLOCKS_H
#define MORTISE_SHARED_TREE_BLOCKS_H

#include "tree.h"

#define kNoWord 0xffffffffu
// Cells of a block and of the layer behind it along each axis.
#define kBlockReach 75

// A block and those one block back: index a, along the axes whose bits are set; 0 is the block itself.
typedef struct TreeBlock {
    u32 word[8];    // kNoWord: beyond the root box, or not stored
    u32 in[8];      // its IN cells
    u32 meshed[8];  // its IN and NIO cells
} TreeBlock;

MORTISE_FUNCTION void make_block(const Tree* tree, u32 word, TreeBlock* block) {
    const u64 own = word_code(tree, word);
    for (u32 a = 0; a < 8; ++a) {
        const u64 code = cell_behind(own, a);
        u32 is_stored = 0;
        const u32 at = code != kNoOwner ? find_word(tree, code, &is_stored) : 0;
        block->word[a] = is_stored ? at : kNoWord;
        block->in[a] = is_stored ? tree->in_bits[at] : 0;
        block->meshed[a] = is_stored ? block->in[a] | tree->nio_bits[at] : 0;
    }
}

// Cells of the block that are IN, as all seven cells behind them are. Such a cell owns its last corner and no
// other one, and each of its corners is the last one of an IN cell.
MORTISE_FUNCTION u32 inner_cells(const TreeBlock* block) {
    u32 behind[8];  // bit k of [a]: the cell one step back from cell k along the axes of a is IN
    u32 inner = block->in[0];
    for (u32 a = 0; a < 8; ++a) behind[a] = block->in[a];
    // x is bits 0 and 3 of a cell's place in the word, y bits 1 and 4, z bit 2.
    for (u32 a = 1; a < 8; a += 2) {
        const u32 own = behind[a ^ 1];
        behind[a] =
            ((own & 0x55555555u) << 1) | ((own & 0x00aa00aau) << 7) | ((behind[a] & 0xaa00aa00u) >> 9);
    }
    for (u32 a = 2; a < 8; a += (a & 1) ? 3 : 1) {
        const u32 own = behind[a ^ 2];
        behind[a] =
            ((own & 0x33333333u) << 2) | ((own & 0x0000ccccu) << 14) | ((behind[a] & 0xcccc0000u) >> 18);
    }
    for (u32 a = 4; a < 8; ++a) {
        const u32 own = behind[a ^ 4];
        behind[a] = ((own & 0x0f0f0f0fu) << 4) | ((behind[a] & 0xf0f0f0f0u) >> 4);
    }
    for (u32 a = 1; a < 8; ++a) inner &= behind[a];
    return inner;
}

// The cell at a place of a word, within the word's block: the inverse of place_in_block along each axis. In
// any tree it is what the place adds to the coordinates of the word's code.
MORTISE_FUNCTION u32 block_x(u32 place) { return (place & 1) | ((place >> 2) & 2); }
MORTISE_FUNCTION u32 block_y(u32 place) { return ((place >> 1) & 1) | ((place >> 3) & 2); }
MORTISE_FUNCTION u32 block_z(u32 place) { return (place >> 2) & 1; }

// Place in its word of the cell at (x, y, z) of a block.
MORTISE_FUNCTION u32 place_in_block(u32 x, u32 y, u32 z) {
    return (x & 1) | ((y & 1) << 1) | (z << 2) | ((x & 2) << 2) | ((y & 2) << 3);
}

#endif
