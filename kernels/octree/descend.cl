// One level of the octree: every node whose region is unknown is split into eight children, each classified
// by interval arithmetic on the node's pruned tape (docs/design/octree.md; Saxena & Perucchio 1992, §3: IN /
// OUT / ? cells).
//
// Reads   parents[first_item + i], tapes (words of the parents), surfaces, ops, spatial
//         (kernels/shared/spatial.h).
// Writes  children[8i + c] for parent i, unknown_counts[i], in_counts[i], new words of tapes; used[0], words
//         of all tapes, and used[1], words of the longest tape of an undecided child;
//         scratch: for each work-item 1 + LANES values for each of slot_words words; no tape has more.
// One work-item handles one parent; its eight children are the lanes of one vector on CPUs (LANES 8) and a
// loop on GPUs (LANES 1). Guarantees: a child is IN or OUT only if its closed cube is, whatever the rounding;
// tapes of any length are pruned alike; results do not depend on the order of work-items, though the places
// of new tapes do. If the tape arena is too small, used[0] still counts the words that were needed (up to
// kMostTapeWords), and the caller runs the level again in a larger arena.
#include "octree/classify_surface.h"
#include "octree/reduce_tape.h"
#include "shared/bounds.h"
#include "shared/lattice.h"
#include "shared/spatial.h"
#include "shared/tape.h"

#define KEPT_WORDS SHORT_TAPE  // of a child's tape that are kept while the parent's is evaluated

// What a spatial word is in child c: 0, 1 or kUnknown.
static int spatial_state(uint entry, uint word) {
    return entry > kSpatialIn ? kUnknown : (int)(entry ^ tape_negated(word));
}

// Number of words that stand for an undecided spatial word in a child: the child's node, or its formula.
static uint expanded_words(__global const uint* spatial, uint entry) {
    return entry & kSpatialFormula ? spatial[entry & ~kSpatialFormula] : 1u;
}

// Word k of them.
static uint expanded_word(__global const uint* spatial, uint entry, uint word, uint k) {
    if (entry & kSpatialFormula) {
        const uint copied = spatial[(entry & ~kSpatialFormula) + 1 + k];
        return tape_negated(word) ? negate_word(copied) : copied;
    }
    return make_spatial(entry, tape_negated(word));
}

// Bit k: lane k of `yes`; bit 8 + k: lane k of `also`. A lane is set where its condition holds.
static uint lane_bits(lanes_int yes, lanes_int also) {
#if LANES == 8
    const int8 bits =
        (yes & (int8)(1, 2, 4, 8, 16, 32, 64, 128)) | (also & ((int8)(1, 2, 4, 8, 16, 32, 64, 128) << 8));
    const int4 half_bits = bits.lo | bits.hi;
    const int2 quarter_bits = half_bits.lo | half_bits.hi;
    return (uint)(quarter_bits.x | quarter_bits.y);
#else
    return (uint)((yes ? 1 : 0) | (also ? 256 : 0));
#endif
}

// Writes the children of a round, by their fields.
static void store_children(lanes_int place, lanes_int length, __global ChildNode* children) {
#if LANES == 8
    vstore16((int16)(place.s0, length.s0, place.s1, length.s1, place.s2, length.s2, place.s3, length.s3,
                     place.s4, length.s4, place.s5, length.s5, place.s6, length.s6, place.s7, length.s7),
             0, (__global int*)children);
#else
    children->place = (uint)place;
    children->tape_length = (uint)length;
#endif
}

// From the last word to the first: in which lanes is a word needed by the operation that takes its value, and
// kept? Each entry of `masks` held the lanes where the value is unknown, and from bit 8 on those where the
// word is to stay if it is needed; then it holds those where it stays. Returns the lanes that keep all words.
static uint find_kept(__global const uint* tape, uint length, __global ushort* masks) {
    uint needed[kTapeStack];
    int top = 0;
    uint all = 0xffu;
    needed[0] = 0xffu;
    for (uint i = length; i-- > 0;) {
        const uint operation = tape_operation(tape[i]);
        const uint mask = masks[i];
        const uint here = needed[top];
        const uint stays = here & (mask >> 8);
        all &= stays;
        masks[i] = (ushort)stays;
        if (operation == kTapeLiteral || operation == kTapeSpatial) {
            --top;
        } else {
            needed[top] = here & mask;
            if (operation != kTapeSelectConst) {
                needed[top + 1] = here & mask;
                ++top;
            }
        }
    }
    return all;
}

