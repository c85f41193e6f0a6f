// Surfaces: the smooth functions f(x) whose zero sets bound the solid, in box-local coordinates.
//
// f < 0 inside, f > 0 outside. Every surface is one smooth sheet family (a box is six surfaces, a capped
// cylinder three), so that signs, roots and active sets are per surface. Values,
// gradients, signs and roots are pure functions in double precision: bit-identical on host and device.
#ifndef MORTISE_SHARED_SURFACE_H
#define MORTISE_SHARED_SURFACE_H

#include "platform.h"

#include "expression.h"
#include "lattice.h"
#include "patch.h"
#include "rounded.h"

// Kinds of surface. Append-only. With u = map · (x, 1):
#define kSurfacePlane 0       // u0, |row 0| = 1
#define kSurfaceQuadric 1     // form0 u0² + form1 u1² + form2 u2² + form3
#define kSurfaceCone 2        // sqrt(u0² + u1²) + u2   (single nappe)
#define kSurfaceTorus 3       // (sqrt(u0² + u1²) - form0)² + u2² + form3
#define kSurfaceExpression 4  // expression operations first_op … first_op + op_count - 1, in x, y, z = u
#define kSurfacePatch \
    5  // signed distance to triangles (patch.h) at ops + first_op, with u as point;
       // form0: where its triangles start, form1: what tells it from other patches,
       // form2: length that counts as none
#define kSurfaceRounded \
    6  // signed distance to a rounded solid (rounded.h) at ops + first_op, with u as point;
       // form0: its least radius, form1: what tells it from others, form2: its shape, form3: its reach

typedef struct Surface {
    double map[12];  // row-major 3×4, box-local x to the surface's own frame u
    double form[4];
    i32 kind;
    u32 first_op;
    u32 op_count;
    i32 padding;
} Surface;

// A vertex closer than this to a surface (to first order, in edges of the finest cell) is on it.
#define kSignTolerance (1.0 / 131072.0)
// Roots keep this distance from the ends of their edge and from each other, in lattice units.
#define kRootMargin 512
#define kRootIterations 64

typedef struct SurfaceSample {
    double value;
    double gradient[3];  // with respect to box-local x
} SurfaceSample;

MORTISE_FUNCTION void surface_frame(MORTISE_GLOBAL Surface* s, double x, double y, double z, double* u) {
    for (int i = 0; i < 3; ++i) {
        u[i] = s->map[4 * i] * x + s->map[4 * i + 1] * y + s->map[4 * i + 2] * z + s->map[4 * i + 3];
    }
}

MORTISE_FUNCTION double surface_patch(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops,
                                      const double* u, double* gradient) {
    MORTISE_GLOBAL patch_number* data = (MORTISE_GLOBAL patch_number*)(ops + s->first_op);
    return patch_sample(data, data + (u32)s->form[0], s->form[2], u, gradient);
}

// Where a formula is no number it is asked a little beside, in box-local x: sin(x)/x has no value at 0, but
// its limit. What is no number there either is outside: a root search then ends at the edge of the domain.
#define kBesideNan (1.0 / 4194304.0)

MORTISE_FUNCTION void surface_frame_beside(MORTISE_GLOBAL Surface* s, double x, double y, double z,
                                           double* u) {
    surface_frame(s, x + kBesideNan, y + 0.618 * kBesideNan, z + 0.414 * kBesideNan, u);
}

