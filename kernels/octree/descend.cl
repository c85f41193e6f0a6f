// One level of the octree: every node whose region is unknown is split into eight children, each classified
// by interval arithmetic on the node's pruned tape (algorithms.md §1; Saxena & Perucchio 1992, §3: IN / OUT /
// ? cells).
//
// Reads   parents, tapes (words of the parents), surfaces, ops, spatial (kernels/shared/spatial.h).
// Writes  children[8i + c], states[8i + c] for parent i, unknown_counts[i], in_counts[i], new words of tapes.
// One work-item handles one parent; its eight children are the lanes of one vector on CPUs (LANES 8) and a
// loop on GPUs (LANES 1). Guarantees: a child is IN or OUT only if its closed cube is, whatever the rounding;
// results do not depend on the order of work-items, though the places of new tapes do. If the tape arena is
// too small, used[0] still counts the words that were needed, and the caller runs the level again in a larger
// arena.
#include "shared/bounds.h"
#include "shared/expression_bounds.h"
#include "shared/lattice.h"
#include "shared/spatial.h"
#include "shared/surface.h"
#include "shared/tape.h"

#if LANES == 8
typedef float8 lanes_float;
typedef int8 lanes_int;
#define ROUNDS 1
#define CHILD_X(round) (lanes_float)(-1, 1, -1, 1, -1, 1, -1, 1)
#define CHILD_Y(round) (lanes_float)(-1, -1, 1, 1, -1, -1, 1, 1)
#define CHILD_Z(round) (lanes_float)(-1, -1, -1, -1, 1, 1, 1, 1)
#define STORE_LANES(values, array) vstore8(values, 0, array)
#define LOAD_LANES(array) vload8(0, array)
#elif LANES == 1
typedef float lanes_float;
typedef int lanes_int;
#define ROUNDS 8
#define CHILD_X(round) (((round)&1) ? 1.0f : -1.0f)
#define CHILD_Y(round) (((round)&2) ? 1.0f : -1.0f)
#define CHILD_Z(round) (((round)&4) ? 1.0f : -1.0f)
#define STORE_LANES(values, array) (array)[0] = (values)
#define LOAD_LANES(array) ((array)[0])
#else
#error "LANES must be 1 or 8"
#endif

// States of literals beyond this many words are treated as unknown by the pruning: conservative.
#define MAX_CHOICES 2048
// Tapes of more surfaces or words are not searched for surfaces on which they do not depend.
#define MAX_REDUCED 5
#define MAX_REDUCED_WORDS 48
#define RELATIVE 9.5367431640625e-7f  // 2^-20: more than the rounding of any sum below

typedef struct Cube {
    lanes_float x;
    lanes_float y;
    lanes_float z;
    float half_edge;
} Cube;

// -1: f < 0 on the closed cube, +1: f > 0, 0: undecided.
lanes_int decide(lanes_float low, lanes_float high) {
    return select(select((lanes_int)(0), (lanes_int)(-1), high < 0.0f), (lanes_int)(1), low > 0.0f);
}

lanes_float interval_square_low(lanes_float low, lanes_float high) {
    const lanes_float least = fmin(fabs(low), fabs(high));
    const lanes_float inside = fmin(high, -low);  // positive where the interval holds zero
    return select(least * least, (lanes_float)(0.0f), inside >= 0.0f);
}

lanes_float interval_square_high(lanes_float low, lanes_float high) {
    const lanes_float most = fmax(fabs(low), fabs(high));
    return most * most;
}