// The word that is kept for a lane: a select whose rest is known takes that as a constant. `rests` holds what
// is known of it, for each lane; kMaxRegions + 1: unknown.
static uint kept_word(uint word, __global const ushort* rests, uint lane) {
    if (tape_operation(word) != kTapeSelect || rests[lane] > kMaxRegions) return word;
    return make_operation(kTapeSelectConst, tape_region(word), (int)rests[lane]);
}

// The first words, at most KEPT_WORDS, of what a child keeps of its parent's tape; returns how many it keeps.
// own[KEPT_WORDS] is scratch.
static uint keep_words(__global const uint* tape, uint length, __global const uint* spatial,
                       __global const ushort* masks, __global const ushort* rests, uint lane, uint c,
                       uint* own) {
    uint at = 0;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        const uint stays = ((uint)masks[i] >> lane) & 1;
        if (tape_operation(word) == kTapeSpatial) {
            const uint entry = spatial[tape_surface(word) + c];
            const uint count = stays ? expanded_words(spatial, entry) : 0;
            for (uint k = 0; k < count; ++k, ++at)
                own[min(at, (uint)KEPT_WORDS)] = expanded_word(spatial, entry, word, k);
        } else {
            // Whether it stays is hard to foretell, so the next word overwrites what does not.
            own[min(at, (uint)KEPT_WORDS)] = kept_word(word, rests + i * LANES, lane);
            at += stays;
        }
    }
    return at;
}

// Writes what a child keeps of its parent's tape.
static void copy_kept(__global const uint* tape, uint length, __global const uint* spatial,
                      __global const ushort* masks, __global const ushort* rests, uint lane, uint c,
                      __global uint* out) {
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        if (((masks[i] >> lane) & 1) == 0) continue;
        if (tape_operation(word) == kTapeSpatial) {
            const uint entry = spatial[tape_surface(word) + c];
            const uint count = expanded_words(spatial, entry);
            for (uint k = 0; k < count; ++k) *out++ = expanded_word(spatial, entry, word, k);
        } else {
            *out++ = kept_word(word, rests + i * LANES, lane);
        }
    }
}

// What is known of a tape in the children of a round, by lane: a region, or kUnknown. masks[i] and rests are
// for find_kept and kept_word. Sets *anew to lanes whose tapes are written even if all words stay.
static lanes_int evaluate_children(__global const uint* tape, uint length,
                                   __global const SurfaceBounds* surfaces, __global const ExpressionOp* ops,
                                   __global const uint* spatial, Cube cube, int round, __global ushort* masks,
                                   __global ushort* rests, uint* anew) {
    const lanes_int unsure = (lanes_int)(kUnknown);
    lanes_int stack[kTapeStack];
    int top = -1;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        const uint operation = tape_operation(word);
        lanes_int value;
        lanes_int keeps;
        if (operation == kTapeLiteral) {
            const lanes_int sign = classify_surface(surfaces + tape_surface(word), ops, cube);
            const int inside = tape_negated(word) ? 0 : 1;
            value = select(select(unsure, (lanes_int)(inside), sign < 0), (lanes_int)(1 - inside), sign > 0);
            keeps = value == unsure;
            ++top;
        } else if (operation == kTapeSpatial) {
            int states[LANES];
            for (int lane = 0; lane < LANES; ++lane)
                states[lane] = spatial_state(spatial[tape_surface(word) + (uint)(round + lane)], word);
            value = LOAD_LANES(states);
            keeps = value == unsure;
            *anew = 0xffu;
            ++top;
        } else if (operation == kTapeSelectConst) {
            const lanes_int a = stack[top];
            const int region = tape_region(word);
            const int otherwise = tape_otherwise(word);
            const lanes_int same = (lanes_int)(region == otherwise ? region : kUnknown);
            value = select(select(same, (lanes_int)(otherwise), a == 0), (lanes_int)(region), a == 1);
            keeps = value == unsure;
        } else {
            const lanes_int b = stack[top--];
            const lanes_int a = stack[top];
            if (operation == kTapeAnd) {
                value = select(select(unsure, (lanes_int)(1), (a == 1) & (b == 1)), (lanes_int)(0),
                               (a == 0) | (b == 0));
                keeps = (a == unsure) & (b == unsure);
            } else if (operation == kTapeOr) {
                value = select(select(unsure, (lanes_int)(0), (a == 0) & (b == 0)), (lanes_int)(1),
                               (a == 1) | (b == 1));
                keeps = (a == unsure) & (b == unsure);
            } else {
                const lanes_int region = (lanes_int)(tape_region(word));
                int rest[LANES];
                value = select(select(select(unsure, region, a == region), a, b == 0), region, b == 1);
                keeps = (value == unsure) & (b == unsure);
                STORE_LANES(a, rest);
                for (int lane = 0; lane < LANES; ++lane)
                    rests[i * LANES + (uint)lane] =
                        (ushort)(rest[lane] == kUnknown ? kMaxRegions + 1 : rest[lane]);
            }
        }
        stack[top] = value;
        masks[i] = (ushort)lane_bits(value == unsure, keeps);
    }
    return stack[0];
}