// f(x) alone: what sign tests and root finding need.
MORTISE_FUNCTION double surface_value(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops, double x,
                                      double y, double z) {
    double u[3];
    if (s->kind == kSurfacePlane) {
        return s->map[0] * x + s->map[1] * y + s->map[2] * z + s->map[3];
    }
    surface_frame(s, x, y, z, u);
    if (s->kind == kSurfaceQuadric) {
        return s->form[0] * (u[0] * u[0]) + s->form[1] * (u[1] * u[1]) + s->form[2] * (u[2] * u[2]) +
               s->form[3];
    }
    if (s->kind == kSurfaceExpression) {
        double value = expression_value(ops + s->first_op, s->op_count, u);
        if (value != value) {
            surface_frame_beside(s, x, y, z, u);
            value = expression_value(ops + s->first_op, s->op_count, u);
        }
        return value == value ? value : kMortiseInfinity;
    }
    if (s->kind == kSurfacePatch) {
        double gradient[3];
        return surface_patch(s, ops, u, gradient);
    }
    if (s->kind == kSurfaceRounded) {
        double gradient[3];
        return rounded_sample(ops + s->first_op, u, gradient);
    }
    const double radial = mortise_sqrt(u[0] * u[0] + u[1] * u[1]);
    if (s->kind == kSurfaceCone) return radial + u[2];
    return (radial - s->form[0]) * (radial - s->form[0]) + u[2] * u[2] + s->form[3];
}

// f(x) and its gradient. Where the gradient does not exist (a cone's axis), the part that does.
MORTISE_FUNCTION SurfaceSample surface_sample(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops,
                                              double x, double y, double z) {
    SurfaceSample result;
    double u[3];
    double d[3] = {0, 0, 0};  // df/du
    if (s->kind == kSurfacePlane) {
        result.value = s->map[0] * x + s->map[1] * y + s->map[2] * z + s->map[3];
        for (int j = 0; j < 3; ++j) result.gradient[j] = s->map[j];
        return result;
    }
    surface_frame(s, x, y, z, u);
    if (s->kind == kSurfaceQuadric) {
        result.value =
            s->form[0] * (u[0] * u[0]) + s->form[1] * (u[1] * u[1]) + s->form[2] * (u[2] * u[2]) + s->form[3];
        for (int i = 0; i < 3; ++i) d[i] = 2 * s->form[i] * u[i];
    } else if (s->kind == kSurfaceExpression) {
        result.value = expression_sample(ops + s->first_op, s->op_count, u, d);
        if (result.value != result.value) {
            surface_frame_beside(s, x, y, z, u);
            result.value = expression_sample(ops + s->first_op, s->op_count, u, d);
        }
        if (result.value != result.value) result.value = kMortiseInfinity;
    } else if (s->kind == kSurfacePatch) {
        result.value = surface_patch(s, ops, u, d);
    } else if (s->kind == kSurfaceRounded) {
        result.value = rounded_sample(ops + s->first_op, u, d);
    } else {
        const double radial = mortise_sqrt(u[0] * u[0] + u[1] * u[1]);
        const double inverse = radial > 0 ? 1 / radial : 0;
        if (s->kind == kSurfaceCone) {
            result.value = radial + u[2];
            d[0] = u[0] * inverse;
            d[1] = u[1] * inverse;
            d[2] = 1;
        } else {
            const double q = radial - s->form[0];
            result.value = q * q + u[2] * u[2] + s->form[3];
            d[0] = 2 * q * u[0] * inverse;
            d[1] = 2 * q * u[1] * inverse;
            d[2] = 2 * u[2];
        }
    }
    for (int j = 0; j < 3; ++j) {
        result.gradient[j] = d[0] * s->map[j] + d[1] * s->map[4 + j] + d[2] * s->map[8 + j];
    }
    return result;
}

// Sign of f at a point: -1 inside, +1 outside, 0 when the point is within kSignTolerance·cell_size of the
// surface to first order. NaN there and beside it counts as outside. Pure: the same point has the same sign
// in every cell.
MORTISE_NOINLINE int surface_sign(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops, double x,
                                  double y, double z, double cell_size) {
    const SurfaceSample sample = surface_sample(s, ops, x, y, z);
    const double squared = sample.gradient[0] * sample.gradient[0] + sample.gradient[1] * sample.gradient[1] +
                           sample.gradient[2] * sample.gradient[2];
    // Where a formula overflows on the way, the gradient tells nothing of the distance.
    const double tolerance =
        squared < kMortiseInfinity ? kSignTolerance * cell_size * mortise_sqrt(squared) : 0;
    if (sample.value < -tolerance) return -1;
    if (sample.value > tolerance) return 1;
    return mortise_fabs(sample.value) <= tolerance ? 0 : 1;
}

