// projection() of .csg files: sections against the membership of the solid in the plane, shadows against
// rays.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "host/common/constants.hpp"
#include "host/common/random.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/section.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;
using test::refusal;
using test::region_at;

namespace {

using Flat = std::function<bool(double, double)>;

std::string projected(const std::string& child, bool cut) {
    return "linear_extrude(height = 2, center = true) { projection(cut = " +
           std::string(cut ? "true" : "false") + ", convexity = 0) { " + child + " } }";
}

/// Points of the square of that half width where the shape and the oracle differ, of 4000; and how many are
/// inside.
struct Difference {
    int wrong = 0;
    int inside = 0;
};
Difference compare(const Model& shape, double reach, const Flat& oracle) {
    Random random(11);
    Difference result;
    for (int i = 0; i < 4000; ++i) {
        const double x = reach * (2 * random.uniform() - 1);
        const double y = reach * (2 * random.uniform() - 1);
        const bool expected = oracle(x, y);
        const bool found = region_at(shape, {x, y, 0.3}) == 1;
        result.inside += expected ? 1 : 0;
        result.wrong += found != expected ? 1 : 0;
    }
    return result;
}

/// The section is the solid at z = 0. `most`: points in 4000 that may differ, where curves are facetted.
void check_section(const std::string& child, double reach, int most = 0, Facets facets = Facets::kSmooth) {
    CAPTURE(child);
    const Model solid = read_csg(child, facets);
    const Model shape = read_csg(projected(child, true), facets);
    const Difference result = compare(shape, reach, [&](double x, double y) {
        return region_at(solid, {x, y, 0}) == 1;
    });
    CHECK(result.wrong <= most);
    CHECK(result.inside > 40);
    CHECK(result.inside < 3900);
}

/// The shadow is where rays along z meet the solid. Rays of 400 points may miss what is thinner.
void check_shadow(const std::string& child, double reach, int most = 0, Facets facets = Facets::kSmooth) {
    CAPTURE(child);
    const Model solid = read_csg(child, facets);
    const Model shape = read_csg(projected(child, false), facets);
    const Difference result = compare(shape, reach, [&](double x, double y) {
        for (int i = 0; i < 400; ++i) {
            if (region_at(solid, {x, y, reach * (i + 0.37 - 200) / 200}) == 1) return true;
        }
        return false;
    });
    CHECK(result.wrong <= most);
    CHECK(result.inside > 40);
    CHECK(result.inside < 3900);
}

void check_shape(const std::string& child, bool cut, double reach, const Flat& oracle) {
    CAPTURE(child);
    const Difference result = compare(read_csg(projected(child, cut)), reach, oracle);
    CHECK(result.wrong == 0);
}

std::string moved(double x, double y, double z, const std::string& child) {
    const auto text = [](double value) { return std::to_string(value); };
    return "multmatrix([[1, 0, 0, " + text(x) + "], [0, 1, 0, " + text(y) + "], [0, 0, 1, " + text(z) +
           "], [0, 0, 0, 1]]) { " + child + " }";
}

/// About x, by degrees.
std::string tilted(double degrees, const std::string& child) {
    const std::string c = std::to_string(std::cos(degrees * kPi / 180));
    const std::string s = std::to_string(std::sin(degrees * kPi / 180));
    const std::string minus = std::to_string(-std::sin(degrees * kPi / 180));
    return "multmatrix([[1, 0, 0, 0], [0, " + c + ", " + minus + ", 0], [0, " + s + ", " + c +
           ", 0], [0, 0, 0, 1]]) { " + child + " }";
}

std::string skewed(const std::string& child) {
    return "multmatrix([[1.2, 0.3, -0.2, 0.1], [-0.4, 0.9, 0.5, -0.2], [0.3, -0.6, 1.1, 0.15], [0, 0, 0, "
           "1]]) "
           "{ " +
           child + " }";
}

const std::string kTetrahedron =
    "polyhedron(points = [[-1, -1, -1], [3, -1, -1], [-1, 3, -1], [-1, -1, 3]], faces = [[0, 1, 2], [0, 3, "
    "1], [0, 2, 3], [1, 3, 2]]);";
const std::string kDrilled =
    "difference() { cube(size = [6, 4, 4], center = true); cylinder($fn = 0, $fa = 12, $fs = 2, h = 9, r1 = "
    "1, r2 = 1, center = true); multmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { "
    "cylinder($fn = 0, $fa = 12, $fs = 2, h = 9, r1 = 0.7, r2 = 0.7, center = true); } }";

}  // namespace

