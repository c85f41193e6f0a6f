// Which side of a surface the cubes of several lanes lie on, by interval arithmetic in single precision.
//
// LANES cubes at once: 8, one vector, or 1. Guarantees: a sign that is not 0 holds on the closed cube,
// whatever the rounding.
#ifndef MORTISE_OCTREE_CLASSIFY_SURFACE_H
#define MORTISE_OCTREE_CLASSIFY_SURFACE_H

#include "shared/bounds.h"
#include "shared/expression_bounds.h"
#include "shared/rounded.h"
#include "shared/surface.h"

#if LANES == 8
typedef float8 lanes_float;
typedef int8 lanes_int;
#define ROUNDS 1
#define CHILD_X(round) (lanes_float)(-1, 1, -1, 1, -1, 1, -1, 1)
#define CHILD_Y(round) (lanes_float)(-1, -1, 1, 1, -1, -1, 1, 1)
#define CHILD_Z(round) (lanes_float)(-1, -1, -1, -1, 1, 1, 1, 1)
#define STORE_LANES(values, array) vstore8(values, 0, array)
#define LOAD_LANES(array) vload8(0, array)
#elif LANES == 1
typedef float lanes_float;
typedef int lanes_int;
#define ROUNDS 8
#define CHILD_X(round) (((round)&1) ? 1.0f : -1.0f)
#define CHILD_Y(round) (((round)&2) ? 1.0f : -1.0f)
#define CHILD_Z(round) (((round)&4) ? 1.0f : -1.0f)
#define STORE_LANES(values, array) (array)[0] = (values)
#define LOAD_LANES(array) ((array)[0])
#else
#error "LANES must be 1 or 8"
#endif

#define RELATIVE 9.5367431640625e-7f  // 2^-20: more than the rounding of any sum below

typedef struct Cube {
    lanes_float x;
    lanes_float y;
    lanes_float z;
    float half_edge;
} Cube;

// -1: f < 0 on the closed cube, +1: f > 0, 0: undecided.
static lanes_int decide(lanes_float low, lanes_float high) {
    return select(select((lanes_int)(0), (lanes_int)(-1), high < 0.0f), (lanes_int)(1), low > 0.0f);
}

static lanes_float interval_square_low(lanes_float low, lanes_float high) {
    const lanes_float least = fmin(fabs(low), fabs(high));
    const lanes_float inside = fmin(high, -low);  // positive where the interval holds zero
    return select(least * least, (lanes_float)(0.0f), inside >= 0.0f);
}

static lanes_float interval_square_high(lanes_float low, lanes_float high) {
    const lanes_float most = fmax(fabs(low), fabs(high));
    return most * most;
}

#define ROUNDED_SUPPORT rounded_support_lanes
#define ROUNDED_NUMBER lanes_float
#define ROUNDED_SCALAR float
#define ROUNDED_PICK(condition, yes, no) select(no, yes, condition)
#define ROUNDED_SQRT(x) sqrt(x)
#include "shared/rounded_support.def"
#undef ROUNDED_SUPPORT
#undef ROUNDED_NUMBER
#undef ROUNDED_SCALAR
#undef ROUNDED_PICK
#undef ROUNDED_SQRT

