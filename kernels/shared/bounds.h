// Single-precision copy of a surface for the octree descent, with the rounding error of its own coefficients.
#ifndef MORTISE_SHARED_BOUNDS_H
#define MORTISE_SHARED_BOUNDS_H

#include "platform.h"

// With u = map · (x, 1) computed in float for x in [0, 1]^3, |u_i - exact u_i| <= error[i]. error[3] bounds
// the relative error of the last operations.
typedef struct SurfaceBounds {
    float map[12];
    float form[4];
    float error[4];
    i32 kind;
    u32 first_op;
    u32 op_count;
    i32 padding;
} SurfaceBounds;

// A node of the tree whose value is not known: Morton code at its level and its pruned tape.
typedef struct TreeNode {
    u64 morton;
    u32 tape_offset;
    u32 tape_length;
} TreeNode;

// A child of a node: the place and length of its pruned tape, or its region (0: OUT) and 0.
typedef struct ChildNode {
    u32 place;
    u32 tape_length;
} ChildNode;

// A node that lies in one region: Morton code at its level.
typedef struct InNode {
    u64 morton;
    u32 level;
    u32 region;
} InNode;

#endif