TEST_CASE("projection: sections of the primitives are exact") {
    for (const std::string& solid :
         {std::string("cube(size = [3, 2, 4], center = true);"), std::string("sphere(r = 2);"),
          std::string("sphere($fn = 8, r = 2);"),
          std::string("cylinder(h = 4, r1 = 1.5, r2 = 1.5, center = true);"),
          std::string("cylinder(h = 4, r1 = 2, r2 = 1, center = true);"),
          std::string("cylinder(h = 4, r1 = 0, r2 = 1.7, center = true);"),
          std::string("cylinder($fn = 6, h = 4, r1 = 2, r2 = 1, center = true);"), kTetrahedron, kDrilled}) {
        check_section(solid, 4);
        check_section(moved(0.3, -0.4, 0.5, solid), 4);
        check_section(tilted(20, solid), 4);
        check_section(skewed(solid), 4);
        check_section(skewed(solid), 4, 0, Facets::kExact);
    }
    const std::string cylinder = "cylinder(h = 4, r1 = 1.5, r2 = 1.5, center = true);";
    check_section(tilted(90, cylinder), 4);
    check_section(moved(0, 0, 1, tilted(90, cylinder)), 4);
    check_section(moved(1000, 2000, 0.1, "sphere(r = 2000);"), 4000);
}

TEST_CASE("projection: sections of cones along parabolas and hyperbolas") {
    // Half angle 45 degrees.
    const std::string cone = "cylinder(h = 4, r1 = 4, r2 = 0, center = true);";
    check_section(tilted(45, cone), 5, 8);
    check_section(moved(0, 0, 1, tilted(45, cone)), 5, 8);
    check_section(moved(0, 0, 0.5, tilted(70, cone)), 5, 8);
    check_section(moved(0, 0, 0.7, tilted(90, cone)), 5, 8);
    check_section(tilted(90, cone), 5, 8);  // through the axis
    check_section(moved(0.2, 0.3, -0.4, tilted(80, "cylinder(h = 4, r1 = 2, r2 = 1, center = true);")), 4, 8);
}

TEST_CASE("projection: sections of tori, extrusions, hulls and trees") {
    const std::string ring =
        "rotate_extrude($fn = 0, $fa = 12, $fs = 2) { multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], "
        "[0, 0, 0, 1]]) { circle($fn = 0, $fa = 12, $fs = 2, r = 1); } }";
    check_section(ring, 5);
    check_section(moved(0, 0, 0.4, ring), 5);
    check_section(tilted(90, ring), 5);
    const std::string l = "polygon(points = [[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]]);";
    check_section(moved(-1, -1, -1, "linear_extrude(height = 3) { " + l + " }"), 5);
    check_section(tilted(-30, "linear_extrude(height = 3, scale = 0.5) { " + l + " }"), 5);
    check_section(tilted(30, "rotate_extrude(angle = 200) { " + l + " }"), 5, 8);
    check_section(moved(0, 0, -0.5, "rotate_extrude() { " + l + " }"), 5);
    check_section(tilted(25,
                         "hull() { sphere(r = 1); multmatrix([[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 1], "
                         "[0, 0, 0, 1]]) { cube(1); } }"),
                  4, 8);
    check_section("union() { sphere(r = 1); " + moved(1, 1, 0.2, kDrilled) + " }", 5);
    check_section("intersection() { sphere(r = 2); " + tilted(30, "cube(size = 3, center = true);") + " }",
                  4);
    check_section(
        "difference() { sphere(r = 3); union() { sphere(r = 2); cube([8, 4, 4], center = true); } }", 4);
    // Shells one in the other, and two that overlap: what is inside counts, not how often.
    check_section(
        "polyhedron(points = "
        "[[-2,-2,-2],[2,-2,-2],[0,2,-2],[0,0,2],[-1.5,-2.5,-2],[2.5,-2.5,-2],[0.5,1.5,-2],"
        "[0.5,-0.5,2]], faces = [[0,1,2],[0,3,1],[1,3,2],[2,3,0],[4,5,6],[4,7,5],[5,7,6],[6,7,4]]);",
        4);
}

