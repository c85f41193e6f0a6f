// The .csg reader: semantics.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;
using test::region_at;

namespace {

bool inside(const std::string& text, const Vec3& point) { return region_at(read_csg(text), point) == 1; }

/// Volume by counting the centers of an n³ grid over [-h, h]³.
double sampled_volume(const Model& model, double h, int n) {
    std::size_t count = 0;
    const double step = 2 * h / n;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
                count +=
                    region_at(model, {-h + (i + 0.5) * step, -h + (j + 0.5) * step, -h + (k + 0.5) * step});
            }
        }
    }
    return static_cast<double>(count) * step * step * step;
}

}  // namespace

TEST_CASE("cubes, centered or not, in both writer styles") {
    CHECK(inside("cube(size = [1, 2, 3], center = false);", {0.9, 1.9, 2.9}));
    CHECK_FALSE(inside("cube(size = [1, 2, 3], center = false);", {-0.1, 1, 1}));
    CHECK(inside("cube(size = [1, 2, 3], center = true);", {-0.4, -0.9, -1.4}));
    CHECK_FALSE(inside("cube(size = [1, 2, 3], center = true);", {0.6, 0, 0}));
    CHECK(inside("cube();", {0.9, 0.9, 0.9}));
    CHECK(inside("cube(size = 2);", {1.9, 1.9, 1.9}));
    CHECK(inside("cube([1, 1, 4], true);", {0.4, 0.4, -1.9}));
    const Model model = read_csg("\n cube(size = [1, 1, 1]);");
    CHECK(model.regions.size() == 1);
    CHECK(model.regions[0].name == "part");
    CHECK(model.source == "part.csg");
    CHECK_FALSE(model.clip);
    CHECK(model.nodes[0].name == "cube1");
    CHECK(model.nodes[0].where.line == 2);
    CHECK(model.nodes[0].where.column == 2);
}

TEST_CASE("spheres and cylinders are curved unless $fn asks for a prism") {
    CHECK(inside("sphere($fn = 0, $fa = 12, $fs = 2, r = 2);", {1.99, 0, 0}));
    CHECK(inside("sphere();", {0, 0, 0.99}));
    CHECK(inside("sphere(d = 4);", {0, 1.99, 0}));
    // The middle of a side tells a circle from a polygon.
    const std::string tail = ", $fa = 12, $fs = 2, h = 2, r1 = 1, r2 = 1, center = true);";
    for (const int n : {3, 4, 5, 6, 8, 12}) {
        CAPTURE(n);
        const double angle = 3.14159265358979323846 / n;
        const std::string text = "cylinder($fn = " + std::to_string(n) + tail;
        const double apothem = std::cos(angle);
        const auto at = [&](double r) { return Vec3{r * std::cos(angle), r * std::sin(angle), 0.5}; };
        CHECK(inside(text, at(apothem - 1e-6)));
        CHECK_FALSE(inside(text, at(apothem + 1e-6)));
        CHECK(inside(text, {0.999, 0, 0.999}));
        CHECK_FALSE(inside(text, {1.001, 0, 0}));
        CHECK_FALSE(inside(text, {0, 0, 1.001}));
        CHECK(read_csg(text).nodes[0].primitive.planes.size() == static_cast<std::size_t>(n) + 2);
    }
    for (const char* n : {"0", "12.5", "13", "100"}) {
        CAPTURE(n);
        CHECK(inside(std::string("cylinder($fn = ") + n + tail,
                     {0.999 * std::cos(0.26), 0.999 * std::sin(0.26), 0}));
    }
    // Fewer than three fragments make three; a fraction is rounded up.
    CHECK(read_csg("cylinder($fn = 1);").nodes[0].primitive.planes.size() == 5);
    CHECK(read_csg("cylinder($fn = 5.5);").nodes[0].primitive.planes.size() == 8);
}

