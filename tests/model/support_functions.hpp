// Convex solids by their support functions, to compare hulls and sums with: no code in common with the
// library.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/model/built_hull.hpp"
#include "tests/model/membership.hpp"

namespace mortise::test {

/// The largest value of a direction times a point of the solid: what defines a convex solid.
using Support = std::function<double(const Vec3&)>;

inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline Support ball(const Vec3& c, double r) {
    return [=](const Vec3& u) { return dot(u, c) + r * std::sqrt(dot(u, u)); };
}
inline Support box_of(const Vec3& low, const Vec3& high) {
    return [=](const Vec3& u) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) sum += std::max(u[k] * low[k], u[k] * high[k]);
        return sum;
    };
}
inline Support frustum(double x, double y, double z0, double z1, double r0, double r1) {
    return [=](const Vec3& u) {
        const double across = std::hypot(u[0], u[1]);
        return u[0] * x + u[1] * y + std::max(u[2] * z0 + across * r0, u[2] * z1 + across * r1);
    };
}
inline Support hull_of(const std::vector<Support>& parts) {
    return [=](const Vec3& u) {
        double most = -1e300;
        for (const Support& part : parts) most = std::max(most, part(u));
        return most;
    };
}
inline Support sum_of(const Support& a, const Support& b) {
    return [=](const Vec3& u) { return a(u) + b(u); };
}
inline Support rotated_x(const Support& a) {  // by 90 degrees: y to z
    return [=](const Vec3& u) { return a({u[0], u[2], -u[1]}); };
}

/// How far outside a point is: the best of many directions, then of ever smaller changes to it.
inline double outside(const Support& support, const Vec3& p, std::mt19937& random) {
    std::normal_distribution<double> normal;
    const auto value = [&](const Vec3& u) { return dot(u, p) - support(u); };
    const auto unit = [](Vec3 u) {
        const double norm = std::sqrt(dot(u, u));
        return Vec3{u[0] / norm, u[1] / norm, u[2] / norm};
    };
    Vec3 best = {0, 0, 1};
    for (const Vec3& u : {Vec3{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -1}}) {
        if (value(u) > value(best)) best = u;
    }
    for (int i = 0; i < 300; ++i) {
        const Vec3 u = unit({normal(random), normal(random), normal(random)});
        if (value(u) > value(best)) best = u;
    }
    for (int i = 0; i < 400; ++i) {
        const double step = std::pow(0.98, i);
        const Vec3 u = unit({best[0] + step * normal(random), best[1] + step * normal(random),
                             best[2] + step * normal(random)});
        if (value(u) > value(best)) best = u;
    }
    return value(best);
}

/// Compares at random points of a cube, except within `band` of the surface.
inline void compare(const Built& built, const Support& support, double half, double band = 0.01) {
    REQUIRE(built.error.empty());
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(-half, half);
    int wrong = 0;
    int inside = 0;
    for (int i = 0; i < 800; ++i) {
        const Vec3 p = {coordinate(random), coordinate(random), coordinate(random)};
        const double depth = outside(support, p, random);
        if (std::fabs(depth) < band) continue;
        inside += depth < 0;
        const bool held = test::holds(built.model, built.node, p);
        if (held != (depth < 0)) {
            if (wrong++ == 0) MESSAGE("(", p[0], ", ", p[1], ", ", p[2], ") ", depth, " held ", held);
        }
    }
    CHECK(wrong == 0);
    CHECK(inside > 5);
}

/// Of a known form, whose flat faces are exact.
inline bool exact(const Built& built) { return built.model.warnings.empty(); }

inline std::string ball_at(double x, double y, double z, double r) {
    return at(x, y, z, "sphere(r = " + std::to_string(r) + ");");
}

inline std::string rod_at(double x, double y, double z, double h, double r1, double r2) {
    return at(x, y, z,
              "cylinder(h = " + std::to_string(h) + ", r1 = " + std::to_string(r1) +
                  ", r2 = " + std::to_string(r2) + ");");
}

}  // namespace mortise::test