lanes_int classify_surface(__global const SurfaceBounds* s, __global const ExpressionOp* ops, Cube cube) {
    lanes_float u[3];
    float width[3];
    if (s->kind == kSurfacePatch) return (lanes_int)(0);  // is in the tape only where it passes (spatial.h)
    const int rows = s->kind == kSurfacePlane ? 1 : 3;
    for (int i = 0; i < rows; ++i) {
        const float a = s->map[4 * i];
        const float b = s->map[4 * i + 1];
        const float c = s->map[4 * i + 2];
        u[i] = a * cube.x + b * cube.y + c * cube.z + s->map[4 * i + 3];
        width[i] = cube.half_edge * (fabs(a) + fabs(b) + fabs(c)) * (1.0f + RELATIVE);
    }
    if (s->kind == kSurfacePlane) {
        const float reach = width[0] + s->error[0];
        return decide(u[0] - reach, u[0] + reach);
    }
    if (s->kind == kSurfaceQuadric) {
        // Exact Taylor form about the centre, linear part and squares bounded apart.
        lanes_float value = s->form[3];
        lanes_float size = fabs(s->form[3]);
        lanes_float gx = 0;
        lanes_float gy = 0;
        lanes_float gz = 0;
        lanes_float error = 0;
        float above = 0;
        float below = 0;
        for (int i = 0; i < 3; ++i) {
            const float form = s->form[i];
            const lanes_float weighted = form * u[i];
            const lanes_float magnitude = fabs(weighted);
            const float square = form * width[i] * width[i];
            value += weighted * u[i];
            size += magnitude * fabs(u[i]);
            gx += weighted * s->map[4 * i];
            gy += weighted * s->map[4 * i + 1];
            gz += weighted * s->map[4 * i + 2];
            error += 2.0f * magnitude * (s->error[i] + RELATIVE * width[i]) +
                     fabs(form) * s->error[i] * (s->error[i] + 2.0f * width[i]);
            if (square > 0) {
                above += square;
            } else {
                below += square;
            }
        }
        {
            const lanes_float spread = 2.0f * cube.half_edge * (fabs(gx) + fabs(gy) + fabs(gz)) + error +
                                       RELATIVE * (size + above - below);
            return decide(value - spread + below, value + spread + above);
        }
    }
    {
        lanes_float low[3];
        lanes_float high[3];
        for (int i = 0; i < 3; ++i) {
            const float reach = width[i] + s->error[i];
            low[i] = u[i] - reach;
            high[i] = u[i] + reach;
        }
        if (s->kind == kSurfaceExpression) {
            float lows[3][LANES];
            float highs[3][LANES];
            int signs[LANES];
            for (int i = 0; i < 3; ++i) {
                STORE_LANES(low[i], lows[i]);
                STORE_LANES(high[i], highs[i]);
            }
            for (int lane = 0; lane < LANES; ++lane) {
                const Interval f = expression_bounds(ops + s->first_op, s->op_count,
                                                     make_interval(lows[0][lane], highs[0][lane]),
                                                     make_interval(lows[1][lane], highs[1][lane]),
                                                     make_interval(lows[2][lane], highs[2][lane]));
                signs[lane] = interval_sign(f);
            }
            return LOAD_LANES(signs);
        }
        {
            const lanes_float radial_low =
                sqrt(interval_square_low(low[0], high[0]) + interval_square_low(low[1], high[1])) *
                (1.0f - RELATIVE);
            const lanes_float radial_high =
                sqrt(interval_square_high(low[0], high[0]) + interval_square_high(low[1], high[1])) *
                (1.0f + RELATIVE);
            if (s->kind == kSurfaceCone) {
                const lanes_float slack = RELATIVE * (radial_high + fabs(low[2]) + fabs(high[2]));
                lanes_int sign = decide(radial_low + low[2] - slack, radial_high + high[2] + slack);
                // Below the apex f has the sign of u0² + u1² - u2², whose Taylor form is sharper.
                const lanes_float value = u[0] * u[0] + u[1] * u[1] - u[2] * u[2];
                const lanes_float size = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
                const lanes_float gx = u[0] * s->map[0] + u[1] * s->map[4] - u[2] * s->map[8];
                const lanes_float gy = u[0] * s->map[1] + u[1] * s->map[5] - u[2] * s->map[9];
                const lanes_float gz = u[0] * s->map[2] + u[1] * s->map[6] - u[2] * s->map[10];
                lanes_float error = 0;
                for (int i = 0; i < 3; ++i) {
                    error += 2.0f * fabs(u[i]) * (s->error[i] + RELATIVE * width[i]) +
                             s->error[i] * (s->error[i] + 2.0f * width[i]);
                }
                {
                    const float above = width[0] * width[0] + width[1] * width[1];
                    const float below = -width[2] * width[2];
                    const lanes_float spread = 2.0f * cube.half_edge * (fabs(gx) + fabs(gy) + fabs(gz)) +
                                               error + RELATIVE * (size + above - below);
                    const lanes_int sharper = decide(value - spread + below, value + spread + above);
                    sign = select(sign, sharper, (high[2] < 0.0f) & (sign == 0));
                }
                return sign;
            }
            {
                const lanes_float ring_low = radial_low - s->form[0] * (1.0f + RELATIVE);
                const lanes_float ring_high = radial_high - s->form[0] * (1.0f - RELATIVE);
                const lanes_float f_low = interval_square_low(ring_low, ring_high) +
                                          interval_square_low(low[2], high[2]) + s->form[3];
                const lanes_float f_high = interval_square_high(ring_low, ring_high) +
                                           interval_square_high(low[2], high[2]) + s->form[3];
                const lanes_float slack = RELATIVE * (fabs(f_low) + fabs(f_high) + 2.0f * fabs(s->form[3]));
                return decide(f_low - slack, f_high + slack);
            }
        }
    }
}