// The short tapes that were made for a parent's children: siblings share equal ones.
typedef struct NewTapes {
    uint offsets[8];
    uint lengths[8];
    uint count;
} NewTapes;

// Place of a tape among them, or NOTHING.
static uint find_tape(__global const uint* tapes, const NewTapes* made, const uint* tape, uint length) {
    for (uint k = 0; k < made->count; ++k) {
        uint i = 0;
        if (made->lengths[k] != length) continue;
        while (i < length && tapes[made->offsets[k] + i] == tape[i]) ++i;
        if (i == length) return made->offsets[k];
    }
    return NOTHING;
}

// An undecided child c, in a lane, that does not keep all words: with a reduced tape of its own, or a
// sibling's; as it was if the arena is full; decided after all if nothing is left.
static ChildNode shortened_child(const TreeNode parent, __global uint* tapes, __global const uint* spatial,
                                 __global const ushort* masks, __global const ushort* rests, uint lane,
                                 uint c, uint capacity, __global uint* used, NewTapes* made) {
    __global const uint* tape = tapes + parent.tape_offset;
    uint own[KEPT_WORDS + 1];
    uint words = keep_words(tape, parent.tape_length, spatial, masks, rests, lane, c, own);
    const int is_short = words <= KEPT_WORDS;
    uint offset = NOTHING;
    ChildNode child;
    child.place = parent.tape_offset;
    child.tape_length = parent.tape_length;
    if (is_short) {
        int constant_value = 0;
        words = reduce(own, words, &constant_value);
        if (words == 0) {
            child.place = (uint)constant_value;
            child.tape_length = 0;
            return child;
        }
        offset = find_tape(tapes, made, own, words);
    }
    if (offset == NOTHING) {
        // Plain reads of used may be old: they only save atomic operations.
        const uint at = used[0] < kMostTapeWords ? atomic_add(used, words) : capacity;
        if (at < capacity && words <= capacity - at) {
            offset = at;
            if (is_short) {
                for (uint i = 0; i < words; ++i) tapes[at + i] = own[i];
                made->offsets[made->count] = at;
                made->lengths[made->count++] = words;
            } else {
                copy_kept(tape, parent.tape_length, spatial, masks, rests, lane, c, tapes + at);
            }
        }
    }
    if (offset != NOTHING) {
        child.place = offset;
        child.tape_length = words;
    }
    return child;
}