TEST_CASE("cylinders: cones, frustums, pyramids and their caps") {
    const std::string cone = "cylinder(h = 4, r1 = 2, r2 = 1, center = true);";
    CHECK(inside(cone, {1.7, 0, -1}));
    CHECK_FALSE(inside(cone, {1.8, 0, -1}));
    CHECK_FALSE(inside(cone, {0, 0, 2.1}));
    CHECK_FALSE(inside(cone, {0, 0, -2.1}));
    // Pointed cones: apex above, and apex below but turned over.
    for (const char* text : {"cylinder(h = 4, r1 = 2, r2 = 0, center = false);",
                             "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,-1,4],[0,0,0,1]]) { "
                             "cylinder(h = 4, r1 = 0, r2 = 2, center = false); }"}) {
        CAPTURE(text);
        CHECK(inside(text, {0.4, 0, 3}));
        CHECK_FALSE(inside(text, {0.6, 0, 3}));
        CHECK_FALSE(inside(text, {0, 0, 4.1}));
        CHECK_FALSE(inside(text, {0, 0, -0.1}));
    }
    CHECK(inside("cylinder(h = 2, r = 3);", {2.9, 0, 1.9}));
    CHECK(inside("cylinder(h = 2, d1 = 2, d2 = 6);", {1.9, 0, 1.1}));
    CHECK(inside("cylinder(2, 1, 3, true);", {1.9, 0, 0}));
    // A square pyramid and frustum; vertex 0 on +x.
    const std::string pyramid = "cylinder($fn = 4, h = 2, r1 = 1, r2 = 0);";
    CHECK(read_csg(pyramid).nodes[0].primitive.planes.size() == 5);
    CHECK(inside(pyramid, {0.49, 0, 1}));
    CHECK(inside(pyramid, {0.24, 0.24, 1}));
    CHECK_FALSE(inside(pyramid, {0.26, 0.26, 1}));
    CHECK_FALSE(inside(pyramid, {0, 0, 2.01}));
    const std::string frustum = "cylinder($fn = 4, h = 2, r1 = 1, r2 = 3, center = true);";
    CHECK(inside(frustum, {0.99, 0.99, 0}));
    CHECK_FALSE(inside(frustum, {1.01, 1.01, 0}));
    CHECK(inside(frustum, {2.9, 0, 0.99}));
    CHECK_FALSE(inside(frustum, {0, 0, 1.01}));

    const Model model = read_csg("cylinder(h = 1, r1 = 1, r2 = 1);");
    const CsgNode& top = model.nodes[model.regions[0].root];
    CHECK(top.name == "cylinder1");
    CHECK(top.op == CsgNode::Op::kIntersection);
    CHECK(model.nodes[top.children[1]].primitive.planes[0].name == "zmin");
    CHECK(model.nodes[top.children[1]].primitive.planes[1].name == "zmax");
}

TEST_CASE("a sphere with few fragments is OpenSCAD's polyhedron") {
    // n = 4: rings at polar angles 45° and 135°: a square prism of radius and half height r/sqrt(2).
    const std::string four = "sphere($fn = 4, r = 2);";
    CHECK(inside(four, {1.41, 0, 1.41}));
    CHECK_FALSE(inside(four, {1.42, 0, 0}));
    CHECK_FALSE(inside(four, {0, 0, 1.42}));
    // n = 8: 4 rings; volume of the polyhedron from its rings: frustums of regular octagons.
    for (const int n : {5, 6, 8, 11, 12}) {
        CAPTURE(n);
        const int rings = (n + 1) / 2;
        const double pi = 3.14159265358979323846;
        double volume = 0;
        for (int i = 0; i + 1 < rings; ++i) {
            const double a = pi * (i + 0.5) / rings;
            const double b = pi * (i + 1.5) / rings;
            const double ra = std::sin(a);
            const double rb = std::sin(b);
            volume += (std::cos(a) - std::cos(b)) * (ra * ra + ra * rb + rb * rb) / 3;
        }
        volume *= n * std::sin(2 * pi / n) / 2;
        const Model model = read_csg("sphere($fn = " + std::to_string(n) + ", r = 1);");
        CHECK(sampled_volume(model, 1, 40) == doctest::Approx(volume).epsilon(0.02));
    }
}

TEST_CASE("operations, groups and the implicit union") {
    CHECK(
        inside("cube(); multmatrix([[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube(); }", {5.5, 0.5, 0.5}));
    const std::string hollow =
        "difference() { cube(size = 4, center = true); sphere(r = 1); cube(size = 9); }";
    CHECK(inside(hollow, {-1.5, -1.5, -1.5}));
    CHECK_FALSE(inside(hollow, {-0.5, 0, 0}));
    CHECK_FALSE(inside(hollow, {1.5, 1.5, 1.5}));
    CHECK(inside("intersection() { cube(); sphere(r = 1); }", {0.5, 0.5, 0.5}));
    CHECK_FALSE(inside("intersection() { cube(); sphere(r = 1); }", {0.9, 0.9, 0.9}));
    CHECK(inside("color([1, 0, 0, 1]) { render(convexity = 2) { group() { union() { cube(); } } } }",
                 {0.5, 0.5, 0.5}));
    // A matrix applies to the union of its children.
    CHECK(inside("multmatrix([[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { sphere(); cube(size = 2); }",
                 {6.9, 1.9, 1.9}));
    // A mirror and a rotation by 90° about z.
    CHECK(inside("multmatrix([[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube(); }", {-0.5, 0.5, 0.5}));
    CHECK(inside("multmatrix([[0,-1,0,0],[1,0,0,0],[0,0,1,0],[0,0,0,1]]) { cube(size = [3,1,1]); }",
                 {-0.5, 2.5, 0.5}));
}

