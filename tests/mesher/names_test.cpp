// Names of surfaces where equal surfaces of several primitives are one.
#include <doctest/doctest.h>

#include <map>
#include <set>
#include <string>

#include "mortise/mesher.hpp"
#include "mortise/model.hpp"
#include "tests/mesher/meshed.hpp"

namespace {

using namespace mortise;
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

MeshOptions at_level(int level) {
    MeshOptions options;
    options.level = level;
    return options;
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

TEST_CASE("equal surfaces of one region have the name of the first") {
    const Model model =
        parse_model("union() { cube([1, 1, 1]); translate([1, 0, 0]) cube([1, 1, 1]); }", "csg", "boxes.csg");
    const auto names = names_of(test::generate(model, at_level(3)));
    REQUIRE(names.size() == 1);
    CHECK(names.begin()->second ==
          Names{"cube1_xmin", "cube2_xmax", "cube1_ymin", "cube1_ymax", "cube1_zmin", "cube1_zmax"});
}
