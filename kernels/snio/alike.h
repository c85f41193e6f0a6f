// Leaves in which the surface lies alike: along a plane of the grid's directions, or along the axis of an
// extrusion, where models have most of their boundary. What one of them has found the others take.
//
// On a CPU a work-item handles LEAVES leaves in a row, and remembers PLACES of them by a hash of what the
// result depends on. On a GPU it has one.
#ifndef MORTISE_SNIO_ALIKE_H
#define MORTISE_SNIO_ALIKE_H

#include "shared/snio.h"

#if LANES == 8
#define LEAVES kLeavesInRow
#define PLACES 16
#else
#define LEAVES 1
#define PLACES 1
#endif

// What a result depends on: states of the corners and whatever else has 32 bits each, displacements of
// `corners`, roots on `cuts`.
typedef struct Look {
    uint states;
    uint others;
    uint corners;
    uint cuts;
} Look;

// Points of all leaves, by their places (kPromotedPoints).
#define POINTS_PARAMETERS                                                         \
    __global const SnioPoints *found, __global const SnioPoints *promoted_points, \
        __global const uint *point_of
#define POINTS_OF(leaf)                                                                              \
    ((point_of[leaf] & kPromotedPoints) != 0 ? promoted_points + (point_of[leaf] & ~kPromotedPoints) \
                                             : found + point_of[leaf])

// One that is remembered; known: it is one.
typedef struct Seen {
    __global const SnioPoints* points;
    Look look;
    int known;
} Seen;

static uint place_of_look(const Look look, __global const SnioPoints* points) {
    uint hash = look.states ^ (look.others * 0x9e3779b9u);
    for (uint rest = look.corners; rest != 0; rest &= rest - 1) {
        __global const int* moved = points->moved[mortise_lowest_bit(rest)];
        hash = (hash ^ (uint)moved[0] ^ ((uint)moved[1] << 11) ^ ((uint)moved[2] << 22)) * 0x85ebca6bu;
    }
    for (uint rest = look.cuts; rest != 0; rest &= rest - 1)
        hash = (hash ^ (uint)points->root[mortise_lowest_bit(rest)]) * 0xc2b2ae35u;
    return (hash ^ (hash >> 15)) % PLACES;
}

// Whether a leaf looks like one that is remembered.
static int looks_like(const Look look, __global const SnioPoints* points, const Seen* seen) {
    __global const SnioPoints* known = seen->points;
    if (!seen->known || seen->look.states != look.states || seen->look.others != look.others ||
        seen->look.corners != look.corners || seen->look.cuts != look.cuts)
        return 0;
    for (uint rest = look.corners; rest != 0; rest &= rest - 1) {
        const uint c = mortise_lowest_bit(rest);
        for (int j = 0; j < 3; ++j) {
            if (points->moved[c][j] != known->moved[c][j]) return 0;
        }
    }
    for (uint rest = look.cuts; rest != 0; rest &= rest - 1) {
        const uint e = mortise_lowest_bit(rest);
        if (points->root[e] != known->root[e]) return 0;
    }
    return 1;
}

#endif
