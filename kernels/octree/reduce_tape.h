// Short tapes in private memory: words are dropped as their values become known, and surfaces on which the
// value does not depend. Pure functions of one tape; no buffers.
#ifndef MORTISE_OCTREE_REDUCE_TAPE_H
#define MORTISE_OCTREE_REDUCE_TAPE_H

#include "shared/tape.h"

// Tapes of more surfaces or words are not searched for surfaces on which they do not depend. A surface is one
// bit of the number of a choice of signs, a choice one bit of a word.
#define MAX_REDUCED 5
#define SHORT_TAPE 48        // words
#define NOTHING 0xffffffffu  // no word of a tape

// A short tape as words are dropped: the stack of values, each with the place where its code begins, and the
// number of words kept so far. Code of an operand is dropped only when its operation turns out to be known,
// so more words than in the end may be kept for a while.
typedef struct Pruning {
    int value[kTapeStack];
    uint begin[kTapeStack];
    int top;
    uint words;
} Pruning;

static void push_value(Pruning* p, int value) {
    ++p->top;
    p->value[p->top] = value;
    p->begin[p->top] = p->words;
}

// Takes an operation. Returns the word to keep at place p->words, or NOTHING.
static uint take_operation(Pruning* p, uint word) {
    const uint operation = tape_operation(word);
    uint kept = NOTHING;
    int combined;
    if (operation == kTapeSelectConst) {
        combined = combine_select(tape_otherwise(word), p->value[p->top], tape_region(word));
        kept = word;
    } else {
        const int b = p->value[p->top];
        const int a = p->value[p->top - 1];
        --p->top;
        if (a == kUnknown && b == kUnknown) kept = word;
        if (operation == kTapeSelect) {
            combined = combine_select(a, b, tape_region(word));
            if (a != kUnknown && b == kUnknown) kept = make_operation(kTapeSelectConst, tape_region(word), a);
        } else {
            combined = operation == kTapeAnd ? combine_and(a, b) : combine_or(a, b);
        }
    }
    p->value[p->top] = combined;
    if (combined == kUnknown) return kept;
    p->words = p->begin[p->top];
    return NOTHING;
}

// Drops the surfaces on which a short tape does not depend (both cofactors equal), such as the common plane
// of two flush solids. Works in place. Returns the new length; 0 if the tape is constant, whose value then is
// in `constant_value`.
static uint reduce(uint* tape, uint length, int* constant_value) {
    // Bit a: what the surface is in choice a.
    const uint inside[MAX_REDUCED] = {0xaaaaaaaau, 0xccccccccu, 0xf0f0f0f0u, 0xff00ff00u, 0xffff0000u};
    uint surfaces[MAX_REDUCED];
    uint count = 0;
    uint redundant = 0;
    uint region_bits = 0;
    uint regions[kRegionBits];  // by bit of the region's number
    uint literals = 0;
    uint selects = 0;
    uint same = 0;  // selects that do not depend on their formula
    if (length > SHORT_TAPE) return length;
    for (uint i = 0; i < length; ++i) {
        const uint operation = tape_operation(tape[i]);
        if (operation == kTapeSpatial) return length;
        if (operation == kTapeLiteral) {
            uint s = 0;
            while (s < count && surfaces[s] != tape_surface(tape[i])) ++s;
            if (s == MAX_REDUCED) return length;
            if (s == count) surfaces[count++] = tape_surface(tape[i]);
            ++literals;
        } else if (operation == kTapeSelect || operation == kTapeSelectConst) {
            region_bits |= (uint)(tape_region(tape[i]) | tape_otherwise(tape[i]));
            same |= tape_region(tape[i]) == tape_otherwise(tape[i]);
            ++selects;
        }
    }
    // A formula that names each surface once depends on all of them.
    if (literals == count && selects == 1 && !same) return length;
    {
        // The value for all choices at once. Regions are at the bottom of the stack only.
        uint stack[kTapeStack];
        int top = -1;
        for (uint i = 0; i < length; ++i) {
            const uint word = tape[i];
            const uint operation = tape_operation(word);
            if (operation == kTapeLiteral) {
                uint s = 0;
                while (surfaces[s] != tape_surface(word)) ++s;
                stack[++top] = tape_negated(word) ? ~inside[s] : inside[s];
            } else if (operation == kTapeAnd || operation == kTapeOr) {
                const uint b = stack[top--];
                stack[top] = operation == kTapeAnd ? stack[top] & b : stack[top] | b;
            } else {
                const uint a = stack[top];
                const uint region = (uint)tape_region(word);
                const uint otherwise = (uint)tape_otherwise(word);
                for (uint j = 0; (region_bits >> j) != 0; ++j) {
                    const uint rest = operation == kTapeSelect ? regions[j]
                                      : ((otherwise >> j) & 1) ? 0xffffffffu
                                                               : 0u;
                    regions[j] = (((region >> j) & 1) ? a : 0u) | (rest & ~a);
                }
                if (operation == kTapeSelect) --top;
            }
        }
    }
    *constant_value = 0;
    for (uint s = 0; s < count; ++s) {
        uint differs = 0;
        for (uint j = 0; (region_bits >> j) != 0; ++j) {
            differs |= (regions[j] ^ (regions[j] >> (1u << s))) & ~inside[s];
        }
        if (differs == 0) redundant |= 1u << s;
    }
    for (uint j = 0; (region_bits >> j) != 0; ++j) *constant_value |= (int)((regions[j] & 1u) << j);
    if (redundant == 0) return length;
    if (redundant == (1u << count) - 1u) return 0;
    Pruning p;  // in place: never more words than were read
    p.top = -1;
    p.words = 0;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        uint kept = NOTHING;
        if (tape_operation(word) == kTapeLiteral) {
            uint s = 0;
            while (surfaces[s] != tape_surface(word)) ++s;
            if ((redundant >> s) & 1) {
                push_value(&p, (int)tape_negated(word));  // may be taken as outside everywhere
            } else {
                push_value(&p, kUnknown);
                kept = word;
            }
        } else {
            kept = take_operation(&p, word);
        }
        if (kept != NOTHING) tape[p.words++] = kept;
    }
    return p.words;
}

#endif
