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
        constexpr int kAround = 24;
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
/// it. Negative inside, to about 1e-9 of the solid's size.
inline double rounded_distance(const RoundedSolid& solid, const Vec3& p) {
    if (solid.shape == RoundedSolid::Shape::kRing) return rounded_distance(profile_of(solid), in_profile(p));
    const auto value = [&](const Vec3& u) { return rounded_beyond(solid, p, u); };
    const bool column = solid.shape == RoundedSolid::Shape::kColumn;
    const auto unit = [&](Vec3 u) {
        if (column) u[2] = 0;
        const double norm = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        return norm > 0 ? Vec3{u[0] / norm, u[1] / norm, u[2] / norm} : Vec3{1, 0, 0};
    };
    Vec3 best = {1, 0, 0};
    for (const Vec3& direction : directions_around()) {
        const Vec3 u = unit(direction);
        if (value(u) > value(best)) best = u;
    }
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
    }
    return value(best);
}

/// Whether a rounded solid holds a point. Gilbert's method walks towards the point from support point to
/// support point; close to the surface the search of directions decides.
inline bool rounded_holds(const RoundedSolid& solid, const Vec3& p) {
    using Shape = RoundedSolid::Shape;
    if (solid.shape == Shape::kRing) return rounded_holds(profile_of(solid), in_profile(p));
    const bool column = solid.shape == Shape::kColumn;
    // The point of the solid that is farthest along u, in the plane z = 0 for a column.
    const auto farthest = [&](const Vec3& u) {
        const double across = std::sqrt(u[0] * u[0] + u[1] * u[1]);
        const double along[2] = {across > 0 ? u[0] / across : 1, across > 0 ? u[1] / across : 0};
        Vec3 best{};
        double most = -HUGE_VAL;
        for (const Ball& ball : solid.balls) {
            Vec3 x = ball.center;
            if (solid.shape == Shape::kHull) {
                for (std::size_t k = 0; k < 3; ++k) x[k] += ball.radius * u[k];
            } else if (solid.shape == Shape::kRevolution) {
                const double out = std::fabs(ball.center[0]);
                x = {out * along[0] + ball.radius * u[0], out * along[1] + ball.radius * u[1],
                     ball.center[1] + ball.radius * u[2]};
            } else {
                x = {x[0] + ball.radius * along[0], x[1] + ball.radius * along[1], 0};
            }
            const double value = u[0] * x[0] + u[1] * x[1] + u[2] * x[2];
            if (value > most) best = x;
            most = std::max(most, value);
        }
        if (solid.shape == Shape::kPlate) {
            best[2] = u[2] > 0 ? solid.high : solid.low;
            for (std::size_t k = 0; k < 3; ++k) best[k] += solid.rounding * u[k];
        }
        return best;
    };
    const Vec3 target = {p[0], p[1], column ? 0 : p[2]};
    Vec3 at = farthest({1, 0, 0});
    for (int i = 0; i < 200; ++i) {
        Vec3 to{};
        double distance = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            to[k] = target[k] - at[k];
            distance += to[k] * to[k];
        }
        distance = std::sqrt(distance);
        if (distance < 1e-6) return true;
        const Vec3 next = farthest({to[0] / distance, to[1] / distance, to[2] / distance});
        double ahead = 0;
        double step = 0;
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            ahead += to[k] * (target[k] - next[k]);
            step += to[k] * (next[k] - at[k]);
            square += (next[k] - at[k]) * (next[k] - at[k]);
        }
        if (ahead > 0) return false;  // a plane between
        if (!(square > 0)) return true;
        step = std::min(1.0, step / square);
        for (std::size_t k = 0; k < 3; ++k) at[k] += step * (next[k] - at[k]);
    }
    return rounded_distance(solid, p) <= 0;
}

}  // namespace mortise::test
