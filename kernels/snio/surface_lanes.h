// Values of planes, quadrics and formulas at eight points at a time: the operations of shared/surface.h in
// their order, lane by lane, and so the same bits.
#ifndef MORTISE_SNIO_SURFACE_LANES_H
#define MORTISE_SNIO_SURFACE_LANES_H

#include "shared/lanes.h"
#include "shared/surface.h"
#include "snio/expression_lanes.h"

#if LANES == 8

static int has_lanes(__global const Surface* s) {
    return s->kind == kSurfacePlane || s->kind == kSurfaceQuadric || s->kind == kSurfaceExpression;
}

typedef struct LaneSample {
    double8 value;
    double8 gradient[3];
} LaneSample;

static void frame_lanes(__global const Surface* s, const double8* at, double8* u) {
    for (int i = 0; i < 3; ++i) {
        u[i] =
            s->map[4 * i] * at[0] + s->map[4 * i + 1] * at[1] + s->map[4 * i + 2] * at[2] + s->map[4 * i + 3];
    }
}

// A formula, with its gradient in the surface's own frame.
static double8 formula_lanes(__global const Surface* s, __global const ExpressionOp* ops, const double8* at,
                             const double8* u, double8* d) {
    double8 value = expression_sample_lanes(ops + s->first_op, s->op_count, u, d);
    const long8 is_nan = value != value;
    if (any(is_nan)) {
        const double8 beside[3] = {at[0] + kBesideNan, at[1] + 0.618 * kBesideNan,
                                   at[2] + 0.414 * kBesideNan};
        double8 v[3];
        double8 e[3];
        frame_lanes(s, beside, v);
        value = select(value, expression_sample_lanes(ops + s->first_op, s->op_count, v, e), is_nan);
        for (int j = 0; j < 3; ++j) d[j] = select(d[j], e[j], is_nan);
        value = select(value, (double8)kMortiseInfinity, value != value);
    }
    return value;
}

// As surface_value and surface_sample.
static LaneSample sample_lanes(__global const Surface* s, __global const ExpressionOp* ops,
                               const double8* at) {
    LaneSample result;
    if (s->kind == kSurfacePlane) {
        result.value = s->map[0] * at[0] + s->map[1] * at[1] + s->map[2] * at[2] + s->map[3];
        for (int j = 0; j < 3; ++j) result.gradient[j] = s->map[j];
        return result;
    }
    double8 u[3];
    double8 d[3];
    frame_lanes(s, at, u);
    if (s->kind == kSurfaceQuadric) {
        result.value =
            s->form[0] * (u[0] * u[0]) + s->form[1] * (u[1] * u[1]) + s->form[2] * (u[2] * u[2]) + s->form[3];
        for (int i = 0; i < 3; ++i) d[i] = 2 * s->form[i] * u[i];
    } else {
        result.value = formula_lanes(s, ops, at, u, d);
    }
    for (int j = 0; j < 3; ++j)
        result.gradient[j] = d[0] * s->map[j] + d[1] * s->map[4 + j] + d[2] * s->map[8 + j];
    return result;
}

static double8 squared_lanes(const double8* v) {
    double8 square = 0;
    for (int j = 0; j < 3; ++j) square += v[j] * v[j];
    return square;
}

// As surface_sign: the points that are inside, and in *zero those on the surface.
static uint signs_in_lanes(__global const Surface* s, __global const ExpressionOp* ops, const double8* at,
                           double cell, uint* zero) {
    const LaneSample sample = sample_lanes(s, ops, at);
    const double8 squared = sample.gradient[0] * sample.gradient[0] +
                            sample.gradient[1] * sample.gradient[1] + sample.gradient[2] * sample.gradient[2];
    const double8 tolerance =
        select((double8)0, kSignTolerance * cell * sqrt(squared), squared < kMortiseInfinity);
    const long8 inside = sample.value < -tolerance;
    *zero = set_of_lanes(~inside & (fabs(sample.value) <= tolerance));
    return set_of_lanes(inside);
}

#endif
#endif