// State of word i for lane c: 0 unknown, 1 false, 2 true.
int choice_of(const ushort* choices, uint i, int c) {
    return i < MAX_CHOICES ? (choices[i] >> (2 * c)) & 3 : 0;
}

// What a spatial word is in child c: 0, 1 or kUnknown.
int spatial_state(uint entry, uint word) {
    return entry > kSpatialIn ? kUnknown : (int)(entry ^ tape_negated(word));
}

// Writes what stands for an undecided spatial word in a child, the child's node or its formula, to out (null:
// counts only). Returns the number of words.
uint expand_spatial(__global const uint* spatial, uint entry, uint word, __global uint* out) {
    const uint place = entry & ~kSpatialFormula;
    if (entry == place) {
        if (out) out[0] = make_spatial(place, tape_negated(word));
        return 1;
    }
    if (out) {
        for (uint i = 0; i < spatial[place]; ++i) {
            const uint copied = spatial[place + 1 + i];
            out[i] = tape_negated(word) ? negate_word(copied) : copied;
        }
    }
    return spatial[place];
}

// Copies what is unknown of a tape for child c; out may be null to count only. Returns the number of words.
// While it runs it writes up to `peak` words: code of an operand is dropped only when its operation turns out
// to be known. `expanded` tells whether spatial words were replaced.
uint prune(__global const uint* tape, uint length, __global const uint* spatial, const ushort* choices, int c,
           __global uint* out, uint* peak, int* expanded) {
    int value[kTapeStack];
    uint begin[kTapeStack];
    int top = -1;
    uint words = 0;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        const uint operation = tape_operation(word);
        uint emitted = word;
        int emits = 0;
        if (operation == kTapeLiteral) {
            const int choice = choice_of(choices, i, c);
            ++top;
            value[top] = choice == 0 ? kUnknown : choice - 1;
            begin[top] = words;
            emits = choice == 0;
        } else if (operation == kTapeSpatial) {
            const uint entry = spatial[tape_surface(word) + (uint)c];
            ++top;
            value[top] = spatial_state(entry, word);
            begin[top] = words;
            if (value[top] == kUnknown) {
                words += expand_spatial(spatial, entry, word, out ? out + words : 0);
                *peak = max(*peak, words);
                *expanded = 1;
            }
        } else if (operation == kTapeSelectConst) {
            value[top] = combine_select(tape_otherwise(word), value[top], tape_region(word));
            if (value[top] == kUnknown) {
                emits = 1;
            } else {
                words = begin[top];
            }
        } else {
            const int b = value[top];
            const int a = value[top - 1];
            int combined;
            --top;
            emits = a == kUnknown && b == kUnknown;
            if (operation == kTapeSelect) {
                combined = combine_select(a, b, tape_region(word));
                if (a != kUnknown && b == kUnknown) {
                    emits = 1;
                    emitted = make_operation(kTapeSelectConst, tape_region(word), a);
                }
            } else {
                combined = operation == kTapeAnd ? combine_and(a, b) : combine_or(a, b);
            }
            if (combined != kUnknown) {
                emits = 0;
                words = begin[top];
            }
            value[top] = combined;
        }
        if (emits) {
            if (out) out[words] = emitted;
            ++words;
            *peak = max(*peak, words);
        }
    }
    return words;
}

// Value of a tape whose surfaces are all given: bit s of `inside` tells of surfaces[s].
int evaluate(__global const uint* tape, uint length, const uint* surfaces, uint inside) {
    int value[kTapeStack];
    int top = -1;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        const uint operation = tape_operation(word);
        if (operation == kTapeLiteral) {
            uint s = 0;
            while (surfaces[s] != tape_surface(word)) ++s;
            value[++top] = (int)(((inside >> s) & 1) ^ tape_negated(word));
        } else if (operation == kTapeSelectConst) {
            value[top] = combine_select(tape_otherwise(word), value[top], tape_region(word));
        } else {
            const int b = value[top--];
            const int a = value[top];
            value[top] = operation == kTapeAnd  ? combine_and(a, b)
                         : operation == kTapeOr ? combine_or(a, b)
                                                : combine_select(a, b, tape_region(word));
        }
    }
    return value[0];
}

