// translate, rotate, scale, mirror and children without braces: .csg files that OpenSCAD did not write.
#include <doctest/doctest.h>

#include <cmath>

#include "host/common/random.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;
using test::refusal;
using test::region_at;

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

/// p turned about an axis of length 1, by vectors (Rodrigues) instead of a matrix.
Vec3 turned(const Vec3& p, const Vec3& n, double degrees) {
    const double c = std::cos(degrees * kDegree);
    const double s = std::sin(degrees * kDegree);
    const double along = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
    const Vec3 across = {n[1] * p[2] - n[2] * p[1], n[2] * p[0] - n[0] * p[2], n[0] * p[1] - n[1] * p[0]};
    Vec3 result{};
    for (std::size_t k = 0; k < 3; ++k) result[k] = c * p[k] + s * across[k] + (1 - c) * along * n[k];
    return result;
}

constexpr const char* kWedge =
    "polyhedron(points = [[0,0,0],[3,0,0],[0,2,0],[0,0,1]], "
    "faces = [[0,1,2],[0,3,1],[1,3,2],[2,3,0]]);";

bool in_wedge(const Vec3& p) { return p[0] > 0 && p[1] > 0 && p[2] > 0 && p[0] / 3 + p[1] / 2 + p[2] < 1; }

/// The moved wedge holds a point where the wedge itself holds what `back` makes of it.
template <typename Back>
void compare(const std::string& transforms, const Back& back) {
    CAPTURE(transforms);
    const Model model = read_csg(transforms + kWedge);
    Random random(3);
    int wrong = 0;
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = {8 * random.uniform() - 4, 8 * random.uniform() - 4, 8 * random.uniform() - 4};
        wrong += (region_at(model, p) == 1) != in_wedge(back(p)) ? 1 : 0;
        inside += in_wedge(back(p)) ? 1 : 0;
    }
    CHECK(wrong == 0);
    CHECK(inside > 20);
}

}  // namespace

TEST_CASE("translate, rotate, scale and mirror move points as in OpenSCAD") {
    const Vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    compare("translate([1, -2, 0.5])", [](const Vec3& p) { return Vec3{p[0] - 1, p[1] + 2, p[2] - 0.5}; });
    compare("translate(v = [1, -2])", [](const Vec3& p) { return Vec3{p[0] - 1, p[1] + 2, p[2]}; });
    compare("rotate(30)", [&](const Vec3& p) { return turned(p, z, -30); });
    compare("rotate([20])", [&](const Vec3& p) { return turned(p, x, -20); });
    compare("rotate(a = [20, 30, 40])",
            [&](const Vec3& p) { return turned(turned(turned(p, z, -40), y, -30), x, -20); });
    compare("rotate(a = 50, v = [0, -2, 0])", [&](const Vec3& p) { return turned(p, y, 50); });
    compare("rotate(70, [1, 2, 2])", [](const Vec3& p) {
        return turned(p, {1.0 / 3, 2.0 / 3, 2.0 / 3}, -70);
    });
    compare("rotate(45, undef)", [&](const Vec3& p) { return turned(p, z, -45); });
    compare("scale(2)", [](const Vec3& p) { return Vec3{p[0] / 2, p[1] / 2, p[2] / 2}; });
    compare("scale([0.5, -2])", [](const Vec3& p) { return Vec3{p[0] * 2, p[1] / -2, p[2]}; });
    compare("mirror([0, 1])", [](const Vec3& p) { return Vec3{p[0], -p[1], p[2]}; });
    compare("mirror([1, 2, 2])", [](const Vec3& p) {
        const double along = (p[0] + 2 * p[1] + 2 * p[2]) / 9;
        return Vec3{p[0] - 2 * along, p[1] - 4 * along, p[2] - 4 * along};
    });
    compare("mirror([0, 0, 0])", [](const Vec3& p) { return p; });
    compare("translate([1, 0, 0]) rotate([0, 0, 90]) scale([1, 1, 2])", [&](const Vec3& p) {
        const Vec3 q = turned({p[0] - 1, p[1], p[2]}, z, -90);
        return Vec3{q[0], q[1], q[2] / 2};
    });
}

