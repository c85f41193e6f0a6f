// Features smaller than a cell on the command line: the warning, the report, --strict.
#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/program.hpp"

namespace {

using Json = nlohmann::json;

/// Two slabs that span 30 units, and a rod of radius 0.1 between the grid's vertices at level 5, or a ball
/// inside one cell.
void write_model(const std::string& path, const std::string& shape) {
    std::ofstream(path) << "union() {\n"
                           "cube(size = [30, 30, 10], center = false);\n"
                           "cube(size = [10, 30, 30], center = false);\n"
                           "multmatrix([[1, 0, 0, 20.3], [0, 1, 0, 20.3], [0, 0, 1, 20.3], [0, 0, 0, 1]]) {\n"
                        << shape << "\n}\n}\n";
}

}  // namespace

TEST_CASE("a feature that is lost is told with its place; with --strict nothing is written") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string model = scratch.file("rod.csg");
    const std::string vtu = scratch.file("out/rod.vtu");
    write_model(model, "cylinder($fn = 0, $fa = 12, $fs = 2, h = 6, r1 = 0.1, r2 = 0.1, center = true);");
    const Outcome told = run({model, "-o", vtu, "--level", "5", "--json"});
    REQUIRE(told.code == 0);
    CHECK(is_one_line(told.err, "warning: 1 feature between the vertices of the grid, 1 of them lost; "));
    CHECK(contains(told.err, " at (20."));
    CHECK(contains(told.err, "; --refine 4, or level 9, makes cells as small as it; --refine 1 may do"));
    const Outcome refined =
        run({model, "-o", vtu, "--level", "5", "--refine", "4", "--strict", "--check", "--quiet"});
    CHECK(refined.code == 0);
    CHECK(refined.err.empty());
    const Json document = Json::parse(told.out);
    const Json& missed = document["missed_features"];
    CHECK(missed["count"] == 1);
    CHECK(missed["lost"] == 1);
    REQUIRE(missed["largest"].size() == 1);
    CHECK(missed["largest"][0]["kind"] == "material");
    CHECK(missed["largest"][0]["kept"] == false);
    CHECK(missed["largest"][0]["size"].get<double>() == doctest::Approx(6).epsilon(0.05));
    CHECK(scratch.names("out") == std::vector<std::string>{"rod.vtu"});

    const std::string other = scratch.file("out/strict.vtu");
    const Outcome refused = run({model, "-o", other, "--level", "5", "--strict"});
    CHECK(refused.code == 3);
    CHECK(is_one_line(refused.err, "mortise: "));
    CHECK(contains(refused.err, "strict: 1 feature between the vertices of the grid, 1 of them lost; "));
    CHECK(scratch.names("out") == std::vector<std::string>{"rod.vtu"});

    // Kept, so that --strict is content.
    write_model(model, "sphere($fn = 0, $fa = 12, $fs = 2, r = 0.2);");
    const Outcome kept = run({model, "-o", other, "--level", "5", "--strict", "--check"});
    CHECK(kept.code == 0);
    CHECK(is_one_line(kept.err, "warning: 1 feature between the vertices of the grid, kept coarsely; "));
    CHECK(run({asset("block.csg"), "-o", other, "--level", "5", "--strict"}).code == 0);
}

TEST_CASE("regions that overlap are told with names and a place; with --strict nothing is written") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string model = scratch.write("boxes.geo",
                                            "algebraic3d\n"
                                            "solid left = orthobrick(0, 0, 0; 2, 1, 1);\n"
                                            "solid right = orthobrick(1.9, 0, 0; 3, 1, 1);\n"
                                            "tlo left; tlo right;\n");
    const std::string vtu = scratch.file("out/boxes.vtu");
    const Outcome told = run({model, "-o", vtu, "--level", "4"});
    CHECK(told.code == 0);
    CHECK(is_one_line(told.err, "warning: the regions 'left' and 'right' overlap, around (1.9"));
    CHECK(scratch.names("out") == std::vector<std::string>{"boxes.vtu"});
    const Outcome refused = run({model, "-o", scratch.file("out/strict.vtu"), "--level", "4", "--strict"});
    CHECK(refused.code == 3);
    CHECK(is_one_line(refused.err, "mortise: "));
    CHECK(contains(refused.err, "strict: the regions 'left' and 'right' overlap, around (1.9"));
    CHECK(scratch.names("out") == std::vector<std::string>{"boxes.vtu"});
}
