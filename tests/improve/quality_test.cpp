// The quality number against angles and products worked out another way.
#include "host/improve/quality.hpp"
#include "host/common/constants.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/mesher/random_source.hpp"

namespace mortise::improve {
namespace {

double degrees(double radians) { return radians * 180 / kPi; }

/// Dihedral angle at edge ab by the components of c - a and d - a across the edge.
double dihedral(const Point& a, const Point& b, const Point& c, const Point& d) {
    const Point axis = (1 / length(b - a)) * (b - a);
    const auto across = [&](const Point& p) { return (p - a) - dot(p - a, axis) * axis; };
    const Point u = across(c);
    const Point v = across(d);
    return degrees(std::acos(std::clamp(dot(u, v) / (length(u) * length(v)), -1.0, 1.0)));
}

struct Figures {
    double smallest = 180;
    double largest = 0;
    double jacobian = 1;
};

Figures figures_of(const std::array<Point, 4>& p) {
    Figures result;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = i + 1; j < 4; ++j) {
            std::size_t rest[2] = {};
            std::size_t count = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                if (k != i && k != j) rest[count++] = k;
            }
            const double angle = dihedral(p[i], p[j], p[rest[0]], p[rest[1]]);
            result.smallest = std::min(result.smallest, angle);
            result.largest = std::max(result.largest, angle);
        }
    }
    const double volume = std::fabs(dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]));
    for (std::size_t i = 0; i < 4; ++i) {
        double product = 1;
        for (std::size_t j = 0; j < 4; ++j) product *= i == j ? 1 : length(p[j] - p[i]);
        result.jacobian = std::min(result.jacobian, volume / product);
    }
    return result;
}

TEST_CASE("a good tetrahedron is one within 18 to 155 degrees and a scaled Jacobian of 0.2") {
    test::RandomSource random(17);
    int good = 0;
    for (int i = 0; i < 20000; ++i) {
        std::array<Point, 4> p;
        for (Point& point : p) point = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        if (dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) < 0) std::swap(p[2], p[3]);
        const Figures f = figures_of(p);
        const double value = tetrahedron_quality(p[0], p[1], p[2], p[3]);
        const double margin =
            std::min({f.smallest / 18 - 1, (180 - f.largest) / 25 - 1, f.jacobian / 0.2 - 1});
        if (std::fabs(margin) < 1e-3) continue;  // the constants are rounded
        CAPTURE(f.smallest);
        CAPTURE(f.largest);
        CAPTURE(f.jacobian);
        CHECK((value > kGoodQuality) == (margin > 0));
        good += margin > 0 ? 1 : 0;
        CHECK(tetrahedron_quality(p[0], p[2], p[1], p[3]) == kInvertedQuality);
    }
    CHECK(good > 1000);
}

TEST_CASE("quality does not depend on the order of the nodes nor on scale") {
    const std::array<Point, 4> p = {{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1, 0.1}, {0.1, 0.3, 0.9}}};
    const double value = tetrahedron_quality(p[0], p[1], p[2], p[3]);
    CHECK(tetrahedron_quality(p[1], p[2], p[0], p[3]) == doctest::Approx(value));
    CHECK(tetrahedron_quality(p[1], p[0], p[3], p[2]) == doctest::Approx(value));
    CHECK(tetrahedron_quality(1e-6 * p[0], 1e-6 * p[1], 1e-6 * p[2], 1e-6 * p[3]) == doctest::Approx(value));
}

TEST_CASE("a corner of a cube is perfect, a flat or inverted one is not") {
    CHECK(corner_quality({1, 0, 0}, {0, 1, 0}, {0, 0, 1}) == doctest::Approx(1));
    CHECK(corner_quality({0, 1, 0}, {1, 0, 0}, {0, 0, 1}) == kInvertedQuality);
    CHECK(corner_quality({1, 0, 0}, {0, 1, 0}, {1, 1, 0}) == kInvertedQuality);
    // The pyramid over a square with its apex at half the edge: 45 degrees at the base, 0.577 at its corners.
    const double low = pyramid_quality({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.5}}});
    CHECK(low == doctest::Approx(std::min(std::sqrt(0.5), kObtuseWeight * std::sin(kPi * 120 / 180))));
}

}  // namespace
}  // namespace mortise::improve
