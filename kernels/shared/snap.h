// Where a grid vertex is moved to when it is snapped: onto the nearest point of a surface.
#ifndef MORTISE_SHARED_SNAP_H
#define MORTISE_SHARED_SNAP_H

#include "surface.h"

// A vertex closer than this, in edges of the finest cell, may be moved (docs/design/snapping.md).
#define kVertexSnapDistance 0.335
// The same for a plane of the grid's directions, which all vertices beside it are equally far from: where
// they do not move, edges from them to the plane are long enough (kRepositionShortestEdge), so that not the
// whole plane has poor elements.
#define kGridPlaneSnapDistance 0.3501
#define kProjectionSteps 12

// A vertex stays where the part on its side of the surface is thinner than this beyond it, in edges of the
// finest cell: a rod, or a hole, that has no other vertex would be gone.
#define kVertexSnapThickness 1.5

MORTISE_FUNCTION double snap_distance(MORTISE_GLOBAL Surface* s) {
    const double x = mortise_fabs(s->map[0]);
    const double y = mortise_fabs(s->map[1]);
    const double z = mortise_fabs(s->map[2]);
    const double sum = x + y + z;
    const double largest = x > y ? (x > z ? x : z) : (y > z ? y : z);
    const int is_grid_plane = s->kind == kSurfacePlane && sum - largest <= 1e-12 * largest;
    return is_grid_plane ? kGridPlaneSnapDistance : kVertexSnapDistance;
}

// Displacement of the vertex at x to the surface's nearest point, in lattice units. Returns 0 if the vertex
// is too far away, in a thin part, or if the iteration does not settle. A pure function of position.
//
// Each step takes the point of the tangent plane at the last point that is nearest to x.
MORTISE_NOINLINE int snap_displacement(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops,
                                       const double* x, double cell, i32* displacement) {
    const double reach = snap_distance(s) * cell;
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
    if (s->kind != kSurfacePlane) {
        const double side = surface_value(s, ops, x[0], x[1], x[2]);
        const SurfaceSample sample = surface_sample(s, ops, y[0], y[1], y[2]);
        double square = 0;
        for (int j = 0; j < 3; ++j) square += sample.gradient[j] * sample.gradient[j];
        const double step = (side < 0 ? -1.0 : 1.0) * kVertexSnapThickness * cell / mortise_sqrt(square);
        double far[3];
        for (int j = 0; j < 3; ++j) far[j] = x[j] + step * sample.gradient[j];
        const double beyond = surface_value(s, ops, far[0], far[1], far[2]);
        if (!(side == 0 || (beyond < 0) == (side < 0))) return 0;
    }
    for (int j = 0; j < 3; ++j)
        displacement[j] = (i32)mortise_rint((y[j] - x[j]) / cell * (double)kCellUnits);
    return 1;
}

#endif
