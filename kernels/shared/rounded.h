// Rounded solids: convex ones whose whole surface is smooth, as signed distances.
//
// The hull of balls is bounded by facets that touch three of them or more, cones along two, and pieces of
// the balls. Each piece is where the surface's normal lies in some part of the unit sphere: a point, an arc,
// a region; together they fill it. With h(n) the support of the solid, the distance is the greatest of
// n·x - h(n) over all directions n, so f(x) is the greatest value that any piece gives for a direction of its
// own (Schneider, Convex Bodies, §1.7). f is convex, its gradient is that direction; where the balls have
// radius r or more, the gradient turns by no more than |dx| / (r + f). Of a ring that holds in its profile.
//
// Data, an arena of doubles: a header (shape; numbers of facets, arcs and balls; of a plate the middle of its
// heights, half their range and its rounding; how far the solid reaches from its origin), then
//   facets: normal, support;
//   arcs: a ball's centre, axis e, s, q, the ball's radius, m, c: directions s e + q w with unit w across e
//         where w·m >= c;
//   balls: centre, radius, number of neighbours, and for each of these a unit vector e and s: directions n
//          with n·e <= s.
#ifndef MORTISE_SHARED_ROUNDED_H
#define MORTISE_SHARED_ROUNDED_H

#include "platform.h"

#include "expression.h"

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
typedef double rounded_number;
#else
typedef double rounded_number __attribute__((may_alias));  // lies in the expressions' arena
#endif

// Shapes. Append-only.
#define kRoundedHull 0        // of balls
#define kRoundedColumn 1      // of discs in the plane z = 0, at all heights
#define kRoundedPlate 2       // the sum of a column between two heights and a ball
#define kRoundedRevolution 3  // of discs in the half-plane (distance from the z axis, height), turned
#define kRoundedRing 4        // the same, without the hole between

#define kRoundedHeader 8
#define kRoundedFacet 4
#define kRoundedArc 13
#define kRoundedBall 5
#define kRoundedNeighbour 4
#define kRoundedFar 1e30
#define kRoundedTolerance 1e-13  // of the solid's reach, in double precision

#define ROUNDED_SUPPORT rounded_support
#define ROUNDED_NUMBER double
#define ROUNDED_SCALAR double
#define ROUNDED_PICK(condition, yes, no) ((condition) ? (yes) : (no))
#define ROUNDED_SQRT(x) mortise_sqrt(x)
#include "rounded_support.def"
#undef ROUNDED_SUPPORT
#undef ROUNDED_NUMBER
#undef ROUNDED_SCALAR
#undef ROUNDED_PICK
#undef ROUNDED_SQRT

// Value and gradient at u, a point in the solid's own frame.
MORTISE_NOINLINE double rounded_sample(MORTISE_GLOBAL ExpressionOp* data, const double* u, double* gradient) {
    MORTISE_GLOBAL rounded_number* numbers = (MORTISE_GLOBAL rounded_number*)data;
    const double tolerance = kRoundedTolerance * numbers[7];
    double value;
    if (numbers[0] >= kRoundedRevolution) {
        const double radial = mortise_sqrt(u[0] * u[0] + u[1] * u[1]);
        const double inverse = radial > 0 ? 1 / radial : 0;
        const double profile[3] = {radial, u[2], 0};
        double g[3];
        rounded_support(numbers, profile, tolerance, &value, g);
        gradient[0] = g[0] * u[0] * inverse;
        gradient[1] = g[0] * u[1] * inverse;
        gradient[2] = g[1];
    } else {
        rounded_support(numbers, u, tolerance, &value, gradient);
    }
    return value;
}

#endif