// Drops the surfaces on which a short tape does not depend (both cofactors equal), such as the common plane
// of two flush solids. Works in place, on the caller's own words. Returns the new length; 0 if the tape is
// constant, whose value then is in `constant_value`.
uint reduce(__global uint* tape, uint length, int* constant_value) {
    uint surfaces[MAX_REDUCED];
    int table[1 << MAX_REDUCED];
    ushort choices[MAX_REDUCED_WORDS];
    uint count = 0;
    uint redundant = 0;
    if (length > MAX_REDUCED_WORDS) return length;
    for (uint i = 0; i < length; ++i) {
        if (tape_operation(tape[i]) == kTapeSpatial) return length;
        if (tape_operation(tape[i]) == kTapeLiteral) {
            uint s = 0;
            while (s < count && surfaces[s] != tape_surface(tape[i])) ++s;
            if (s == MAX_REDUCED) return length;
            if (s == count) surfaces[count++] = tape_surface(tape[i]);
        }
    }
    for (uint a = 0; a < (1u << count); ++a) table[a] = evaluate(tape, length, surfaces, a);
    for (uint s = 0; s < count; ++s) {
        int same = 1;
        for (uint a = 0; a < (1u << count); ++a) same = same && table[a] == table[a ^ (1u << s)];
        if (same) redundant |= 1u << s;
    }
    if (redundant == 0) return length;
    *constant_value = table[0];
    if (redundant == (1u << count) - 1u) return 0;
    // A redundant surface may be taken as outside everywhere.
    for (uint i = 0; i < length; ++i) {
        uint s = 0;
        choices[i] = 0;
        if (tape_operation(tape[i]) != kTapeLiteral) continue;
        while (surfaces[s] != tape_surface(tape[i])) ++s;
        if ((redundant >> s) & 1) choices[i] = (ushort)(tape_negated(tape[i]) ? 2 : 1);
    }
    {
        uint peak = 0;  // in place, never more than what was read
        int expanded = 0;
        return prune(tape, length, 0, choices, 0, tape, &peak, &expanded);
    }
}

