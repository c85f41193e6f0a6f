// resize() of solids.
#include <doctest/doctest.h>

#include "host/common/random.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;
using test::refusal;
using test::region_at;

TEST_CASE("resized solids: the size before must be known exactly") {
    struct Case {
        const char* child;
        Vec3 low, high;  ///< before
    };
    const std::string turned = "multmatrix([[0.6,-0.8,0,1],[0.8,0.6,0,0],[0,0,1,0],[0,0,0,1]]) { ";
    const Case cases[] = {
        {"cube(size = [1, 2, 3]);", {0, 0, 0}, {1, 2, 3}},
        {"sphere(r = 2);", {-2, -2, -2}, {2, 2, 2}},
        {"cylinder($fn = 4, h = 4, r1 = 3, r2 = 2, center = true);", {-3, -3, -2}, {3, 3, 2}},
        {"cylinder(h = 4, r1 = 1, r2 = 2);", {-2, -2, 0}, {2, 2, 4}},
        {"cylinder(h = 4, r1 = 1, r2 = 0);", {-1, -1, 0}, {1, 1, 4}},
        {"multmatrix([[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]) { cylinder(h = 4, r = 1); }",
         {-1, -4, -1},
         {1, 0, 1}},
        {"sphere(r = 1); multmatrix([[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube(size = 2); }",
         {-1, -1, -1},
         {7, 2, 2}},
        {"linear_extrude(height = 2, scale = 2) { square(size = [1, 2]); }", {0, 0, 0}, {2, 4, 2}},
        {"linear_extrude(height = 2) { circle(r = 3); }", {-3, -3, 0}, {3, 3, 2}},
    };
    const double grow = 1.5;
    for (const Case& c : cases) {
        std::string text = "resize(newsize = [";
        for (std::size_t k = 0; k < 3; ++k) {
            text += (k > 0 ? "," : "") + std::to_string(grow * (c.high[k] - c.low[k]));
        }
        const Model plain = read_csg(c.child);
        const Model resized = read_csg(text + "], auto = [0,0,0], convexity = 0) { " + c.child + " }");
        CAPTURE(std::string(c.child));
        Random random(3);
        for (int i = 0; i < 500; ++i) {
            Vec3 p{};
            Vec3 q{};
            for (std::size_t k = 0; k < 3; ++k) {
                p[k] = c.low[k] - 0.5 + (c.high[k] - c.low[k] + 1) * random.uniform();
                q[k] = grow * p[k];
            }
            CHECK(region_at(plain, p) == region_at(resized, q));
        }
    }
    // A turned square's width; and automatic scaling.
    const std::string wide =
        "resize(newsize = [2.8,0,0], auto = [true,true,true]) { " + turned + "cube(); } }";
    CHECK(region_at(read_csg(wide), {2 * (1 + 0.6 * 0.5 - 0.8 * 0.5), 2 * 0.7, 1.9}) == 1);
    CHECK(refusal("resize(newsize = [1,1,1]) { difference() { cube(); sphere(); } }", "csg")
              .find("'resize' is not supported yet") != std::string::npos);
}

TEST_CASE("resize of a polyhedron with hundreds of faces takes no time that anybody sees") {
    const Model model =
        read_csg("resize(newsize = [24, 0, 6]) { sphere($fn = 60, r = 10); }", Facets::kExact);
    CHECK(region_at(model, {11.9999, 0, 0.1}) == 1);
    CHECK(region_at(model, {12.0001, 0, 0.1}) == 0);
    const double ring = 9.98629534;  // 10 sin 87°, a corner's: y stays as it is
    CHECK(region_at(model, {0, ring - 1e-4, 0.1}) == 1);
    CHECK(region_at(model, {0, ring + 1e-4, 0.1}) == 0);
    CHECK(region_at(model, {0, 0, 2.9999}) == 1);
    CHECK(region_at(model, {0, 0, 3.0001}) == 0);
}

TEST_CASE("resize of solids with flat faces, whatever their tree") {
    // What is left of the cube reaches from 1 to 4 along x, 0 to 4 along y and 0 to 3 along z.
    const std::string rest =
        "intersection() { difference() { cube(4); multmatrix([[1,0,0,-8],[0,1,0,-1],[0,0,1,-1],[0,0,0,1]]) { "
        "cube(9); } } multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,-6],[0,0,0,1]]) { cube(9); } }";
    const Model model = read_csg("resize(newsize = [6, 2, 0]) { " + rest + " }");
    CHECK(region_at(model, {2.01, 0.01, 0.01}) == 1);
    CHECK(region_at(model, {7.99, 1.99, 2.99}) == 1);
    CHECK(region_at(model, {1.99, 1, 1}) == 0);
    CHECK(region_at(model, {8.01, 1, 1}) == 0);
    CHECK(region_at(model, {5, 2.01, 1}) == 0);
    CHECK(region_at(model, {5, 1, 3.01}) == 0);
    const Model tall = read_csg("resize(newsize = [0, 0, 9], auto = true) { " + rest + " }");
    CHECK(region_at(tall, {3.01, 11.99, 8.99}) == 1);
    CHECK(region_at(tall, {11.99, 0.01, 0.01}) == 1);
    CHECK(region_at(tall, {12.01, 1, 1}) == 0);
    CHECK(refusal("resize(newsize = [1, 0, 0]) { difference() { sphere(2); cube(1); } }", "csg")
              .find("anything with flat faces") != std::string::npos);
}

TEST_CASE("resize to no size keeps any solid") {
    const std::string ball = "difference() { sphere(r = 2); cube(9, center = false); }";
    const Model model = read_csg("resize(newsize = [0, 0, 0], auto = [0, 0, 0]) { " + ball + " }");
    CHECK(region_at(model, {-1, -1, -1}) == 1);
    CHECK(region_at(model, {1, 1, 1}) == 0);
    CHECK(refusal("resize(newsize = [1, 0, 0]) { " + ball + " }", "csg").find("exact size is not known") !=
          std::string::npos);
}
