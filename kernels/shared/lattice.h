// The lattice: integer coordinates of cells, their corners and all points inside them.
//
// The root box is [0, 1]^3 in box-local coordinates. A cell of level L has integer coordinates
// (x, y, z) in [0, 2^L). Every node of the mesh lies on a lattice of kCellUnits steps per edge of the finest
// cell, so positions are exact in double precision (18 + 26 bits) and orientation tests on them are exact in
// 128-bit integers.
//
// Corners, edges and faces of a cell are numbered as follows everywhere in Mortise:
//   corner c = x + 2y + 4z;
//   edge   e = 4·axis + k, with k = (first other axis) + 2·(second other axis), axes in increasing order;
//   face   f = 2·axis + side.
#ifndef MORTISE_SHARED_LATTICE_H
#define MORTISE_SHARED_LATTICE_H

#include "platform.h"

#define kMaxTreeLevel 18
#define kCellUnitBits 26
#define kCellUnits (1 << kCellUnitBits)

// The two other axes, in increasing order.
MORTISE_FUNCTION int first_other(int axis) { return axis == 0 ? 1 : 0; }
MORTISE_FUNCTION int second_other(int axis) { return axis == 2 ? 1 : 2; }

// Low and high corner of each edge.
MORTISE_TABLE u8 kEdgeCorners[12][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3},
                                        {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

// Corners of each face in the face's own frame, (u, v) = the two other axes in increasing order, in the
// order (0,0) (1,0) (1,1) (0,1): the same for both cells that share the face.
MORTISE_TABLE u8 kFaceCorners[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                       {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};

// Edge between kFaceCorners[f][i] and kFaceCorners[f][(i + 1) % 4].
MORTISE_TABLE u8 kFaceEdges[6][4] = {{4, 10, 6, 8},  {5, 11, 7, 9}, {0, 9, 2, 8},
                                     {1, 11, 3, 10}, {0, 5, 1, 4},  {2, 7, 3, 6}};

// Whether the frame of face f is counter-clockwise seen from outside its cell: it is left-handed for three of
// the six.
MORTISE_FUNCTION int frame_points_outward(int f) { return (f / 2 != 1) == ((f & 1) != 0); }

// A box-local coordinate, which is exact, in model coordinates: the one way to round it.
MORTISE_FUNCTION double model_coordinate(double origin, double side, double in_box) {
    return origin + side * in_box;
}

// Spreads the low 21 bits of x to every third bit.
MORTISE_FUNCTION u64 spread_bits(u64 x) {
    x &= 0x1fffffUL;
    x = (x | (x << 32)) & 0x1f00000000ffffUL;
    x = (x | (x << 16)) & 0x1f0000ff0000ffUL;
    x = (x | (x << 8)) & 0x100f00f00f00f00fUL;
    x = (x | (x << 4)) & 0x10c30c30c30c30c3UL;
    x = (x | (x << 2)) & 0x1249249249249249UL;
    return x;
}

// Inverse of spread_bits.
MORTISE_FUNCTION u32 gather_bits(u64 x) {
    x &= 0x1249249249249249UL;
    x = (x | (x >> 2)) & 0x10c30c30c30c30c3UL;
    x = (x | (x >> 4)) & 0x100f00f00f00f00fUL;
    x = (x | (x >> 8)) & 0x1f0000ff0000ffUL;
    x = (x | (x >> 16)) & 0x1f00000000ffffUL;
    x = (x | (x >> 32)) & 0x1fffffUL;
    return (u32)x;
}

// Morton code of integer coordinates: x in bit 0, y in bit 1, z in bit 2 of each triple.
MORTISE_FUNCTION u64 morton_encode(u32 x, u32 y, u32 z) {
    return spread_bits(x) | (spread_bits(y) << 1) | (spread_bits(z) << 2);
}

#endif