MORTISE_KERNEL void descend(__global const TreeNode* parents, __global uint* tapes,
                            __global const SurfaceBounds* surfaces, __global const ExpressionOp* ops,
                            __global const uint* spatial, __global TreeNode* children, __global int* states,
                            __global uint* unknown_counts, __global uint* in_counts, __global uint* used,
                            uint capacity, int level, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const TreeNode parent = parents[item];
        __global const uint* tape = tapes + parent.tape_offset;
        const float half_edge = 1.0f / (float)(2u << level);  // of a child, whose level is `level`
        // Centre of the parent: odd multiples of a child's edge, exact in float up to kMaxTreeLevel.
        const float edge = 2.0f * half_edge;
        const float x = (float)(2 * gather_bits(parent.morton) + 1) * edge;
        const float y = (float)(2 * gather_bits(parent.morton >> 1) + 1) * edge;
        const float z = (float)(2 * gather_bits(parent.morton >> 2) + 1) * edge;
        ushort choices[MAX_CHOICES];
        int values[8];
        uint unknown = 0;
        uint in = 0;
        for (int round = 0; round < ROUNDS; ++round) {
            lanes_int stack[kTapeStack];
            int top = -1;
            Cube cube;
            cube.x = x + half_edge * CHILD_X(round);
            cube.y = y + half_edge * CHILD_Y(round);
            cube.z = z + half_edge * CHILD_Z(round);
            cube.half_edge = half_edge;
            for (uint i = 0; i < parent.tape_length; ++i) {
                const uint word = tape[i];
                const uint operation = tape_operation(word);
                if (operation == kTapeLiteral) {
                    const lanes_int sign = classify_surface(surfaces + tape_surface(word), ops, cube);
                    const int inside = tape_negated(word) ? 0 : 1;
                    const lanes_int state =
                        select(select((lanes_int)(kUnknown), (lanes_int)(inside), sign < 0),
                               (lanes_int)(1 - inside), sign > 0);
                    stack[++top] = state;
                    if (i < MAX_CHOICES) {
#if LANES == 8
                        const int8 bits = (state + 1) << (int8)(0, 2, 4, 6, 8, 10, 12, 14);
                        const int4 half_bits = bits.lo | bits.hi;
                        const int2 quarter_bits = half_bits.lo | half_bits.hi;
                        choices[i] = (ushort)(quarter_bits.x | quarter_bits.y);
#else
                        choices[i] = (ushort)((round == 0 ? 0 : choices[i]) | ((state + 1) << (2 * round)));
#endif
                    }
                } else if (operation == kTapeSpatial) {
                    int entries[8 / ROUNDS];
                    for (int lane = 0; lane < 8 / ROUNDS; ++lane) {
                        entries[lane] =
                            spatial_state(spatial[tape_surface(word) + (uint)(round + lane)], word);
                    }
                    stack[++top] = LOAD_LANES(entries);
                } else if (operation == kTapeSelectConst) {
                    const lanes_int a = stack[top];
                    const int region = tape_region(word);
                    const int otherwise = tape_otherwise(word);
                    const lanes_int same = (lanes_int)(region == otherwise ? region : kUnknown);
                    stack[top] =
                        select(select(same, (lanes_int)(otherwise), a == 0), (lanes_int)(region), a == 1);
                } else {
                    const lanes_int b = stack[top--];
                    const lanes_int a = stack[top];
                    const lanes_int unsure = (lanes_int)(kUnknown);
                    if (operation == kTapeAnd) {
                        stack[top] = select(select(unsure, (lanes_int)(1), (a == 1) & (b == 1)),
                                            (lanes_int)(0), (a == 0) | (b == 0));
                    } else if (operation == kTapeOr) {
                        stack[top] = select(select(unsure, (lanes_int)(0), (a == 0) & (b == 0)),
                                            (lanes_int)(1), (a == 1) | (b == 1));
                    } else {
                        const lanes_int region = (lanes_int)(tape_region(word));
                        stack[top] =
                            select(select(select(unsure, region, a == region), a, b == 0), region, b == 1);
                    }
                }
            }
            STORE_LANES(stack[0], values + round);
        }
        for (int c = 0; c < 8; ++c) {
            TreeNode child;
            child.morton = (parent.morton << 3) | (ulong)c;
            child.tape_offset = parent.tape_offset;
            child.tape_length = parent.tape_length;
            if (values[c] == kUnknown) {
                uint peak = 0;
                int expanded = 0;
                const uint words = prune(tape, parent.tape_length, spatial, choices, c, 0, &peak, &expanded);
                // An unchanged tape was reduced when it was made; the root's is written anew.
                if (words != parent.tape_length || expanded || level == 1) {
                    const uint offset = atomic_add(used, peak);
                    if (offset + peak <= capacity && offset + peak >= offset) {
                        int constant_value = kUnknown;
                        prune(tape, parent.tape_length, spatial, choices, c, tapes + offset, &peak,
                              &expanded);
                        child.tape_offset = offset;
                        child.tape_length = reduce(tapes + offset, words, &constant_value);
                        if (child.tape_length == 0) values[c] = constant_value;
                    }
                }
            }
            unknown += values[c] == kUnknown;
            in += values[c] > 0;
            children[8 * item + c] = child;
            states[8 * item + c] = values[c];
        }
        unknown_counts[item] = unknown;
        in_counts[item] = in;
    }
}

// Packs the children of a level in Morton order: unknown ones into `next`, IN ones behind `in_base` of
// `in_nodes`. One work-item handles one parent; offsets come from exclusive scans of its counts.
MORTISE_KERNEL void gather_children(__global const TreeNode* children, __global const int* states,
                                    __global const uint* unknown_offsets, __global const uint* in_offsets,
                                    __global TreeNode* next, __global InNode* in_nodes, uint in_base,
                                    int level, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        uint at_unknown = unknown_offsets[item];
        uint at_in = in_base + in_offsets[item];
        for (int c = 0; c < 8; ++c) {
            const int state = states[8 * item + c];
            if (state == kUnknown) {
                next[at_unknown++] = children[8 * item + c];
            } else if (state > 0) {
                InNode node;
                node.morton = children[8 * item + c].morton;
                node.level = (uint)level;
                node.region = (uint)state;
                in_nodes[at_in++] = node;
            }
        }
    }
}