TEST_CASE("projection: a face in the plane belongs to the section") {
    const auto in_square = [](double x, double y) { return x > 0 && x < 3 && y > 0 && y < 3; };
    for (const std::string& solid : {std::string("cube(3);"), moved(0, 0, -3, "cube(3);"),
                                     tilted(0, "union() { cube(3); " + moved(1, 1, -1, "cube(1);") + " }")}) {
        check_shape(solid, true, 4, in_square);
    }
    // The pocket ends in the plane: below it the solid is whole.
    check_shape("difference() { " + moved(0, 0, -1, "cube(3);") + moved(1, 1, 0, "cube([1, 1, 9]);") + " }",
                true, 4, in_square);
    // A polyhedron's bottom.
    check_shape(moved(1, 1, 1, kTetrahedron), true, 5,
                [](double x, double y) { return x > 0 && y > 0 && x + y < 4; });
    // What only touches has no section.
    const Model touching = read_csg(projected(moved(0, 0, 2, "sphere(r = 2);"), true));
    CHECK(compare(touching, 3, [](double, double) { return false; }).wrong == 0);
}

TEST_CASE("projection: a section takes part in everything that shapes do") {
    const std::string disc = "projection(cut = true) { " + moved(0, 0, 1, "sphere(r = 2);") + " }";
    const double radius = std::sqrt(3.0);
    const Model ring = read_csg(
        "rotate_extrude() { multmatrix([[1, 0, 0, 4], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, "
        "0, 1]]) { " +
        disc + " } }");
    CHECK(region_at(ring, {4 + 0.99 * radius, 0, 0}) == 1);
    CHECK(region_at(ring, {4 + 1.01 * radius, 0, 0}) == 0);
    const Model grown = read_csg("linear_extrude(height = 1) { offset(r = 1) { " + disc + " } }");
    CHECK(region_at(grown, {radius + 0.98, 0, 0.5}) == 1);
    CHECK(region_at(grown, {radius + 1.01, 0, 0.5}) == 0);
    const Model scaled = read_csg(
        "linear_extrude(height = 1, scale = 2) { projection(cut = true) { cube([4, 2, "
        "2], center = true); } }");
    CHECK(region_at(scaled, {3.9, 1.9, 0.999}) == 1);
    CHECK(region_at(scaled, {2.1, 0.9, 0.001}) == 0);
}

TEST_CASE("projection: shadows") {
    check_shadow("cube(size = [3, 2, 4], center = true);", 4);
    check_shadow(skewed("cube(size = [3, 2, 4], center = true);"), 4, 4);
    check_shadow("sphere(r = 2);", 4);
    check_shadow(skewed("sphere(r = 1.5);"), 4, 4);
    const std::string cone = "cylinder(h = 4, r1 = 2, r2 = 1, center = true);";
    check_shadow(cone, 4, 8);
    check_shadow(tilted(35, cone), 4, 12);
    check_shadow(tilted(90, cone), 4, 8);
    check_shadow(tilted(60, kTetrahedron), 5, 12);
    check_shadow("multmatrix([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { " +
                     tilted(60, kTetrahedron) + " }",
                 5, 12);
    check_shadow("union() { sphere(r = 1); " + moved(1.5, 1, 3, "cube(1);") + " }", 4);
    check_shadow("hull() { cube(1); " + moved(1.5, 1, 2, "cube(1.5);") + " }", 4, 8);
    // A ball's hull with a point: two tangents.
    const Model cone_on_ball = read_csg(
        projected("hull() { sphere(r = 1); " + moved(2, 0, 5, "cube(1e-3, center = true);") + " }", false));
    CHECK(region_at(cone_on_ball, {0, 0.995, 0}) == 1);
    CHECK(region_at(cone_on_ball, {0, 1.001, 0}) == 0);
    CHECK(region_at(cone_on_ball, {1, 0.57, 0}) == 1);
    CHECK(region_at(cone_on_ball, {1, 0.58, 0}) == 0);
}

