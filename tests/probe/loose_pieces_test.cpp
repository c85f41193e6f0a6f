// Pins and holes thinner than the cells, which samples see here and there: the mesh has crumbs of them, or
// closed hollows, and must tell. The oracle is the Euler characteristic of the mesh's boundary.
#include <doctest/doctest.h>

#include <random>
#include <sstream>
#include <string>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

Model plate_with(const std::string& before, const std::string& after) {
    return parse_model(before + "cube([100, 60, 4]);" + after, "csg", "plate");
}

Model plate_with_pin(double x, double y) {
    std::ostringstream pin;
    pin << "translate([" << x << ", " << y << ", 3]) cylinder(h = 6, r = 0.15, $fn = 0);";
    return plate_with("", pin.str());
}

Model plate_with_hole(double x, double y) {
    std::ostringstream hole;
    hole << "translate([" << x << ", " << y << ", -1]) cylinder(h = 6, r = 0.25, $fn = 0);}";
    return plate_with("difference() {", hole.str());
}

}  // namespace

TEST_CASE("a pin of which only crumbs are left is told of") {
    const Model model = plate_with_pin(37.08, 32.49);
    MeshOptions options = at_level(6);
    const Meshed result = mesh_and_check(model, options);
    CHECK(result.defects == "");
    REQUIRE(result.check.components == 4);
    CHECK(result.report.loose_pieces == 3);
    CHECK(result.report.closed_hollows == 0);
    REQUIRE(!result.report.warnings.empty());
    CHECK(result.report.warnings[0].find("3 loose pieces where the model goes on") != std::string::npos);
    options.threads = 1;
    CHECK(mesh_and_check(model, options).report.warnings == result.report.warnings);

    DiscardingSink discard;
    MeshReport streamed;
    options.pieces = 3;
    Mesher().stream(model, options, discard, &streamed);
    CHECK(streamed.loose_pieces == 3);

    options = at_level(6);
    options.strict = true;
    CHECK_THROWS_WITH_AS(generate(model, options), doctest::Contains("3 loose pieces"), Error);
}

TEST_CASE("a hole of which only closed hollows are left is told of") {
    const Meshed result = mesh_and_check(plate_with_hole(42.01, 32.49), at_level(6));
    REQUIRE(result.check.euler_characteristic == 6);
    CHECK(result.report.closed_hollows == 2);
    CHECK(result.report.loose_pieces == 0);
}

TEST_CASE("no thin pin or hole is wrong without a word") {
    std::mt19937 random(5);
    const auto between = [&random](double low, double high) {
        return std::uniform_real_distribution<>(low, high)(random);
    };
    int wrong = 0, silent = 0;
    for (int k = 0; k < 80; ++k) {
        CAPTURE(k);
        const bool is_pin = k % 2 == 0;
        const double x = between(2, 98), y = between(2, 58);
        const Meshed result =
            mesh_and_check(is_pin ? plate_with_pin(x, y) : plate_with_hole(x, y), at_level(6));
        CHECK(result.defects == "");
        const bool is_right = result.check.euler_characteristic == (is_pin ? 2 : 0);
        const bool is_whole = result.check.components == 1;
        if (is_right && is_whole) continue;
        ++wrong;
        const MeshReport& report = result.report;
        if (report.loose_pieces + report.closed_hollows == 0 && lost_features(report) == 0) ++silent;
        if (!is_whole) CHECK(report.loose_pieces == result.check.components - 1);
    }
    MESSAGE(wrong, " of 80 parts are wrong, ", silent, " silently");
    CHECK(wrong > 5);
    CHECK(silent == 0);
}

TEST_CASE("small bodies and voids that the model has are no crumbs, and are not lost") {
    // A void between the vertices of the grid, which its cell keeps: first told as lost, then found.
    const Meshed hollow = mesh_and_check(
        parse_model(
            "difference() { cube([40, 40, 40]); translate([3.3, 9.8, 17.1]) sphere(r = 0.35, $fn = 0);"
            "translate([20, 20, 20]) sphere(r = 0.5, $fn = 0); }",
            "csg", "void"),
        at_level(6));
    CHECK(hollow.check.euler_characteristic == 6);
    CHECK(hollow.report.closed_hollows == 0);
    CHECK(lost_features(hollow.report) == 0);
    const Meshed apart =
        mesh_and_check(parse_model("cube([40, 40, 4]); translate([20, 20, 8]) sphere(r = 0.6, $fn = 0);"
                                   "translate([10, 10, 5.5]) cylinder(h = 1.2, r = 0.5, $fn = 0);",
                                   "csg", "apart"),
                       at_level(6));
    CHECK(apart.check.components == 3);
    CHECK(apart.report.loose_pieces == 0);
}

TEST_CASE("a void under a wall that is thinner than all steps is whole") {
    std::ostringstream text;
    text << "difference() { cube([10, 10, 10]); translate([5.2, 0.46, 4.54]) sphere(r = 0.45, $fn = 0); }";
    MeshOptions options;
    options.level = 4;
    options.strict = true;
    const Meshed result = mesh_and_check(parse_model(text.str(), "csg", "void"), options);
    CHECK(result.check.euler_characteristic == 4);
    CHECK(result.report.closed_hollows == 0);
}

TEST_CASE("a lost bar is not kept by the body around it, nor that body a loose piece") {
    // A U with a thin bar across its opening, in the bounds of the U; a block with a pin.
    const Model bar = parse_model(
        "difference() { cube([10, 10, 4]); translate([3, 3, -1]) cube([4, 8, 6]); }"
        "multmatrix([[0,0,1,2],[0,1,0,6],[-1,0,0,2],[0,0,0,1]]) cylinder(h = 6, r = 0.1, $fn = 0);",
        "csg", "bar");
    MeshOptions options;
    options.level = 3;
    const Meshed result = mesh_and_check(bar, options);
    REQUIRE(result.check.volume == doctest::Approx(288));
    CHECK(lost_features(result.report) == 1);
    options.strict = true;
    CHECK_THROWS_AS(generate(bar, options), Error);
    options.strict = false;
    const Meshed pin = mesh_and_check(
        parse_model("cube([10, 10, 10]); translate([5, 5, 5]) cylinder(h = 30, r = 0.7, $fn = 0);", "csg",
                    "pin"),
        options);
    REQUIRE(pin.check.volume == doctest::Approx(1000));
    CHECK(pin.report.loose_pieces == 0);
    CHECK(lost_features(pin.report) == 1);
}

TEST_CASE("many thick bodies cost little") {
    std::ostringstream text;
    for (int i = 0; i < 216; ++i)
        text << "translate([" << 4 * (i % 6) << ", " << 4 * (i / 6 % 6) << ", " << 4 * (i / 36)
             << "]) sphere(r = 1.5, $fn = 0);";
    MeshOptions options;
    options.level = 5;
    const Meshed balls = mesh_and_check(parse_model(text.str(), "csg", "balls"), options);
    CHECK(balls.check.components == 216);
    CHECK(balls.report.loose_pieces == 0);
    for (const StageTime& stage : balls.report.stages) {
        if (stage.stage == "films") CHECK(stage.wall_seconds < 5);  // 30 where all of each ball is walked
    }
}

}  // namespace mortise::test
