// Points that leaves in a row have in common, on planes, quadrics and formulas. Leaves in Morton order lie
// side by side: a corner is one of four leaves of the row, mostly, and is moved once for all of them, eight
// corners at a time; an edge's root is found once.
#ifndef MORTISE_SNIO_ROW_POINTS_H
#define MORTISE_SNIO_ROW_POINTS_H

#include "shared/snio.h"
#include "snio/snap_lanes.h"

#if LANES == 8
#define LEAVES kLeavesInRow
#else
#define LEAVES 1
#endif

#if LANES == 8

#define ROW_POINTS (12 * LEAVES)  // the most that a row has: its edges
#define ROW_PLACES 2048           // a power of two, more than twice that
#define COORDINATE_BITS 21
#define NO_POINT 0xffffu

// Corners, or edges by their low ends, of a row's leaves, each once, by hashing with open addressing.
typedef struct RowKeys {
    ulong vertex[ROW_POINTS];  // coordinates in finest cells, COORDINATE_BITS each
    uint kind[ROW_POINTS];     // point_kind; of edges also the axis, in the lowest two bits
    uint count;
    ushort table[ROW_PLACES];  // indices, or NO_POINT
} RowKeys;

static void clear_keys(RowKeys* keys) {
    keys->count = 0;
    for (uint i = 0; i < ROW_PLACES; ++i) keys->table[i] = NO_POINT;
}

// Index of a point, which is entered if it is new.
static uint index_of_point(RowKeys* keys, ulong vertex, uint kind, uint* is_new) {
    // Fibonacci hashing; 11 bits are ROW_PLACES.
    uint place = (uint)(((vertex ^ ((ulong)kind << 40)) * 0x9e3779b97f4a7c15UL) >> 53);
    *is_new = 0;
    while (keys->table[place] != NO_POINT) {
        const uint index = keys->table[place];
        if (keys->vertex[index] == vertex && keys->kind[index] == kind) return index;
        place = (place + 1) % ROW_PLACES;
    }
    *is_new = 1;
    keys->table[place] = (ushort)keys->count;
    keys->vertex[keys->count] = vertex;
    keys->kind[keys->count] = kind;
    return keys->count++;
}

// A leaf's low corner, from its Morton code; and its corner c, from that one and the leaf's edge in finest
// cells.
static ulong first_vertex(ulong code) {
    return (ulong)gather_bits(code) | ((ulong)gather_bits(code >> 1) << COORDINATE_BITS) |
           ((ulong)gather_bits(code >> 2) << (2 * COORDINATE_BITS));
}
static ulong vertex_at(ulong first, uint edge, uint c) {
    return first + ((ulong)((c & 1) * edge) | ((ulong)(((c >> 1) & 1) * edge) << COORDINATE_BITS) |
                    ((ulong)((c >> 2) * edge) << (2 * COORDINATE_BITS)));
}
// Its place in the root cube; finest: the edge of a finest cell.
static void place_of_vertex(ulong vertex, double finest, double* at) {
    for (int j = 0; j < 3; ++j)
        at[j] = (double)((vertex >> (j * COORDINATE_BITS)) & ((1UL << COORDINATE_BITS) - 1)) * finest;
}

// The corners of a row's leaves, and where they move.
typedef struct RowCorners {
    RowKeys keys;
    ushort index[LEAVES][8];
    int moved[ROW_POINTS][3];
    uchar moves[ROW_POINTS];
} RowCorners;

// What tells points apart beside their vertices: where a corner moves depends on the size of its cells, too.
static uint point_kind(uint surface, int level) { return (surface << 5) | (uint)level; }

// Lists the corners of a leaf that are not in `zero`.
static void add_corners(RowCorners* corners, uint leaf_of_row, ulong code, uint edge, uint kind, uint zero) {
    const ulong first = first_vertex(code);
    for (uint c = 0; c < 8; ++c) {
        uint is_new;
        corners->index[leaf_of_row][c] =
            (zero >> c) & 1
                ? NO_POINT
                : (ushort)index_of_point(&corners->keys, vertex_at(first, edge, c), kind, &is_new);
    }
}

// Moves all listed corners.
MORTISE_NOINLINE void move_corners(RowCorners* corners, __global const Surface* surfaces,
                                   __global const ExpressionOp* ops, double finest) {
    uint count;
    for (uint first = 0; first < corners->keys.count; first += count) {
        const uint kind = corners->keys.kind[first];
        double at[3][8];
        int units[3][8];
        uint found;
        count = 1;
        while (count < 8 && first + count < corners->keys.count && corners->keys.kind[first + count] == kind)
            ++count;
        for (uint i = 0; i < 8; ++i) {
            double x[3];
            place_of_vertex(corners->keys.vertex[first + (i < count ? i : 0)], finest, x);
            for (int j = 0; j < 3; ++j) at[j][i] = x[j];
        }
        {
            const double8 lanes[3] = {vload8(0, at[0]), vload8(0, at[1]), vload8(0, at[2])};
            const double cell = 1.0 / (double)(1u << (kind & 31));
            found = snap_points(surfaces + (kind >> 5), ops, lanes, cell, (1u << count) - 1, units);
        }
        for (uint i = 0; i < count; ++i) {
            corners->moves[first + i] = (uchar)((found >> i) & 1);
            for (int j = 0; j < 3; ++j) corners->moved[first + i][j] = units[j][i];
        }
    }
}

// What a leaf takes of them: the set of its corners that move.
static uint take_corners(const RowCorners* corners, uint leaf_of_row, __global int (*moved)[3]) {
    uint found = 0;
    for (uint c = 0; c < 8; ++c) {
        const uint index = corners->index[leaf_of_row][c];
        if (index == NO_POINT || !corners->moves[index]) continue;
        found |= 1u << c;
        for (int j = 0; j < 3; ++j) moved[c][j] = corners->moved[index][j];
    }
    return found;
}

// The roots that the row has found.
typedef struct RowRoots {
    RowKeys keys;
    int root[ROW_POINTS];
} RowRoots;

#endif
#endif
