// minkowski() of extrusions that are not convex, against distances from their plane shapes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "host/model/outlines/convex_parts.hpp"
#include "host/model/outlines/polygons.hpp"
#include "mortise/error.hpp"
#include "tests/model/even_odd.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;

namespace {

using model_reader::Contours;
using model_reader::Vec2;
using Loop = std::vector<Vec2>;

struct Sum {
    Model model;
    std::string error;
    bool holds(const Vec3& p) const { return test::holds(model, model.regions[0].root, p); }
};

/// The sum of two solids of OpenSCAD.
Sum sum_of(const std::string& text) {
    Sum sum;
    try {
        sum.model = parse_model("minkowski() { " + text + " }", "csg", "m.csg");
    } catch (const Error& error) {
        sum.error = error.what();
    }
    return sum;
}

const Loop kAngle = {{0, 0}, {20, 0}, {20, 4}, {4, 4}, {4, 20}, {0, 20}};

/// From a point to the shape; 0 inside.
double distance_to(const Contours& shape, const Vec2& p) {
    if (test::even_odd(shape, p)) return 0;
    double nearest = HUGE_VAL;
    for (const Loop& loop : shape) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
            const Vec2 d = {b[0] - a[0], b[1] - a[1]};
            const double t = std::clamp(
                ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]), 0.0, 1.0);
            nearest = std::min(nearest, std::hypot(p[0] - a[0] - t * d[0], p[1] - a[1] - t * d[1]));
        }
    }
    return nearest;
}

/// As arguments of polygon(), each loop a path.
std::string polygon_text(const Contours& shape) {
    std::ostringstream points, paths;
    points.precision(17);
    std::size_t number = 0;
    for (const Loop& loop : shape) {
        paths << (number > 0 ? ", [" : "[");
        for (std::size_t i = 0; i < loop.size(); ++i, ++number) {
            points << (number > 0 ? ", " : "") << "[" << loop[i][0] << ", " << loop[i][1] << "]";
            paths << (i > 0 ? ", " : "") << number;
        }
        paths << "]";
    }
    return "polygon(points = [" + points.str() + "], paths = [" + paths.str() + "]);";
}

/// A star with one hole in its middle.
Contours random_star(std::mt19937& random) {
    std::uniform_real_distribution<double> radius(5, 12);
    Contours shape(2);
    constexpr int kCorners = 9;
    for (int k = 0; k < kCorners; ++k) {
        const double turn = 6.283185307179586 * k / kCorners, r = radius(random);
        shape[0].push_back({r * std::cos(turn), r * std::sin(turn)});
    }
    for (const auto& [x, y] : {std::pair(2.0, 0.0), {0.0, -2.0}, {-2.0, 0.0}, {0.0, 2.0}})
        shape[1].push_back({x, y});
    return shape;
}

}  // namespace

TEST_CASE("convex parts of plane shapes are convex, and have their area together") {
    std::mt19937 random(3);
    std::vector<Contours> shapes = {{kAngle}, {{{0, 0}, {4, 0}, {4, 4}, {0, 4}}}};
    for (int k = 0; k < 20; ++k) shapes.push_back(random_star(random));
    // Holes whose edges are in line with nothing, or with each other; rings; holes close to the rim.
    const auto regular = [](int corners, double radius, double turned) {
        Loop loop;
        for (int k = 0; k < corners; ++k) {
            const double turn = turned + 6.283185307179586 * k / corners;
            loop.push_back({radius * std::cos(turn), radius * std::sin(turn)});
        }
        return loop;
    };
    for (int corners = 3; corners <= 60; ++corners) {
        for (const double radius : {2.0, 5.0, 6.9}) {
            shapes.push_back({regular(4, 10, 0), regular(corners, radius, 0)});
            shapes.push_back({regular(corners, 10, 0), regular(corners, 0.95 * radius, 0)});
            shapes.push_back({regular(5, 10, 1), regular(corners, radius, 0.1 * corners)});
        }
    }
    for (const Contours& given : shapes) {
        const Contours shape = model_reader::normalised(given);
        const auto parts = model_reader::convex_parts(shape, 200);
        REQUIRE(parts);
        double area = 0, expected = 0;
        for (const Loop& loop : shape) expected += model_reader::signed_area(loop);
        for (const Loop& loop : *parts) {
            area += model_reader::signed_area(loop);
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()], &c = loop[(i + 2) % loop.size()];
                CHECK((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > -1e-9);
            }
        }
        CHECK(area == doctest::Approx(expected).epsilon(1e-9));
    }
    // So many that dividing it is not even tried.
    Loop gear;
    for (int k = 0; k < 20000; ++k) {
        const double turn = 6.283185307179586 * k / 20000, radius = k % 2 == 0 ? 10 : 9;
        gear.push_back({radius * std::cos(turn), radius * std::sin(turn)});
    }
    CHECK_FALSE(model_reader::convex_parts({gear}, 256));
    CHECK(model_reader::convex_parts({kAngle}, 2)->size() == 2);
    CHECK_FALSE(model_reader::convex_parts({kAngle}, 1));
    CHECK(model_reader::convex_parts({shapes[1]}, 1)->size() == 1);
}

