// Where a grid vertex is moved to when it is snapped: onto the nearest point of a surface.
#ifndef MORTISE_SHARED_SNAP_H
#define MORTISE_SHARED_SNAP_H

#include "surface.h"

// A vertex closer than this, in edges of the finest cell, may be moved (quality.md, snapping rule).
#define kVertexSnapDistance 0.31
#define kProjectionSteps 12

// Displacement of the vertex at x to the surface's nearest point, in lattice units. Returns 0 if the vertex
// is too far away, or if the iteration does not settle. A pure function of position.
//
// Each step takes the point of the tangent plane at the last point that is nearest to x.
MORTISE_FUNCTION int snap_displacement(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops,
                                       const double* x, double cell, i32* displacement) {
    const double reach = kVertexSnapDistance * cell;
    const double still = cell / 1073741824.0;  // 2^-30 of a cell
    double y[3];
    double moved = kMortiseInfinity;
    for (int j = 0; j < 3; ++j) y[j] = x[j];
    for (int step = 0; step < kProjectionSteps && moved > still * still; ++step) {
        const SurfaceSample sample = surface_sample(s, ops, y[0], y[1], y[2]);
        double square = 0;
        double value = sample.value;
        for (int j = 0; j < 3; ++j) {
            square += sample.gradient[j] * sample.gradient[j];
            value += sample.gradient[j] * (x[j] - y[j]);
        }
        if (!(square > 0 && square < kMortiseInfinity)) return 0;
        // Hopeless: curvature does not bring the surface that much closer.
        if (!(value * value < 4 * reach * reach * square)) return 0;
        moved = 0;
        for (int j = 0; j < 3; ++j) {
            const double next = x[j] - value / square * sample.gradient[j];
            moved += (next - y[j]) * (next - y[j]);
            y[j] = next;
        }
        if (s->kind == kSurfacePlane) moved = 0;
    }
    if (!(moved <= still * still)) return 0;
    {
        double square = 0;
        for (int j = 0; j < 3; ++j) square += (y[j] - x[j]) * (y[j] - x[j]);
        if (!(square < reach * reach)) return 0;
    }
    for (int j = 0; j < 3; ++j)
        displacement[j] = (i32)mortise_rint((y[j] - x[j]) / cell * (double)kCellUnits);
    return 1;
}

#endif