TEST_CASE("projection: shadows of upright solids and of what they cut") {
    // A plate with a hole, a pocket and a post beside it.
    const std::string plate = "difference() { cube([6, 6, 2]); " +
                              moved(1, 1, -1, "cylinder(h = 9, r = 0.7);") + moved(3, 3, 1, "cube(9);") +
                              " }" + moved(-2, -2, 5, "linear_extrude(height = 1) { circle(r = 1); }");
    check_shadow(plate, 7);
    check_shadow("difference() { sphere(r = 3); cylinder(h = 9, r = 1, center = true); }", 4);
    check_shadow(
        "difference() { union() { sphere(r = 2); difference() { sphere(r = 3); cube([9, 1, 9], "
        "center = true); } } cylinder(h = 9, r = 1, center = true); }",
        4);
    check_shadow("intersection() { sphere(r = 3); cylinder(h = 9, r = 2, center = true); }", 4);
    check_shadow("intersection() { " + tilted(20, "cube(size = 3, center = true);") +
                     " linear_extrude(height = 20, center = true) { square(2.4, center = true); } }",
                 4, 4);
    // Two pockets that overlap only in the shadow leave no hole.
    check_shape("difference() { cube([4, 4, 4]); " + moved(1, 1, -1, "cube([2, 2, 2]);") +
                    moved(1, 1, 3, "cube([2, 2, 2]);") + " }",
                false, 5, [](double x, double y) { return x > 0 && x < 4 && y > 0 && y < 4; });
}

TEST_CASE("projection: what is not supported, and what is left out") {
    const auto message = [](const std::string& child, bool cut) {
        return refusal(projected(child, cut), "csg");
    };
    const std::string ring =
        "rotate_extrude() { multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle(r "
        "= "
        "1); } }";
    CHECK(message(tilted(20, ring), true).find("a torus is cut askew") != std::string::npos);
    CHECK(message("implicit(\"x^2+y^2+z^2-1\");", true).find("a formula") != std::string::npos);
    CHECK(message("linear_extrude(height = 1, twist = 30, center = true) { square(1); }", true)
              .find("a formula, or an extrusion with twist") != std::string::npos);
    CHECK(message("implicit(\"x^2+y^2+z^2-1\");", false).find("a solid given by a formula") !=
          std::string::npos);
    CHECK(message("cube(1);", true).empty());
    CHECK(refusal("projection(cut = 3) { cube(1); }", "csg").find("neither true nor false") !=
          std::string::npos);
    CHECK(refusal("projection(cut = true, slice = 2) { cube(1); }", "csg").find("no argument 'slice'") !=
          std::string::npos);
    CHECK(refusal("projection(file = \"a.dxf\");", "csg").find("import()") != std::string::npos);
    CHECK(refusal("projection(cut = true) { cube(1); }", "csg").find("2D shapes only") != std::string::npos);
    const Model model = read_csg(projected("square(9); cube(1);", false));
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0].find("left out") != std::string::npos);
    CHECK(region_at(model, {5, 5, 0}) == 0);
    CHECK(region_at(model, {0.5, 0.5, 0}) == 1);
    // Nothing is neutral.
    CHECK(region_at(read_csg("cube(1); " + projected("", true) + projected(moved(0, 0, 9, "cube(1);"), true)),
                    {0.5, 0.5, 0.5}) == 1);
}

