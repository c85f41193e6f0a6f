// Random surfaces of every kind inside the unit cube, for tests of kernels/shared/surface.h.
#pragma once

#include <cmath>
#include <vector>

#include "host/tape/rounded.hpp"
#include "kernels/shared/surface.h"
#include "tests/mesher/random_source.hpp"
#include "tests/shared/random_programs.hpp"

namespace mortise::test {

/// As `kind`: a rounded solid, as patches are made of triangles only.
inline constexpr int kRandomRounded = 5;
inline constexpr int kSurfaceKinds = 6;

/// A rounded solid of any shape about the origin, of size 1 or so.
inline RoundedSolid random_rounded(RandomSource& random) {
    RoundedSolid solid;
    solid.shape = static_cast<RoundedSolid::Shape>(random.integer(0, 4));
    const bool plate = solid.shape == RoundedSolid::Shape::kPlate;
    const bool alike = random.chance(0.5);
    const bool grid = random.chance(0.3);  // many in one plane
    const double radius = random.uniform(0.05, 0.4);
    for (int i = random.integer(plate ? 1 : 2, 7); i-- > 0;) {
        Ball ball;
        for (double& x : ball.center) x = grid ? random.integer(-1, 1) * 0.5 : random.uniform(-0.7, 0.7);
        ball.radius = alike ? radius : random.uniform(0.05, 0.4);
        if (plate && random.chance(0.2)) ball.radius = 0;
        if (solid.shape == RoundedSolid::Shape::kRing)
            ball.center[0] = ball.radius + random.uniform(0.05, 0.7);
        solid.balls.push_back(ball);
    }
    solid.low = random.uniform(-0.5, -0.1);
    solid.high = random.uniform(0.1, 0.5);
    solid.rounding = random.uniform(0.05, 0.3);
    return solid;
}

/// A surface of the kind given; its data in the arena, if it has any, are appended to `ops`.
inline Surface random_surface(RandomSource& random, int kind, std::vector<ExpressionOp>& ops) {
    Surface s{};
    if (kind == kRandomRounded) s = tape::write_rounded(random_rounded(random), ops);
    if (kind != kRandomRounded) s.kind = kind;
    if (kind == kSurfacePlane) {
        double square = 0;
        for (int j = 0; j < 3; ++j) {
            s.map[j] = random.chance(0.2) ? 0 : random.uniform(-1, 1);
            square += s.map[j] * s.map[j];
        }
        if (square == 0) s.map[0] = square = 1;
        for (int j = 0; j < 3; ++j) {
            s.map[j] /= std::sqrt(square);
            s.map[3] -= s.map[j] * random.uniform(0.2, 0.8);
        }
        return s;
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) s.map[4 * i + j] = (i == j ? 2 : 0) + random.uniform(-1, 1);
        s.map[4 * i + 3] = 0;
        for (int j = 0; j < 3; ++j) s.map[4 * i + 3] -= s.map[4 * i + j] * random.uniform(0.3, 0.7);
    }
    if (kind == kSurfaceQuadric) {
        s.form[0] = s.form[1] = 1;
        s.form[2] = random.integer(-1, 1);
        s.form[3] = s.form[2] < 0 ? 0 : -random.uniform(0.05, 1);
    } else if (kind == kSurfaceTorus) {
        s.form[0] = random.uniform(0.2, 0.8);
        const double minor = random.uniform(0.05, 0.5);
        s.form[3] = -minor * minor;
    } else if (kind == kSurfaceExpression) {
        const auto program = random_program(random, random.integer(4, 16), random.chance(0.5));
        s.first_op = static_cast<u32>(ops.size());
        s.op_count = static_cast<u32>(program.size());
        ops.insert(ops.end(), program.begin(), program.end());
    }
    return s;
}

}  // namespace mortise::test
