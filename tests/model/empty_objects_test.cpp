// Objects of .csg files that are empty: sizes that are zero, negative or not finite, matrices that flatten.
// What OpenSCAD 2021.01 makes of each was tried: see the volumes.
#include <doctest/doctest.h>

#include "host/common/random.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;
using test::refusal;
using test::region_at;

namespace {

/// Whether both texts give the same solid, in points of a cube from -1 to 10.
bool same(const std::string& text, const std::string& expected) {
    const Model a = read_csg(text);
    const Model b = read_csg(expected);
    Random random(5);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
        Vec3 p{};
        for (double& x : p) x = 11 * random.uniform() - 1;
        const std::size_t found = region_at(a, p);
        if (found != region_at(b, p)) return false;
        inside += static_cast<int>(found);
    }
    return inside > 0;
}

const char* const kEmptySolids[] = {
    "cube(size = 0);",
    "cube(size = [1, 0, 1]);",
    "cube(size = [1, -1, 1]);",
    "cube(size = [inf, 1, 1]);",
    "cube(size = nan);",
    "sphere(r = 0);",
    "sphere(r = -1);",
    "sphere(d = -inf);",
    "cylinder(h = 0);",
    "cylinder(h = -2);",
    "cylinder(h = inf);",
    "cylinder(h = 1, r1 = 0, r2 = 0);",
    "cylinder(h = 1, r1 = -1, r2 = 1);",
    "cylinder(h = 1, r1 = 1, r2 = nan);",
    "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]) { cube(); }",
    "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,nan,0],[0,0,0,1]]) { cube(); }",
    "multmatrix([[1,0,0,inf],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube(); }",
    "linear_extrude(height = 0) { square(); }",
    "linear_extrude(height = -1) { square(); }",
    "linear_extrude(height = 1) { square(size = [0, 1]); }",
    "rotate_extrude(angle = 0) { square(); }",
};

const char* const kEmptyShapes[] = {
    "square(size = [0, 9]);",
    "square(size = [inf, 1]);",
    "square(size = -1);",
    "circle(r = 0);",
    "circle(d = nan);",
    "text(text = \"a\", size = 0);",
    "multmatrix([[0,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { square(9); }",
};

}  // namespace

TEST_CASE("solids without size count as empty") {
    const std::string cube = "cube(size = 5);";
    for (const std::string empty : kEmptySolids) {
        CAPTURE(empty);
        CHECK(same(cube + empty, cube));
        CHECK(same("union() {" + empty + cube + "}", cube));
        CHECK(same("difference() {" + cube + empty + "}", cube));
        CHECK(same(cube + "difference() {" + empty + "cube(size = 9); }", cube));
        CHECK(same(cube + "intersection() { cube(size = 9);" + empty + "}", cube));
        CHECK(same(cube + "intersection() {" + empty + "cube(size = 9); }", cube));
        CHECK(same(cube + "%" + empty, cube));
        const Model model = read_csg(cube + empty);
        REQUIRE(model.warnings.size() == 1);
        CHECK(model.warnings[0].find("part.csg:1:") == 0);
        CHECK(model.warnings[0].find("an object of size 0, negative, infinite") != std::string::npos);
        CHECK(read_csg(cube + "*" + empty).warnings.empty());
        CHECK(refusal(empty, "csg").find("the file holds no solid: an object of size 0") !=
              std::string::npos);
    }
}

TEST_CASE("plane shapes without size count as empty") {
    const std::string square = "square(size = 5);";
    const std::string plate = "linear_extrude(height = 5) {" + square + "}";
    for (const std::string empty : kEmptyShapes) {
        CAPTURE(empty);
        CHECK(same("linear_extrude(height = 5) {" + square + empty + "}", plate));
        CHECK(same("linear_extrude(height = 5) { difference() {" + square + empty + "} }", plate));
        CHECK(same("linear_extrude(height = 5) { hull() {" + square + empty + "} }", plate));
        CHECK(
            same(plate + "linear_extrude(height = 9) { intersection() { square(9);" + empty + "} }", plate));
        CHECK(same(plate + "linear_extrude(height = 9) { minkowski() { square(9);" + empty + "} }", plate));
        CHECK(same(plate + "linear_extrude(height = 9) { offset(1) {" + empty + "} }", plate));
        CHECK(same(plate + "linear_extrude(height = 9) {" + empty + "}", plate));
    }
}

