// Finds the NIO leaves that one surface cuts simply (Saxena & Perucchio 1992, §4: SNIO cells). All others go
// to the certificate.
//
// A leaf is a candidate only if one side of its surface is a region and the other is outside, and if each
// face is whole or cut by one chord, for the certificate as for templates (F0 and F1 of
// docs/design/certificate.md): no face or cell centre contradicts corners that agree. A face close to a
// surface nearly parallel to it may be neither, a bulge, or a saddle with two opposite corners inside; it is
// simple once all four corners are on the surface, so they are needed there.
#include "shared/bounds.h"
#include "shared/snio.h"
#include "shared/surface.h"
#include "shared/tape.h"
#include "shared/template_table.h"
#include "shared/tree.h"
#include "snio/surface_lanes.h"

// A face with the surface on both sides counts as on the surface, once its corners are, if the surface is
// closer to its middle than this, in edges of the cell: 0.083 where the radius is 3 cells.
#define kLargestBulge 0.1

// Value of a tape whose literals are all of one surface, with that surface's sign given.
MORTISE_NOINLINE int evaluate_tape(__global const uint* tape, uint length, uint inside) {
    int value[kTapeStack];
    int top = -1;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        const uint operation = tape_operation(word);
        if (operation == kTapeLiteral) {
            value[++top] = (int)(inside ^ tape_negated(word));
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

// Whether the certificate meshes face f whole (corners agree) or cut by one chord, with corners in `zero` on
// the surface.
MORTISE_NOINLINE int face_is_simple(uint inside, uint zero, int f) {
    int zeros = 0;
    int changes = 0;
    int signs[8];
    int count = 0;
    for (int i = 0; i < 4; ++i) {
        const int c = kFaceCorners[f][i];
        const int next = kFaceCorners[f][(i + 1) & 3];
        const int here_sign = ((zero >> c) & 1) ? 0 : ((inside >> c) & 1) ? -1 : 1;
        const int next_sign = ((zero >> next) & 1) ? 0 : ((inside >> next) & 1) ? -1 : 1;
        signs[count++] = here_sign;
        if (here_sign * next_sign < 0) signs[count++] = 0;
    }
    for (int i = 0; i < count; ++i) {
        if (signs[i] != 0) continue;
        ++zeros;
        if (signs[(i + 1) % count] * signs[(i + count - 1) % count] < 0) ++changes;
    }
    return zeros == 2 && changes == 2;
}

// Whether the surface is within kLargestBulge of a point, to first order.
MORTISE_NOINLINE int is_close(__global const Surface* surface, __global const ExpressionOp* ops,
                              const double* at, double cell) {
    const SurfaceSample sample = surface_sample(surface, ops, at[0], at[1], at[2]);
    double square = 0;
    for (int j = 0; j < 3; ++j) square += sample.gradient[j] * sample.gradient[j];
    return sample.value * sample.value < kLargestBulge * kLargestBulge * cell * cell * square;
}

// Signs of a leaf's surface at the leaf's corners (0 to 7), in the middles of its faces (8 to 13) and its own
// (14), all at once where there are lanes for the surface, else as they are asked for.
#define MIDDLE_OF_FACE 8
#define MIDDLE 14
typedef struct CellSigns {
    __global const Surface* surface;
    __global const ExpressionOp* ops;
    double at[3];  // the leaf's first corner
    double cell;
    uint known;  // sets of places
    uint inside;
    uint zero;
} CellSigns;

static void place_in_cell(const CellSigns* signs, int place, double* at) {
    const int axis = (place - MIDDLE_OF_FACE) >> 1;
    for (int j = 0; j < 3; ++j) {
        double offset = 0.5;
        if (place < MIDDLE_OF_FACE)
            offset = (place >> j) & 1;
        else if (axis == j)
            offset = place & 1;
        at[j] = signs->at[j] + offset * signs->cell;
    }
}

// The mean of corners `from` that a face or the cell has, where snapped ones have moved; false if none has.
static int moved_middle(const CellSigns* signs, __global const SnappedLeaf* snapped, uint from, double* at) {
    int sum[3] = {0, 0, 0};
    const int count = popcount(from);
    if (snapped == 0 || (snapped->snapped & from) == 0) return 0;
    for (uint rest = from; rest != 0; rest &= rest - 1) {
        const uint c = mortise_lowest_bit(rest);
        const int moves = (snapped->snapped >> c) & 1;
        for (int j = 0; j < 3; ++j)
            sum[j] += (int)((c >> j) & 1) * kCellUnits + (moves ? snapped->moved[c][j] : 0);
    }
    for (int j = 0; j < 3; ++j) at[j] = signs->at[j] + sum[j] / count * (signs->cell / kCellUnits);
    return 1;
}

static void start_signs(CellSigns* signs) {
    signs->known = 0;
    signs->inside = 0;
    signs->zero = 0;
#if LANES == 8
    if (has_lanes(signs->surface)) {
        const double cell = signs->cell;
        const double8 x = signs->at[0];
        const double8 y = signs->at[1];
        const double8 z = signs->at[2];
        const double8 corners[3] = {x + (double8)(0, 1, 0, 1, 0, 1, 0, 1) * cell,
                                    y + (double8)(0, 0, 1, 1, 0, 0, 1, 1) * cell,
                                    z + (double8)(0, 0, 0, 0, 1, 1, 1, 1) * cell};
        const double8 middles[3] = {x + (double8)(0, 1, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5) * cell,
                                    y + (double8)(0.5, 0.5, 0, 1, 0.5, 0.5, 0.5, 0.5) * cell,
                                    z + (double8)(0.5, 0.5, 0.5, 0.5, 0, 1, 0.5, 0.5) * cell};
        uint zero_middles;
        signs->known = 0xffff;
        signs->inside = signs_in_lanes(signs->surface, signs->ops, corners, cell, &signs->zero);
        signs->inside |= signs_in_lanes(signs->surface, signs->ops, middles, cell, &zero_middles)
                         << MIDDLE_OF_FACE;
        signs->zero |= zero_middles << MIDDLE_OF_FACE;
    }
#endif
}

// As surface_sign.
static int sign_at(CellSigns* signs, int place) {
    const uint bit = 1u << place;
    if ((signs->known & bit) == 0) {
        double at[3];
        int sign;
        place_in_cell(signs, place, at);
        sign = surface_sign(signs->surface, signs->ops, at[0], at[1], at[2], signs->cell);
        signs->known |= bit;
        if (sign < 0) signs->inside |= bit;
        if (sign == 0) signs->zero |= bit;
    }
    return (signs->zero & bit) != 0 ? 0 : (signs->inside & bit) != 0 ? -1 : 1;
}

// Sign of the surface in the middle of a face or of the cell, where corners have moved to.
static int sign_in_middle(CellSigns* signs, __global const SnappedLeaf* snapped, int place, uint corners) {
    double at[3];
    if (!moved_middle(signs, snapped, corners, at)) return sign_at(signs, place);
    return surface_sign(signs->surface, signs->ops, at[0], at[1], at[2], signs->cell);
}

// What is known of a leaf; `snapped`: its corners that are, or null. If `snap` is not set corners of sign 0
// make a leaf complex.
MORTISE_NOINLINE SnioCandidate candidate_of(const Tree* tree, const TreeNode node, __global const uint* tapes,
                                            __global const Surface* surfaces,
                                            __global const ExpressionOp* ops,
                                            __global const SnappedLeaf* snapped, int snap) {
    __global const uint* tape = tapes + node.tape_offset;
    const double finest = 1.0 / (double)(1u << tree->shape.level);
    const double cell = 1.0 / (double)(1u << leaf_level(tree, node.morton));
    CellSigns signs;
    SnioCandidate candidate;
    int simple = node.tape_length > 0;  // transition leaves of graded trees have no tape
    int value_inside = 0;
    int value_outside = 0;
    uint inside = 0;
    uint zero = 0;
    uint needed = 0;
    candidate.surface = simple ? tape_surface(tape[0]) : 0;
    for (uint i = 0; i < node.tape_length && simple; ++i) {
        simple = tape_operation(tape[i]) != kTapeLiteral || tape_surface(tape[i]) == candidate.surface;
    }
    if (simple) {
        value_inside = evaluate_tape(tape, node.tape_length, 1);
        value_outside = evaluate_tape(tape, node.tape_length, 0);
        simple = (value_inside == 0) != (value_outside == 0);
    }
    if (simple) {
        signs.surface = surfaces + candidate.surface;
        signs.ops = ops;
        for (int j = 0; j < 3; ++j) signs.at[j] = (double)gather_bits(node.morton >> j) * finest;
        signs.cell = cell;
        start_signs(&signs);
        for (int c = 0; c < 8 && simple; ++c) {
            const int sign = snapped != 0 && ((snapped->zero >> c) & 1) ? 0 : sign_at(&signs, c);
            if (sign == 0) {
                zero |= 1u << c;
                simple = snap;
            } else if ((sign < 0 ? value_inside : value_outside) != 0) {
                inside |= 1u << c;
            }
        }
        simple = simple && zero != 0xff;
    }
    for (int f = 0; f < 6 && simple; ++f) {
        uint in_face = 0;
        uint in_all = 0;
        uint corners;
        int fits;
        for (int i = 0; i < 4; ++i) {
            in_face |= inside & (1u << kFaceCorners[f][i]);
            in_all |= 1u << kFaceCorners[f][i];
        }
        corners = in_all & ~zero;
        if (in_face == 0 || in_face == corners) {
            const int sign = sign_in_middle(&signs, snapped, MIDDLE_OF_FACE + f, in_all);
            fits = sign == 0 || corners == 0 ||
                   ((sign < 0 ? value_inside : value_outside) != 0) == (in_face != 0);
        } else {
            fits = face_is_simple(inside, zero, f);
        }
        if (fits) continue;
        {
            double middle[3];
            if (!moved_middle(&signs, snapped, in_all, middle))
                place_in_cell(&signs, MIDDLE_OF_FACE + f, middle);
            simple = snap && is_close(signs.surface, ops, middle, cell);
        }
        needed |= corners;
    }
    if (simple && (zero | needed) == 0) {
        simple = inside == 0 || inside == 0xff || kTemplateRows[inside].shape != 0;
    }
    if (simple && (inside == 0 || (inside | zero) == 0xff)) {
        const int sign = sign_in_middle(&signs, snapped, MIDDLE, 0xff);
        simple = sign == 0 || ((sign < 0 ? value_inside : value_outside) != 0) == (inside != 0);
    }
    candidate.region = (ushort)(value_inside != 0 ? value_inside : value_outside);
    candidate.inside = (uchar)inside;
    candidate.zero = (uchar)zero;
    candidate.near = 0;
    candidate.flags = simple ? kCandidateSimple : 0;
    candidate.needed = (uchar)needed;
    candidate.snapped = 0;
    return candidate;
}

// Reads   the tree, nio (leaves), tapes, surfaces, ops.
// Writes  candidates[i], without `near`.
// One work-item handles one leaf.
MORTISE_KERNEL void classify(TREE_PARAMETERS, __global const TreeNode* nio, __global const uint* tapes,
                             __global const Surface* surfaces, __global const ExpressionOp* ops,
                             __global SnioCandidate* candidates, int snap, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    candidates[item] = candidate_of(&tree, nio[item], tapes, surfaces, ops, 0, snap);
}

// The same again for simple leaves that have corners snapped beside complex ones.
//
// Reads   as `classify`, and snapped; writes their candidates, in the order of `snapped`.
// One work-item handles one leaf of `snapped`.
MORTISE_KERNEL void classify_snapped(TREE_PARAMETERS, __global const TreeNode* nio,
                                     __global const uint* tapes, __global const Surface* surfaces,
                                     __global const ExpressionOp* ops, __global const SnappedLeaf* snapped,
                                     __global SnioCandidate* candidates, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    candidates[item] = candidate_of(&tree, nio[snapped[item].leaf], tapes, surfaces, ops, snapped + item, 1);
}

// Leaves that hold more than their samples tell are not simple, whatever `classify` says.
// One work-item handles one leaf of the list.
MORTISE_KERNEL void leave_to_certificate(__global const uint* leaves, __global SnioCandidate* candidates,
                                         uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    candidates[leaves[item]].flags = 0;
}