// The work of one item: see the top. `masks` and `rests` are its scratch.
MORTISE_NOINLINE void split_parent(__global const TreeNode* parents, __global uint* tapes,
                                   __global const SurfaceBounds* surfaces, __global const ExpressionOp* ops,
                                   __global const uint* spatial, __global ChildNode* children,
                                   __global uint* unknown_counts, __global uint* in_counts,
                                   __global uint* used, __global ushort* masks, __global ushort* rests,
                                   uint capacity, int level, uint item) {
    const TreeNode parent = parents[item];
    __global const uint* tape = tapes + parent.tape_offset;
    const float half_edge = 1.0f / (float)(2u << level);  // of a child, whose level is `level`
    // Centre of the parent: odd multiples of a child's edge, exact in float up to kMaxTreeLevel.
    const float edge = 2.0f * half_edge;
    const float x = (float)(2 * gather_bits(parent.morton) + 1) * edge;
    const float y = (float)(2 * gather_bits(parent.morton >> 1) + 1) * edge;
    const float z = (float)(2 * gather_bits(parent.morton >> 2) + 1) * edge;
    NewTapes made;
    uint longest = 0;
    uint unknown = 0;
    uint in = 0;
    made.count = 0;
    for (int round = 0; round < ROUNDS; ++round) {
        uint anew = level == 1 ? 0xffu : 0u;
        Cube cube;
        cube.x = x + half_edge * CHILD_X(round);
        cube.y = y + half_edge * CHILD_Y(round);
        cube.z = z + half_edge * CHILD_Z(round);
        cube.half_edge = half_edge;
        const lanes_int value = evaluate_children(tape, parent.tape_length, surfaces, ops, spatial, cube,
                                                  round, masks, rests, &anew);
        // An unchanged tape was reduced when it was made; the root's is written anew.
        const uint changed = anew | ~find_kept(tape, parent.tape_length, masks);
        const lanes_int goes_on = value == (lanes_int)(kUnknown);
        const uint bits = lane_bits(goes_on, value > 0);
        uint undecided = bits & 0xffu;
        in += popcount(bits >> 8);
        store_children(select(value, (lanes_int)((int)parent.tape_offset), goes_on),
                       select((lanes_int)(0), (lanes_int)((int)parent.tape_length), goes_on),
                       children + 8 * item + round);
        if ((undecided & ~changed) != 0) longest = max(longest, parent.tape_length);
        for (uint rest = undecided & changed; rest != 0; rest &= rest - 1) {
            const uint lane = mortise_lowest_bit(rest);
            const uint c = (uint)round + lane;
            const ChildNode child =
                shortened_child(parent, tapes, spatial, masks, rests, lane, c, capacity, used, &made);
            if (child.tape_length == 0) {
                undecided ^= 1u << lane;
                in += child.place > 0;
            }
            longest = max(longest, child.tape_length);
            children[8 * item + c] = child;
        }
        unknown += popcount(undecided);
    }
    unknown_counts[item] = unknown;
    in_counts[item] = in;
    if (longest > used[1]) atomic_max(used + 1, longest);
}

MORTISE_KERNEL void descend(__global const TreeNode* parents, __global uint* tapes,
                            __global const SurfaceBounds* surfaces, __global const ExpressionOp* ops,
                            __global const uint* spatial, __global ChildNode* children,
                            __global uint* unknown_counts, __global uint* in_counts, __global uint* used,
                            __global ushort* scratch, uint capacity, uint first_item, uint slot_words,
                            int level, uint items) {
    if (get_global_id(0) >= items) return;
    const ulong slot = get_global_id(0) * (ulong)slot_words;
    __global ushort* rests = scratch + items * (ulong)slot_words;
    split_parent(parents, tapes, surfaces, ops, spatial, children, unknown_counts, in_counts, used,
                 scratch + slot, rests + slot * LANES, capacity, level, first_item + (uint)get_global_id(0));
}

// Packs the children of a level in Morton order: unknown ones into `next`, IN ones behind `in_base` of
// `in_nodes`. One work-item handles one parent; offsets come from exclusive scans of its counts.
MORTISE_KERNEL void gather_children(__global const TreeNode* parents, __global const ChildNode* children,
                                    __global const uint* unknown_offsets, __global const uint* in_offsets,
                                    __global TreeNode* next, __global InNode* in_nodes, uint in_base,
                                    int level, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const ulong first_child = parents[item].morton << 3;
    uint at_unknown = unknown_offsets[item];
    uint at_in = in_base + in_offsets[item];
    uint unknown = 0;
    uint in = 0;
    for (uint c = 0; c < 8; ++c) {
        const ChildNode child = children[8 * item + c];
        unknown |= (child.tape_length != 0 ? 1u : 0u) << c;
        in |= (child.place != 0 ? 1u : 0u) << c;
    }
    for (uint rest = unknown; rest != 0; rest &= rest - 1) {
        const uint c = mortise_lowest_bit(rest);
        TreeNode node;
        node.morton = first_child | (ulong)c;
        node.tape_offset = children[8 * item + c].place;
        node.tape_length = children[8 * item + c].tape_length;
        next[at_unknown++] = node;
    }
    for (uint rest = in & ~unknown; rest != 0; rest &= rest - 1) {
        const uint c = mortise_lowest_bit(rest);
        InNode node;
        node.morton = first_child | (ulong)c;
        node.level = (uint)level;
        node.region = children[8 * item + c].place;
        in_nodes[at_in++] = node;
    }
}