// f is convex: its tangent plane at the centre bounds it from below. From above, its gradient does, which
// turns slowly where the solid is round, or nowhere exceeds 1.
static lanes_int classify_rounded(__global const SurfaceBounds* s, __global const ExpressionOp* ops,
                                  Cube cube, const lanes_float* u, const float* width) {
    __global const rounded_number* data = (__global const rounded_number*)(ops + s->first_op);
    const lanes_float rounding = 4.0f * RELATIVE * (fabs(u[0]) + fabs(u[1]) + fabs(u[2]) + s->form[3]);
    const lanes_float slack = s->error[0] + s->error[1] + s->error[2] + 2.0f * rounding;
    lanes_float value;
    lanes_float g[3];
    lanes_float reach;  // change of the linear part in the cube
    lanes_float round;  // distance of its corners from the centre
    if (s->form[2] >= (float)kRoundedRevolution) {
        const float side0 = width[0];
        const float side1 = width[1];
        const lanes_float low = sqrt(interval_square_low(u[0] - side0, u[0] + side0) +
                                     interval_square_low(u[1] - side1, u[1] + side1)) *
                                (1.0f - RELATIVE);
        const lanes_float high = sqrt(interval_square_high(u[0] - side0, u[0] + side0) +
                                      interval_square_high(u[1] - side1, u[1] + side1)) *
                                 (1.0f + RELATIVE);
        const lanes_float half_range = 0.5f * (high - low) * (1.0f + RELATIVE);
        lanes_float profile[3];
        profile[0] = 0.5f * (low + high);
        profile[1] = u[2];
        profile[2] = (lanes_float)(0.0f);
        rounded_support_lanes(data, profile, rounding, &value, g);
        reach = fabs(g[0]) * half_range + fabs(g[1]) * width[2];
        round = sqrt(half_range * half_range + width[2] * width[2]);
    } else {
        lanes_float along[3];
        rounded_support_lanes(data, u, rounding, &value, g);
        for (int j = 0; j < 3; ++j) {
            along[j] = fabs(g[0] * s->map[j] + g[1] * s->map[4 + j] + g[2] * s->map[8 + j]);
        }
        reach = cube.half_edge * (along[0] + along[1] + along[2]);
        round = (lanes_float)(sqrt(width[0] * width[0] + width[1] * width[1] + width[2] * width[2]));
    }
    reach *= 1.0f + 4.0f * RELATIVE;
    round *= 1.0f + 4.0f * RELATIVE;
    const lanes_float room = s->form[0] * (1.0f - RELATIVE) + value - round - slack;
    const lanes_float bend = select((lanes_float)(HUGE_VALF), 0.5f * round * round / room, room > 0.0f);
    const lanes_float above = fmin(round, reach + bend * (1.0f + 4.0f * RELATIVE));
    return decide(value - reach - slack, value + above + slack);
}

// The sum of form[i] u[i]² and form[3], in its exact Taylor form about the centre, linear part and squares
// bounded apart.
static lanes_int classify_squares(__global const SurfaceBounds* s, const float* form, Cube cube,
                                  const lanes_float* u, const float* width) {
    lanes_float value = form[3];
    lanes_float size = fabs(form[3]);
    lanes_float gx = 0;
    lanes_float gy = 0;
    lanes_float gz = 0;
    lanes_float error = 0;
    float above = 0;
    float below = 0;
    for (int i = 0; i < 3; ++i) {
        const lanes_float weighted = form[i] * u[i];
        const lanes_float magnitude = fabs(weighted);
        const float square = form[i] * width[i] * width[i];
        value += weighted * u[i];
        size += magnitude * fabs(u[i]);
        gx += weighted * s->map[4 * i];
        gy += weighted * s->map[4 * i + 1];
        gz += weighted * s->map[4 * i + 2];
        error += 2.0f * magnitude * (s->error[i] + RELATIVE * width[i]) +
                 fabs(form[i]) * s->error[i] * (s->error[i] + 2.0f * width[i]);
        if (square > 0) {
            above += square;
        } else {
            below += square;
        }
    }
    const lanes_float spread =
        2.0f * cube.half_edge * (fabs(gx) + fabs(gy) + fabs(gz)) + error + RELATIVE * (size + above - below);
    return decide(value - spread + below, value + spread + above);
}

