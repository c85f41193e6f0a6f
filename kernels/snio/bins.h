// Leaves binned by topology. A work-item handles a chunk of leaves in a row: kLeavesInChunk on a CPU, else
// one. Those whose corners have the same states wait in a bin until it holds one for each lane
// (shared/lanes.h).
//
// Leaves that look alike are asked about once: along a plane of the grid's directions, or along the axis of
// an extrusion, where models have most of their boundary, the surface lies alike in leaf after leaf. What the
// first of a chunk finds the others take.
#ifndef MORTISE_SNIO_BINS_H
#define MORTISE_SNIO_BINS_H

#include "shared/lanes.h"
#include "shared/snio.h"

#if kLanes == 1
#define CHUNK 1
#else
#define CHUNK kLeavesInChunk
#endif
#define CHUNK_PLACES (2 * CHUNK)  // a power of two
#define NO_PLACE 0xffffu

// Points of all leaves, by their places (kPromotedPoints).
#define POINTS_PARAMETERS                                                         \
    __global const SnioPoints *found, __global const SnioPoints *promoted_points, \
        __global const uint *point_of
#define POINTS found, promoted_points, point_of
#define POINTS_OF(leaf)                                                                              \
    ((point_of[leaf] & kPromotedPoints) != 0 ? promoted_points + (point_of[leaf] & ~kPromotedPoints) \
                                             : found + point_of[leaf])

// What a result depends on: states of the corners and whatever else has 32 bits each, displacements of
// `corners`, roots on `cuts`.
typedef struct Look {
    uint states;
    uint others;
    uint corners;
    uint cuts;
} Look;

// Leaves of a chunk with the same states and others, which wait.
typedef struct Bin {
    uint states;
    uint others;
    uint count;
    ushort leaf[kLanes];
} Bin;

typedef struct Chunk {
    uint first;  // leaf
    uint bin_count;
    Bin bins[CHUNK];
    Look looks[CHUNK];                 // of leaves that are like no one before them
    ushort like[CHUNK];                // such a leaf, itself or another; NO_PLACE: not entered
    ushort by_look[CHUNK_PLACES];      // such leaves, by hashing with open addressing; or NO_PLACE
    ushort by_topology[CHUNK_PLACES];  // bins
} Chunk;

static void clear_chunk(Chunk* chunk, uint first) {
    chunk->first = first;
    chunk->bin_count = 0;
    for (uint i = 0; i < CHUNK; ++i) chunk->like[i] = NO_PLACE;
    for (uint i = 0; i < CHUNK_PLACES; ++i) chunk->by_look[i] = chunk->by_topology[i] = NO_PLACE;
}

static uint hash_of_look(const Look look, __global const SnioPoints* points) {
    uint hash = look.states ^ (look.others * 0x9e3779b9u);
    for (uint rest = look.corners; rest != 0; rest &= rest - 1) {
        __global const int* moved = points->moved[mortise_lowest_bit(rest)];
        hash = (hash ^ (uint)moved[0] ^ ((uint)moved[1] << 11) ^ ((uint)moved[2] << 22)) * 0x85ebca6bu;
    }
    for (uint rest = look.cuts; rest != 0; rest &= rest - 1)
        hash = (hash ^ (uint)points->root[mortise_lowest_bit(rest)]) * 0xc2b2ae35u;
    return hash ^ (hash >> 15);
}

static int are_alike(const Look look, __global const SnioPoints* points, const Look other,
                     __global const SnioPoints* other_points) {
    if (other.states != look.states || other.others != look.others || other.corners != look.corners ||
        other.cuts != look.cuts)
        return 0;
    for (uint rest = look.corners; rest != 0; rest &= rest - 1) {
        const uint c = mortise_lowest_bit(rest);
        for (int j = 0; j < 3; ++j) {
            if (points->moved[c][j] != other_points->moved[c][j]) return 0;
        }
    }
    for (uint rest = look.cuts; rest != 0; rest &= rest - 1) {
        const uint e = mortise_lowest_bit(rest);
        if (points->root[e] != other_points->root[e]) return 0;
    }
    return 1;
}

static Bin* bin_of_look(Chunk* chunk, const Look look) {
    uint place = (((look.states ^ (look.others * 0x9e3779b9u)) * 0x85ebca6bu) >> 16) % CHUNK_PLACES;
    for (; chunk->by_topology[place] != NO_PLACE; place = (place + 1) % CHUNK_PLACES) {
        Bin* bin = chunk->bins + chunk->by_topology[place];
        if (bin->states == look.states && bin->others == look.others) return bin;
    }
    chunk->by_topology[place] = (ushort)chunk->bin_count;
    Bin* bin = chunk->bins + chunk->bin_count++;
    bin->states = look.states;
    bin->others = look.others;
    bin->count = 0;
    return bin;
}

// Enters a leaf of the chunk. The bin that it fills is returned, or 0; the caller asks about its leaves and
// empties it.
static Bin* enter_leaf(Chunk* chunk, uint leaf, const Look look, POINTS_PARAMETERS) {
    const uint at = leaf - chunk->first;
    __global const SnioPoints* points = POINTS_OF(leaf);
    uint place = hash_of_look(look, points) % CHUNK_PLACES;
    for (; chunk->by_look[place] != NO_PLACE; place = (place + 1) % CHUNK_PLACES) {
        const uint other = chunk->by_look[place];
        if (!are_alike(look, points, chunk->looks[other], POINTS_OF(chunk->first + other))) continue;
        chunk->like[at] = (ushort)other;
        return 0;
    }
    chunk->by_look[place] = chunk->like[at] = (ushort)at;
    chunk->looks[at] = look;
    Bin* bin = bin_of_look(chunk, look);
    bin->leaf[bin->count++] = (ushort)at;
    return bin->count == kLanes ? bin : 0;
}

// The leaf in a lane of a bin; lanes behind the last one repeat the first.
static uint leaf_of_lane(const Chunk* chunk, const Bin* bin, uint lane) {
    return chunk->first + bin->leaf[lane < bin->count ? lane : 0];
}

#endif