TEST_CASE("empty children are neutral or annihilate") {
    for (const char* empty : {"group();", "union() { group() { } }", "intersection();",
                              "multmatrix([[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]);"}) {
        CAPTURE(empty);
        const std::string e = empty;
        CHECK(inside(e + "cube();", {0.5, 0.5, 0.5}));
        CHECK(inside("difference() { cube(); " + e + "}", {0.5, 0.5, 0.5}));
        CHECK_FALSE(inside("difference() { " + e + " cube(size = 9, center = true); sphere(); }", {2, 2, 2}));
        CHECK_FALSE(inside("intersection() { cube(); " + e + "}", {0.5, 0.5, 0.5}));
        CHECK_FALSE(inside(e, {0.5, 0.5, 0.5}));
    }
}

TEST_CASE("modifiers: % and * remove, # keeps, ! makes the root") {
    CHECK_FALSE(inside("sphere(); %cube(size = 3);", {2, 2, 2}));
    CHECK_FALSE(inside("sphere(); %#cube(size = 3);", {2, 2, 2}));
    CHECK_FALSE(inside("sphere(); * cube(size = 3);", {2, 2, 2}));
    CHECK(inside("sphere(); #cube(size = 3);", {2, 2, 2}));
    // A removed first child does not count as the minuend.
    CHECK(inside("difference() { %cube(size = 9); sphere(); }", {0.5, 0, 0}));
    // Removed nodes need no support, nor valid sizes.
    CHECK(inside("cube(); %hull() { text(text = \"a;}\"); cube(size = 0); } *import(file = \"x.stl\");",
                 {0.5, 0.5, 0.5}));
    // ! drops all around it, its transforms included.
    const std::string root =
        "minkowski() { cube(); multmatrix([[1,0,0,9],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { !group() { sphere(); "
        "%cube(size = 3); } cube(); } } cube(size = 9);";
    CHECK(inside(root, {0, 0, 0.9}));
    CHECK_FALSE(inside(root, {2, 2, 2}));
    CHECK_FALSE(inside(root, {9, 0, 0}));
    const Model two = read_csg("!sphere(); !cube(size = 9); %!cube(size = 20);");
    CHECK(region_at(two, {2, 2, 2}) == 0);
    CHECK(two.warnings.size() == 1);
    // A '!' inside a string is no modifier.
    CHECK(inside("cube(); %text(text = \"!\");", {0.5, 0.5, 0.5}));
}

TEST_CASE("comments, blanks, empty statements and a byte order mark are accepted") {
    CHECK(inside("\xEF\xBB\xBF// comment\n/* more\n */ cube ( size = [ 1 , 1,1 ] , center=false ) ;;\r\n",
                 {0.5, 0.5, 0.5}));
    CHECK(inside("cube(size = [1e0, .5, 1E+0]); // end", {0.5, 0.4, 0.5}));
}

TEST_CASE("nesting is limited by memory only") {
    constexpr int kDepth = 100000;
    std::string text;
    for (int k = 0; k < kDepth; ++k) text += k % 2 == 0 ? "group(){" : "difference(){";
    text += "cube();";
    text += std::string(kDepth, '}');
    CHECK(inside(text, {0.5, 0.5, 0.5}));

    std::string shifts;
    for (int k = 0; k < kDepth; ++k)
        shifts += "multmatrix([[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]){sphere();";
    shifts += std::string(kDepth, '}');
    CHECK(read_csg(shifts).nodes.size() > 2 * kDepth);

    // Boxes in a row are merged.
    std::string boxes;
    for (int k = 0; k < kDepth; ++k) boxes += "multmatrix([[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]){cube();";
    boxes += std::string(kDepth, '}');
    CHECK(inside(boxes, {kDepth + 0.5, 0.5, 0.5}));
    CHECK_FALSE(inside(boxes, {kDepth + 1.5, 0.5, 0.5}));

    // The same for lists of arguments.
    const std::string list = "color(" + std::string(kDepth, '[') + std::string(kDepth, ']') + ") { cube(); }";
    CHECK(inside(list, {0.5, 0.5, 0.5}));
}