TEST_CASE("minkowski: extrusions of any outline with a ball, or a cylinder") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> across(-15, 22), along(-2, 6);
    for (int round = 0; round < 6; ++round) {
        const Contours shape = round == 0 ? Contours{kAngle} : random_star(random);
        const std::string solid = "linear_extrude(height = 3) " + polygon_text(shape);
        const Sum ball = sum_of(solid + " sphere(r = 1.5);");
        const Sum cylinder = sum_of(solid + " cylinder(h = 2, r = 1);");
        CAPTURE(solid);
        CHECK(ball.error.empty());
        CHECK(cylinder.error.empty());
        int inside = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p = {across(random), across(random), along(random)};
            const double beside = distance_to(shape, {p[0], p[1]});
            const double above = std::max({-p[2], p[2] - 3, 0.0});
            const double reach = std::hypot(beside, above) - 1.5;
            if (std::fabs(reach) > 1e-6) {
                CHECK(ball.holds(p) == (reach < 0));
                inside += reach < 0 ? 1 : 0;
            }
            if (std::fabs(beside - 1) > 1e-6)
                CHECK(cylinder.holds(p) == (beside < 1 && p[2] > 0 && p[2] < 5));
        }
        CHECK(inside > 100);
    }
}

TEST_CASE("minkowski: circles in an outline stay round, and unions of them are taken one by one") {
    const Sum dumbbell = sum_of(
        "linear_extrude(height = 3) { circle(r = 3); translate([10, 0]) circle(r = 3); square([10, 1]); } "
        "sphere(r = 1);");
    CHECK(dumbbell.error.empty());
    const auto holds = [&](double x, double y, double z) { return dumbbell.holds({x, y, z}); };
    for (int k = 0; k < 36; ++k) {  // away from the bar
        const double turn = 1.6 + 3 * k / 36.0;
        CHECK(holds(3.999 * std::cos(turn), 3.999 * std::sin(turn), 1.5));
        CHECK_FALSE(holds(4.001 * std::cos(turn), 4.001 * std::sin(turn), 1.5));
    }
    CHECK(holds(5, 1.999, 1.5));
    CHECK_FALSE(holds(5, 2.001, 1.5));
    CHECK(holds(5, 0.5, 3.999));
}

TEST_CASE("minkowski: rings and plates with round holes keep their holes") {
    const Sum ring = sum_of(
        "linear_extrude(height = 3) difference() { circle(r = 10, $fn = 24); circle(r = 5, $fn = 24); } "
        "sphere(r = 1);");
    CHECK(ring.error.empty());
    for (int k = 0; k < 24; ++k) {  // at corners and in the middles of edges
        for (const double half : {0.0, 0.5}) {
            const double turn = 6.283185307179586 * (k + half) / 24;
            const double to_edge = half > 0 ? std::cos(6.283185307179586 / 48) : 1;
            const auto holds = [&](double r) {
                return ring.holds({r * std::cos(turn), r * std::sin(turn), 1.5});
            };
            CHECK_FALSE(holds(5 * to_edge - 1.05));
            CHECK(holds(5 * to_edge - 0.9));
            CHECK(holds(10 * to_edge + 0.99));
            CHECK_FALSE(holds(11.01));
        }
    }
    CHECK_FALSE(ring.holds({0, 0, 1.5}));
}

TEST_CASE("minkowski: an extrusion whose sides are no planes is refused") {
    // Scaled by different factors along x and y, its slanted sides are ruled surfaces.
    const Sum sum = sum_of(
        "linear_extrude(height = 10, scale = [0.2, 1]) polygon([[10,0],[0,10],[-10,0],[0,-10],[3,0]]); "
        "cube(1);");
    CHECK_FALSE(sum.error.empty());
    const Sum tapered =
        sum_of("linear_extrude(height = 10, scale = 0.5) " + polygon_text({kAngle}) + " cube([1, 1, 1]);");
    CHECK(tapered.error.empty());
    CHECK(tapered.holds({10.9, 1.9, 10.9}));
    CHECK_FALSE(tapered.holds({11.2, 1, 10.9}));
    CHECK_FALSE(tapered.holds({5, 5, 10.9}));
}

TEST_CASE("minkowski: extrusions with too many parts are told of") {
    std::ostringstream points;
    for (int i = 0; i < 600; ++i) points << "[" << i << ", " << i % 2 << "], ";
    const Sum comb = sum_of("linear_extrude(height = 3) polygon([" + points.str() +
                            "[600, 5], [0, 5]]); sphere(r = 0.1);");
    CHECK(comb.error.find("'minkowski': an extrusion among its children has more than 256 convex parts") !=
          std::string::npos);
}
