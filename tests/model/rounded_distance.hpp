// The distance of a point from a rounded solid by searching directions: an oracle that shares no code with
// the library.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::test {

inline const std::vector<Vec3>& directions_around() {
    static const std::vector<Vec3> directions = [] {
        constexpr int kAround = 16;
        std::vector<Vec3> result;
        for (int i = 0; i < kAround * kAround; ++i) {
            const double turn = i % kAround * 2 * std::acos(-1.0) / kAround;
            const double z = (i / kAround + 0.5) * 2 / kAround - 1;
            const double rho = std::sqrt(1 - z * z);
            result.push_back({rho * std::cos(turn), rho * std::sin(turn), z});
        }
        return result;
    }();
    return directions;
}

/// A ring is its profile, as a column across the plane of that.
inline RoundedSolid profile_of(RoundedSolid ring) {
    ring.shape = RoundedSolid::Shape::kColumn;
    return ring;
}
inline Vec3 in_profile(const Vec3& p) { return {std::hypot(p[0], p[1]), p[2], 0}; }

/// How far a point is beyond the plane that touches a rounded solid where its normal is u, a unit vector (for
/// a column across z). Not of rings.
inline double rounded_beyond(const RoundedSolid& solid, const Vec3& p, const Vec3& u) {
    using Shape = RoundedSolid::Shape;
    const double across = std::sqrt(u[0] * u[0] + u[1] * u[1]);
    double support = -HUGE_VAL;
    for (const Ball& ball : solid.balls) {
        double here = 0;
        if (solid.shape == Shape::kRevolution) {
            here = std::fabs(ball.center[0]) * across + ball.center[1] * u[2] + ball.radius;
        } else {
            const bool flat = solid.shape != Shape::kHull;
            here = ball.center[0] * u[0] + ball.center[1] * u[1] + (flat ? 0 : ball.center[2] * u[2]) +
                   ball.radius * (flat ? across : 1);
        }
        support = std::max(support, here);
    }
    if (solid.shape == Shape::kPlate)
        support += std::max(u[2] * solid.low, u[2] * solid.high) + solid.rounding;
    return u[0] * p[0] + u[1] * p[1] + u[2] * p[2] - support;
}

/// How far outside a rounded solid a point is: the best of many directions, then of ever smaller changes to
/// it. Negative inside, to about 1e-9 of the solid's size. `only_sign`: as far as needed to tell it.
inline double rounded_distance(const RoundedSolid& solid, const Vec3& p, bool only_sign = false) {
    if (solid.shape == RoundedSolid::Shape::kRing)
        return rounded_distance(profile_of(solid), in_profile(p), only_sign);
    const auto value = [&](const Vec3& u) { return rounded_beyond(solid, p, u); };
    const bool column = solid.shape == RoundedSolid::Shape::kColumn;
    const auto unit = [&](Vec3 u) {
        if (column) u[2] = 0;
        const double norm = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        return norm > 0 ? Vec3{u[0] / norm, u[1] / norm, u[2] / norm} : Vec3{1, 0, 0};
    };
    // By how much the value changes with the direction, at most.
    double slope = std::fabs(solid.low) + std::fabs(solid.high);
    for (const double x : p) slope += std::fabs(x);
    double farthest = 0;
    for (const Ball& ball : solid.balls) {
        farthest = std::max(
            farthest, std::fabs(ball.center[0]) + std::fabs(ball.center[1]) + std::fabs(ball.center[2]));
    }
    slope += farthest;
    const auto told = [&](double at_best, double step) {
        return only_sign && (at_best > 0 || at_best + 4 * step * slope < 0);
    };
    Vec3 best = {1, 0, 0};
    for (const Vec3& direction : directions_around()) {
        const Vec3 u = unit(direction);
        if (value(u) > value(best)) best = u;
        if (only_sign && value(best) > 0) return value(best);
    }
    if (told(value(best), 0.2)) return value(best);
    int steps = 0;
    for (double step = 0.2; step > 1e-9 && steps < 2000; ++steps) {
        const Vec3 from = best;
        for (int k = 0; k < 26; ++k) {
            const int code = k < 13 ? k : k + 1;  // without (0, 0, 0)
            const Vec3 u = unit({from[0] + step * (code % 3 - 1), from[1] + step * (code / 3 % 3 - 1),
                                 from[2] + step * (code / 9 - 1)});
            if (value(u) > value(best)) best = u;
        }
        if (best == from) step /= 2;
        if (told(value(best), step)) return value(best);
    }
    return value(best);
}

}  // namespace mortise::test