// A formula, from the ranges of its coordinates, lane by lane.
static lanes_int classify_formula(__global const SurfaceBounds* s, __global const ExpressionOp* ops,
                                  const lanes_float* low, const lanes_float* high) {
    float lows[3][LANES];
    float highs[3][LANES];
    int signs[LANES];
    for (int i = 0; i < 3; ++i) {
        STORE_LANES(low[i], lows[i]);
        STORE_LANES(high[i], highs[i]);
    }
    for (int lane = 0; lane < LANES; ++lane) {
        const Interval f = expression_bounds(
            ops + s->first_op, s->op_count, make_interval(lows[0][lane], highs[0][lane]),
            make_interval(lows[1][lane], highs[1][lane]), make_interval(lows[2][lane], highs[2][lane]));
        signs[lane] = interval_sign(f);
    }
    return LOAD_LANES(signs);
}

// A torus, from the ranges of the distance to its axis and of the height.
static lanes_int classify_torus(__global const SurfaceBounds* s, lanes_float radial_low,
                                lanes_float radial_high, lanes_float low, lanes_float high) {
    const lanes_float ring_low = radial_low - s->form[0] * (1.0f + RELATIVE);
    const lanes_float ring_high = radial_high - s->form[0] * (1.0f - RELATIVE);
    const lanes_float f_low =
        interval_square_low(ring_low, ring_high) + interval_square_low(low, high) + s->form[3];
    const lanes_float f_high =
        interval_square_high(ring_low, ring_high) + interval_square_high(low, high) + s->form[3];
    const lanes_float slack = RELATIVE * (fabs(f_low) + fabs(f_high) + 2.0f * fabs(s->form[3]));
    return decide(f_low - slack, f_high + slack);
}

static lanes_int classify_surface(__global const SurfaceBounds* s, __global const ExpressionOp* ops,
                                  Cube cube) {
    lanes_float u[3];
    float width[3];
    if (s->kind == kSurfacePatch) return (lanes_int)(0);  // is in the tape only where it passes (spatial.h)
    const int rows = s->kind == kSurfacePlane ? 1 : 3;
    for (int i = 0; i < rows; ++i) {
        const float a = s->map[4 * i];
        const float b = s->map[4 * i + 1];
        const float c = s->map[4 * i + 2];
        u[i] = a * cube.x + b * cube.y + c * cube.z + s->map[4 * i + 3];
        width[i] = cube.half_edge * (fabs(a) + fabs(b) + fabs(c)) * (1.0f + RELATIVE);
    }
    if (s->kind == kSurfacePlane) {
        const float reach = width[0] + s->error[0];
        return decide(u[0] - reach, u[0] + reach);
    }
    if (s->kind == kSurfaceQuadric) {
        const float form[4] = {s->form[0], s->form[1], s->form[2], s->form[3]};
        return classify_squares(s, form, cube, u, width);
    }
    if (s->kind == kSurfaceRounded) return classify_rounded(s, ops, cube, u, width);
    lanes_float low[3];
    lanes_float high[3];
    for (int i = 0; i < 3; ++i) {
        const float reach = width[i] + s->error[i];
        low[i] = u[i] - reach;
        high[i] = u[i] + reach;
    }
    if (s->kind == kSurfaceExpression) return classify_formula(s, ops, low, high);
    const lanes_float radial_low =
        sqrt(interval_square_low(low[0], high[0]) + interval_square_low(low[1], high[1])) * (1.0f - RELATIVE);
    const lanes_float radial_high =
        sqrt(interval_square_high(low[0], high[0]) + interval_square_high(low[1], high[1])) *
        (1.0f + RELATIVE);
    if (s->kind == kSurfaceCone) {
        const lanes_float slack = RELATIVE * (radial_high + fabs(low[2]) + fabs(high[2]));
        const lanes_int sign = decide(radial_low + low[2] - slack, radial_high + high[2] + slack);
        // Below the apex f has the sign of u0² + u1² - u2², whose bounds are sharper.
        const float form[4] = {1, 1, -1, 0};
        const lanes_int sharper = classify_squares(s, form, cube, u, width);
        return select(sign, sharper, (high[2] < 0.0f) & (sign == 0));
    }
    return classify_torus(s, radial_low, radial_high, low[2], high[2]);
}

#endif