TEST_CASE("projection: deep trees") {
    std::string text;
    std::string end;
    for (int i = 0; i < 10000; ++i) {
        text += i % 3 == 0   ? "union() { "
                : i % 3 == 1 ? "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { "
                             : "difference() { ";
        end += " }";
    }
    for (const bool cut : {false, true}) {
        const Model model = read_csg(projected(text + "cube(2, center = true);" + end, cut));
        CHECK(region_at(model, {0.9, 0.9, 0}) == 1);
        CHECK(region_at(model, {1.1, 0.9, 0}) == 0);
    }
}

namespace {

/// The area of a shadow, with circles of that many sides where round parts are facetted.
double shadow_area(const std::string& child, int sides) {
    const Model solid = read_csg(child);
    model_reader::Fragments fragments;
    for (std::uint32_t i = 0; i < solid.nodes.size(); ++i) fragments[i] = sides;
    model_reader::FlatTree flat;
    const std::string source = "part.csg";
    const auto shape = model_reader::shadow(solid, solid.regions[0].root, fragments, flat,
                                            {"projection", source, SourceLocation{1, 1}});
    double area = 0;
    if (!shape) return area;
    for (const auto& loop : model_reader::to_contours(flat, *shape)) area += model_reader::signed_area(loop);
    return area;
}

}  // namespace

TEST_CASE("projection: shadows of any solid with flat faces, by areas") {
    const auto near = [](double value) { return doctest::Approx(value).epsilon(2e-6); };
    const std::string cube = "cube(size = 4, center = true);";
    const auto slab = [](double degrees, const std::string& child) { return tilted(degrees, child); };
    const auto hole = [&](double degrees, const std::string& tool) {
        return "difference() { " + cube + slab(degrees, tool) + " }";
    };
    // A tilted square hole through a cube: what the whole hole lets pass straight down.
    const std::string tool = "cube(size = [2, 2, 20], center = true);";
    CHECK(shadow_area(hole(0, tool), 0) == near(12));
    CHECK(shadow_area(hole(90, tool), 0) == near(16));
    for (const double degrees : {5.0, 10.0, 20.0, 30.0}) {
        CAPTURE(degrees);
        // The hole is 2/cos wide at each height and moves by 4 tan from top to bottom.
        const double turn = degrees * kPi / 180;
        const double open = std::max(0.0, 2 / std::cos(turn) - 4 * std::tan(turn));
        CHECK(shadow_area(hole(degrees, tool), 0) == near(16 - 2 * open));
    }
    // A box with a lid that hangs over a notch: the lid's shadow, under any skew that keeps z.
    const std::string notched =
        "difference() { cube([4, 4, 4]); " + moved(2, -1, -1, "cube([9, 9, 4]);") + " }";
    CHECK(shadow_area(notched, 0) == near(16));
    // Sheared along x by z: the lid, 4 wide, moves with z from 3 to 4, the leg below from 0 to 3.
    CHECK(shadow_area(
              "multmatrix([[1, 0, 1, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { " + notched + " }",
              0) == near(4 * 8));
    // Two walls with a slit between them, seen askew: nothing passes; and a wide one, where some does.
    const auto walls = [&](double slit) {
        return "multmatrix([[1, 0, 1, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { difference() { "
               "cube([9, 2, 2]); " +
               moved(4, -1, -1, "cube([" + std::to_string(slit) + ", 9, 9]);") + " } }";
    };
    CHECK(shadow_area(walls(1.5), 0) == near(2 * 11));
    CHECK(shadow_area(walls(2.5), 0) == near(2 * (11 - 0.5)));
    // Concave polyhedra in an intersection.
    CHECK(shadow_area("intersection() { " +
                          slab(30,
                               "linear_extrude(height = 30, center = true) { "
                               "polygon([[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]]); }") +
                          "multmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { " +
                          "linear_extrude(height = 30, center = true) { "
                          "polygon([[-1,-1],[1,-1],[1,1],[0,0],[-1,1]]); } } }",
                      0) > 1);
}