TEST_CASE("right angles are exact") {
    // Not a bit beside the plane: 2^-40 tells.
    const double d = std::ldexp(1, -40);
    for (const char* const turn : {"rotate([0, 0, 90])", "rotate(90)", "rotate(-90, [0, 0, -3])"}) {
        CAPTURE(turn);
        const Model model = read_csg(std::string(turn) + "cube([1, 2, 3]);");
        CHECK(region_at(model, {-2 + d, d, d}) == 1);
        CHECK(region_at(model, {-2 - d, d, d}) == 0);
        CHECK(region_at(model, {-d, 1 - d, 3 - d}) == 1);
        CHECK(region_at(model, {-d, 1 + d, 3 - d}) == 0);
    }
}

TEST_CASE("a node may have one child without braces") {
    // The cut belongs to the translation alone; modifiers and braces nest.
    const Model model = read_csg(
        "difference() {\n"
        "    translate([1, 0, 0]) rotate([0, 0, 90]) cube([1, 2, 3]);\n"
        "    translate([-1, 0, 1]) union() { cube(1); translate([0, 0, 1]) *cube(1); }\n"
        "}\n"
        "linear_extrude(height = 2) translate([5, 5]) circle(r = 1);\n");
    CHECK(region_at(model, {-0.5, 0.5, 0.5}) == 1);
    CHECK(region_at(model, {-0.5, 0.5, 1.5}) == 0);
    CHECK(region_at(model, {-0.5, 0.5, 2.5}) == 1);
    CHECK(region_at(model, {0.5, 0.5, 1.5}) == 1);
    CHECK(region_at(model, {5.9, 5, 1}) == 1);
    CHECK(region_at(model, {5.9, 5.9, 1}) == 0);

    const Model root = read_csg("cube(9); union() { translate([20, 0, 0]) !rotate([0, 0, 90]) cube(1); }");
    CHECK(region_at(root, {-0.5, 0.5, 0.5}) == 1);
    CHECK(region_at(root, {5, 5, 5}) == 0);
    CHECK(region_at(root, {19.5, 0.5, 0.5}) == 0);

    // Depth is limited by memory only.
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += "translate([0, 0, 0]) ";
    CHECK(region_at(read_csg(deep + "cube(1);"), {0.5, 0.5, 0.5}) == 1);
}

TEST_CASE("transforms and children without braces: errors") {
    struct Case {
        const char* text;
        const char* place;
        const char* expected;
    };
    for (const Case& c : {
             Case{"translate([1, 2, 3])", "1:21", "expected ';', '{' or a node after 'translate(...)'"},
             {"union() { rotate(3) }", "1:21", "found '}'"},
             {"cube() cube();", "1:8", "expected ';' after 'cube(...)'"},
             {"translate(3) cube();", "1:11", "two or three numbers"},
             {"translate([1, 2, 3, 4]) cube();", "1:11", "two or three numbers"},
             {"translate([[1, 2, 3]]) cube();", "1:11", "two or three numbers"},
             {"translate() cube();", "1:1", "two or three numbers"},
             {"translate(w = [1, 2, 3]) cube();", "1:15", "no argument 'w'"},
             {"rotate([1, 2, 3], [1, 0, 0]) cube();", "1:19", "not a list"},
             {"rotate(3, [0, 0, 0]) cube();", "1:11", "other than [0, 0, 0]"},
             {"rotate(3, [0, 1]) cube();", "1:11", "three numbers"},
             {"rotate(\"a\") cube();", "1:8", "angle a in degrees"},
             {"scale([1]) cube();", "1:7", "a list of two or three"},
             {"scale(0) cube();", "1:7", "singular"},
             {"scale(nan) cube();", "1:7", "nan"},
             {"translate([1, inf, 0]) cube();", "1:15", "nan or inf"},
             {"tranlsate([1, 2, 3]) cube();", "1:1", "did you mean 'translate'"},
         }) {
        CAPTURE(c.text);
        const std::string message = refusal(c.text, "csg");
        CAPTURE(message);
        CHECK(message.find(std::string(":") + c.place + ":") != std::string::npos);
        CHECK(message.find(c.expected) != std::string::npos);
    }
}