// Root of the quadratic that a quadric makes along a segment; -1 if rounding hides it.
MORTISE_FUNCTION double quadric_root(MORTISE_GLOBAL Surface* s, const double* a, const double* b) {
    double u[3];
    double v[3];
    double square = 0;
    double linear = 0;
    double offset = s->form[3];
    surface_frame(s, a[0], a[1], a[2], u);
    surface_frame(s, b[0], b[1], b[2], v);
    for (int i = 0; i < 3; ++i) {
        const double difference = v[i] - u[i];
        square += s->form[i] * (difference * difference);
        linear += 2 * s->form[i] * u[i] * difference;
        offset += s->form[i] * (u[i] * u[i]);
    }
    {
        const double discriminant = linear * linear - 4 * square * offset;
        const double root = discriminant > 0 ? mortise_sqrt(discriminant) : 0;
        const double q = linear >= 0 ? -0.5 * (linear + root) : -0.5 * (linear - root);
        const double first = q != 0 ? offset / q : -1;
        const double second = square != 0 ? q / square : -1;
        if (first > 0 && first < 1) return first;
        if (second > 0 && second < 1) return second;
    }
    return -1;
}

// Parameter t in (0, 1) of a root of f between a and b, whose signs differ. If the values do not bracket a
// root (signs inherited by the certificate may differ from the values), the linear estimate is returned.
MORTISE_FUNCTION double segment_root(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops,
                                     const double* a, const double* b) {
    double low = 0;
    double high = 1;
    double f_low = surface_value(s, ops, a[0], a[1], a[2]);
    double f_high = surface_value(s, ops, b[0], b[1], b[2]);
    if (!((f_low < 0 && f_high > 0) || (f_low > 0 && f_high < 0))) {
        const double total = mortise_fabs(f_low) + mortise_fabs(f_high);
        return total > 0 && total < kMortiseInfinity ? mortise_fabs(f_low) / total : 0.5;
    }
    if (s->kind == kSurfacePlane) return f_low / (f_low - f_high);
    if (s->kind == kSurfaceQuadric) {
        const double t = quadric_root(s, a, b);
        if (t > 0) return t;
    }
    // Illinois: regula falsi that halves the weight of an end kept twice; every other step is a bisection
    // once it is slow (steep or flat formulas).
    int kept = 0;
    for (int i = 0; i < kRootIterations && high - low > 1e-12; ++i) {
        double t = low + (high - low) * (f_low / (f_low - f_high));
        if (!(t > low && t < high) || (i >= 8 && (i & 1) == 0)) t = 0.5 * (low + high);
        const double f = surface_value(s, ops, a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]),
                                       a[2] + t * (b[2] - a[2]));
        if (f == 0) return t;
        if ((f < 0) == (f_low < 0)) {
            low = t;
            f_low = f;
            if (kept == 1) f_high *= 0.5;
            kept = 1;
        } else {
            high = t;
            f_high = f;
            if (kept == -1) f_low *= 0.5;
            kept = -1;
        }
    }
    return 0.5 * (low + high);
}

// A root's place on a grid edge, 0 to 1, in lattice units from the low end, kept off both ends.
MORTISE_FUNCTION i32 edge_units(double place) {
    const double t = mortise_rint(place * (double)kCellUnits);
    if (t < (double)kRootMargin) return kRootMargin;
    if (t > (double)(kCellUnits - kRootMargin)) return kCellUnits - kRootMargin;
    return (i32)t;
}

MORTISE_NOINLINE i32 edge_root(MORTISE_GLOBAL Surface* s, MORTISE_GLOBAL ExpressionOp* ops, const double* low,
                               const double* high) {
    return edge_units(segment_root(s, ops, low, high));
}

#endif