TEST_CASE("projection: shadows with OpenSCAD's facets have OpenSCAD's areas") {
    // Measured with OpenSCAD 2021.01, by the volume of linear_extrude(height = 1).
    const std::string along_y = "multmatrix([[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]) { ";
    const std::string slanted = "multmatrix([[1,0,0,0],[0,0.8,-0.6,0],[0,0.6,0.8,0],[0,0,0,1]]) { ";
    const auto near = [](double value) { return doctest::Approx(value).epsilon(1e-5); };
    const std::string bore = "cylinder(h = 62.5, r1 = 12.5, r2 = 6.25, center = true);";
    CHECK(shadow_area("difference() { sphere(r = 25);" + bore + along_y + bore + "} }", 12) == near(1567.16));
    CHECK(shadow_area("difference() { cube(4, center = true); " + slanted +
                          "cylinder(r = 1, h = 20, center = true); } }",
                      24) == near(16));
    CHECK(shadow_area("intersection() { " + slanted +
                          "difference() { cube(4, center = true); cube(2); } } sphere(r = 3); }",
                      16) == near(21.0268));
    CHECK(shadow_area("difference() { sphere(r = 10); multmatrix([[1,0,0,5],[0,1,0,3],[0,0,1,6],[0,0,0,1]]) "
                      "{ sphere(r = 8); } }",
                      24) == near(305.29).epsilon(0.005));  // there the second sphere has 20
    CHECK(shadow_area("multmatrix([[0.8,0,0.6,0],[0,1,0,0],[-0.6,0,0.8,0],[0,0,0,1]]) { difference() { "
                      "cube([8,6,1]); multmatrix([[1,0,0,2],[0,1,0,2],[0,0,1,-1],[0,0,0,1]]) { cylinder(r=1, "
                      "h=9); } multmatrix([[1,0,0,5],[0,1,0,3],[0,0,1,-1],[0,0,0,1]]) { cube([2,2,4]); } } }",
                      32) == near(38.6701));
}

TEST_CASE("projection: shadows of differences, by rays; $fn decides") {
    check_shadow("difference() { " + skewed("cube(4, center = true);") + moved(0, 1, -1, "cube(3);") + " }",
                 4, 8);
    check_shadow(
        skewed("difference() { cube([6, 5, 1], center = true); " + moved(1, 0, -2, "cube(4);") + " }"), 5, 8);
    check_shadow(
        tilted(40, "difference() { " + kTetrahedron + moved(-0.5, -0.5, -3, "cube([1, 1, 9]);") + " }"), 5,
        12);
    // A hexagonal and a round hole, tilted by so little that light passes.
    const auto drilled = [](const std::string& fn) {
        return projected(tilted(5, "difference() { cube([4, 4, 1], center = true); cylinder($fn = " + fn +
                                       ", $fa = 12, $fs = 2, h = 9, r1 = 1, r2 = 1, center = true); }"),
                         false);
    };
    CHECK(region_at(read_csg(drilled("6")), {0, 0.89, 0}) == 1);
    CHECK(region_at(read_csg(drilled("96")), {0, 0.89, 0}) == 0);
    CHECK(region_at(read_csg(drilled("16")), {0.19, 0.924, 0}) == 1);
    CHECK(region_at(read_csg(drilled("96")), {0.19, 0.924, 0}) == 0);
}

TEST_CASE("projection: shadows that would take too long are refused") {
    std::string holes;
    for (int i = 0; i < 20; ++i) holes += moved(i, 0, 5, "sphere($fn = 48, $fa = 12, $fs = 2, r = 3);");
    const std::string text = projected("difference() { sphere(r = 9);" + holes + " }", false);
    CHECK(refusal(text, "csg").find("20 million") != std::string::npos);
    CHECK(refusal(projected("difference() { cube(9); implicit(\"x\"); }", false), "csg")
              .find("given by a formula") != std::string::npos);
}
