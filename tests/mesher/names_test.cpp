// Names of surfaces where equal surfaces of several primitives are one.
#include <doctest/doctest.h>

#include <map>
#include <set>
#include <string>

#include "host/common/vec3.hpp"
#include "mortise/mesher.hpp"
#include "mortise/model.hpp"
#include "tests/mesher/meshed.hpp"

namespace {

using namespace mortise;
using test::at_level;
using Names = std::set<std::string>;

/// Names of the facets by the regions that they lie between.
std::map<std::pair<std::string, std::string>, Names> names_of(const Mesh& mesh) {
    const auto region = [&mesh](std::uint16_t r) { return r == 0 ? "" : mesh.region_names[r - 1u]; };
    std::map<std::pair<std::string, std::string>, Names> names;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        names[{region(mesh.facets.inside[f]), region(mesh.facets.outside[f])}].insert(
            mesh.surface_names[mesh.facets.surface[f]]);
    }
    return names;
}

/// Two boxes side by side, with four sides in common planes.
const char* const kTwoBoxes =
    "algebraic3d\n"
    "solid left = orthobrick(0, 0, 0; 1, 1, 1) -bc=7;\n"
    "solid right = orthobrick(1, 0, 0; 2, 1, 1);\n"
    "tlo left; tlo right;\n";

}  // namespace

TEST_CASE("facets are named after the solid of their own region") {
    const Model model = parse_model(kTwoBoxes, "geo", "boxes.geo");
    const auto names = names_of(test::generate(model, at_level(3)));
    CHECK(names.at({"left", ""}) == Names{"bc_7"});
    CHECK(names.at({"left", "right"}) == Names{"bc_7"});
    CHECK(names.at({"right", ""}) ==
          Names{"right_xmax", "right_ymin", "right_ymax", "right_zmin", "right_zmax"});
}

TEST_CASE("a size on a surface that is one with another region's is found by either name") {
    const Model model = parse_model(kTwoBoxes, "geo", "boxes.geo");
    MeshOptions options = at_level(3);
    options.named_sizes = {{"right_ymin", 0.1}};
    MeshReport report;
    test::generate(model, options, &report);
    CHECK(report.finest_level > report.level);
}

namespace {

/// Area of the facets of a name on one side of the plane x = at.
double area_of(const Mesh& mesh, const std::string& name, double at, bool beyond) {
    double area = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.surface_names[mesh.facets.surface[f]] != name) continue;
        const NodeId* const n = mesh.facets.nodes.data() + 4 * f;
        Vec3 p[4];
        double x = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            for (std::size_t j = 0; j < 3; ++j) p[k][j] = mesh.points[3 * std::size_t{n[k]} + j];
            x += p[k][0] / 4;
        }
        if ((x > at) != beyond) continue;
        // Half the cross product of the diagonals; a triangle's second one is a side.
        const Vec3 u = difference(p[2], p[0]), v = difference(p[3], p[1]);
        area += 0.5 * length(cross(u, v));
    }
    return area;
}

}  // namespace

TEST_CASE("faces in one plane have the names of their own solids") {
    // Three bodies of one region apart from each other, with four sides in common planes; a hole in the
    // third.
    const Model model = parse_model(
        "algebraic3d\n"
        "solid a = orthobrick(0, 0, 0; 1, 1, 1) -bcname=left;\n"
        "solid b = orthobrick(2, 0, 0; 3, 1, 1) -bcname=right;\n"
        "solid c = orthobrick(4, 0, 0; 6, 1, 1) -bcname=drilled;\n"
        "solid hole = orthobrick(4.5, 0.25, 0; 5.5, 0.75, 1) -bcname=hole;\n"
        "solid all = a or b or (c and not hole);\n"
        "tlo all;\n",
        "geo", "bodies.geo");
    MeshOptions options = at_level(5);
    for (const bool in_parts : {false, true}) {
        options.pieces = in_parts ? 4 : 1;
        const Mesh mesh = test::generate(model, options);
        CHECK(area_of(mesh, "left", 1.5, false) == doctest::Approx(6));
        CHECK(area_of(mesh, "left", 1.5, true) == 0);
        CHECK(area_of(mesh, "right", 1.5, false) == 0);
        CHECK(area_of(mesh, "right", 3.5, false) == doctest::Approx(6));
        CHECK(area_of(mesh, "right", 3.5, true) == 0);
        CHECK(area_of(mesh, "drilled", 3.5, true) == doctest::Approx(10 - 2 * 0.5));
        CHECK(area_of(mesh, "hole", 3.5, true) == doctest::Approx(3));
    }
}

TEST_CASE("a face that two solids have alike is the first's; where only one has it, that one's") {
    const Model model =
        parse_model("union() { cube([2, 1, 1]); translate([1, 0, 0]) cube([3, 1, 1]); }", "csg", "boxes.csg");
    const Mesh mesh = test::generate(model, at_level(5));
    CHECK(area_of(mesh, "cube1_ymin", 2, false) == doctest::Approx(2).epsilon(0.04));
    CHECK(area_of(mesh, "cube2_ymin", 2, true) == doctest::Approx(2).epsilon(0.04));
    CHECK(area_of(mesh, "cube2_ymin", 1.9, false) == 0);
    CHECK(area_of(mesh, "cube1_ymin", 2.1, true) == 0);
}

TEST_CASE("a size on a surface that lies in another's plane is found by its own name") {
    const Model model = parse_model(
        "union() { cube([10, 10, 4]); translate([5, 5, 4]) cylinder(r = 2, h = 5); }", "csg", "boss.csg");
    MeshOptions options = at_level(4);
    options.named_sizes = {{"cylinder1_zmin", 0.3}};
    MeshReport report;
    test::generate(model, options, &report);
    CHECK(report.finest_level > report.level);
}

TEST_CASE("boxes side by side in one region have the names of both") {
    const Model model =
        parse_model("union() { cube([1, 1, 1]); translate([1, 0, 0]) cube([1, 1, 1]); }", "csg", "boxes.csg");
    const auto names = names_of(test::generate(model, at_level(3)));
    REQUIRE(names.size() == 1);
    CHECK(names.begin()->second == Names{"cube1_xmin", "cube2_xmax", "cube1_ymin", "cube1_ymax", "cube1_zmin",
                                         "cube1_zmax", "cube2_ymin", "cube2_ymax", "cube2_zmin",
                                         "cube2_zmax"});
}
