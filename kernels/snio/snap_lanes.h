// snap_displacement (shared/snap.h) for eight vertices at a time, on planes, quadrics and formulas: the same
// operations in the same order, lane by lane, and so the same bits.
#ifndef MORTISE_SNIO_SNAP_LANES_H
#define MORTISE_SNIO_SNAP_LANES_H

#include "shared/snap.h"
#include "snio/surface_lanes.h"

#if LANES == 8

// Displacements, in lattice units, of those of eight vertices in the set `wanted` that have one: the set of
// these is returned.
MORTISE_NOINLINE uint snap_points(__global const Surface* s, __global const ExpressionOp* ops,
                                  const double8* first, double cell, uint wanted, int (*units)[8]) {
    const long8 bit = (long8)(1, 2, 4, 8, 16, 32, 64, 128);
    const double reach = snap_distance(s) * cell;
    const double still = cell / 1073741824.0;
    const int is_plane = s->kind == kSurfacePlane;
    double8 at[3] = {first[0], first[1], first[2]};
    double8 offset[3];
    double8 side = 0;                // value at the corner
    double8 way = kMortiseInfinity;  // of the last step
    long8 settles = ((long8)wanted & bit) != 0;
    long8 goes_on = settles;
    for (int step = 0; step < kProjectionSteps && any(goes_on); ++step) {
        const LaneSample sample = sample_lanes(s, ops, at);
        const double8 square = squared_lanes(sample.gradient);
        double8 value = sample.value;
        double8 length = 0;
        if (step == 0) side = value;
        for (int j = 0; j < 3; ++j) value += sample.gradient[j] * (first[j] - at[j]);
        settles &= ~goes_on | ((square > 0) & (square < kMortiseInfinity) &
                               (value * value < 4 * reach * reach * square));
        goes_on &= settles;
        for (int j = 0; j < 3; ++j) {
            const double8 next = first[j] - value / square * sample.gradient[j];
            length += (next - at[j]) * (next - at[j]);
            at[j] = select(at[j], next, goes_on);
        }
        if (is_plane) length = 0;
        way = select(way, length, goes_on);
        goes_on &= way > still * still;
    }
    for (int j = 0; j < 3; ++j) offset[j] = at[j] - first[j];
    settles &= (way <= still * still) & (squared_lanes(offset) < reach * reach);
    if (!is_plane && any(settles)) {
        const LaneSample sample = sample_lanes(s, ops, at);
        const double8 sign = select((double8)1.0, (double8)-1.0, side < 0);
        const double8 step = sign * kVertexSnapThickness * cell / sqrt(squared_lanes(sample.gradient));
        double8 far[3];
        for (int j = 0; j < 3; ++j) far[j] = first[j] + step * sample.gradient[j];
        settles &= (side == 0) | ((sample_lanes(s, ops, far).value < 0) == (side < 0));
    }
    for (int j = 0; j < 3; ++j)
        vstore8(convert_int8(rint(offset[j] / cell * (double)kCellUnits)), 0, units[j]);
    return set_of_lanes(settles);
}

#endif
#endif