TEST_CASE("hulls, sums and resizing without an empty child") {
    const std::string cube = "cube(size = 5);";
    CHECK(same("hull() { cube(size = 5); cube(size = [0, 9, 9]); }", cube));
    CHECK(same("minkowski() { cube(size = 5); cube(size = [0, 9, 9]); }", cube));
    CHECK(same("minkowski() { cube(size = [0, 9, 9]); cube(size = 5); }", cube));
    CHECK(same(cube + "hull() { sphere(r = 0); }", cube));
    CHECK(same(cube + "resize(newsize = [9, 9, 9]) { cube(size = 0); }", cube));
    // OpenSCAD keeps the points of a flattened solid there.
    const std::string flat = "multmatrix([[1,0,0,9],[0,1,0,0],[0,0,0,0],[0,0,0,1]]) { cube(); }";
    CHECK(refusal("hull() {" + cube + flat + "}", "csg").find("it flattens the solid") != std::string::npos);
    CHECK(refusal("minkowski() {" + cube + flat + "}", "csg").find("singular") != std::string::npos);
    CHECK(refusal("linear_extrude(height = 1) { projection() { union() {" + flat + "} } }", "csg")
              .find("singular") != std::string::npos);
    CHECK(same("hull() {" + cube + "}" + flat, cube));
    CHECK(same("linear_extrude(height = 5) { projection() {" + cube + "} }" + flat, cube));
}

TEST_CASE("one warning a file counts what is left out and names the first") {
    const Model model = read_csg("cube();\n sphere(r = 0);\ncube(size = [1, 0, 1]);\nsphere(r = -1);");
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0] ==
          "part.csg:2:13: 3 objects of size 0, negative, infinite or flattened by a matrix are left out, the "
          "first: 'sphere' with radius 0");
    CHECK(read_csg("cube();").warnings.empty());
    CHECK(refusal("\ncube(0);\n cube(-1);", "csg") ==
          "2 m.csg:2:6: the file holds no solid: 2 objects of size 0, negative, infinite or flattened by a "
          "matrix are left out, the first: 'cube' with size 0");
    // The root modifier makes all else no part of the model.
    CHECK(read_csg("cube(0); !cube();").warnings.empty());
}

TEST_CASE("a number of fragments that is not finite is 3, as in OpenSCAD") {
    CHECK(same("cylinder($fn = inf, h = 5, r = 5);", "cylinder($fn = 3, h = 5, r = 5);"));
    CHECK(same("sphere($fn = nan, r = 5);", "sphere($fn = 3, r = 5);"));
}

TEST_CASE("text in a font whose name cannot be read is left out") {
    const Model model = read_csg(
        "cube();\nlinear_extrude(height = 1) { text(text = \"a\", font = \":charset=xxx\");\n"
        "text(text = \"b\", font = \":charset=xxx\"); }");
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0].find("part.csg:2:30: the font ':charset=xxx' is not of the form") == 0);
    CHECK(region_at(model, {0.5, 0.5, 0.5}) == 1);
    CHECK(region_at(model, {3, 3, 0.5}) == 0);
}

TEST_CASE("each warning is told once a file, with its first place") {
    const auto warnings = [](const std::string& text) {
        std::string all;
        for (int i = 0; i < 20; ++i) all += text;
        return parse_model(all, "csg", "m.csg").warnings;
    };
    for (const char* text :
         {"hull() { cube(size = 1); square(size = 1); }", "minkowski() { cube(size = 1); square(size = 1); }",
          "cube(size = 1); polyhedron(points = [], faces = []);", "cube(size = 1); square(size = 1);",
          "linear_extrude(height = 1) { square(size = 1); polygon(points = [[0, 0], [1, 1]]); }"}) {
        CAPTURE(text);
        const auto told = warnings(text);
        REQUIRE(told.size() == 1);
        CHECK(told[0].find("m.csg:1:") == 0);
    }
}
