// Regions that overlap are told, with both names and a place; those that only touch are not.
//
// Every model spans 30 units, so that at level 5 cells have unit size.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr int kOverlapLevel = 5;

std::vector<std::string> overlaps_of(const Model& model,
                                     const MeshOptions& options = at_level(kOverlapLevel)) {
    MeshReport report;
    generate(model, options, &report);
    std::vector<std::string> found;
    for (const std::string& warning : report.warnings) {
        if (warning.find("overlap") != std::string::npos) found.push_back(warning);
    }
    return found;
}

/// The place that a warning names.
Vec3 place_in(const std::string& warning) {
    Vec3 at{};
    const std::size_t open = warning.find('(');
    REQUIRE(open != std::string::npos);
    REQUIRE(std::sscanf(warning.c_str() + open, "(%lf, %lf, %lf)", &at[0], &at[1], &at[2]) == 3);
    return at;
}

/// Two boxes along x that share `shared` units; `turn` about an axis askew.
Model two_boxes(double shared, double turn) {
    Model model;
    const Affine map = rotation({1, 2, 3}, turn);
    add_region(model, model.add_transform(map, add_box(model, {0, 0, 0}, {15.37, 8, 9})), "left");
    add_region(model, model.add_transform(map, add_box(model, {15.37 - shared, 0, 0}, {30, 8, 9})), "right");
    return model;
}

/// A box without a ball, and the ball, larger by `more`.
Model ball_in_box(double more) {
    Model model;
    const NodeIndex box = add_box(model, {0, 0, 0}, {30, 30, 30});
    add_region(model, subtract(model, {box, add_ball(model, {14.2, 15.1, 15.3}, 9)}), "box");
    add_region(model, add_ball(model, {14.2, 15.1, 15.3}, 9 + more), "ball");
    return model;
}

}  // namespace

TEST_CASE("two regions that overlap are named, with a place in both") {
    for (const double turn : {0.0, 0.7}) {
        for (const double shared : {8.0, 1.0, 0.3, 0.01}) {
            CAPTURE(shared);
            CAPTURE(turn);
            const std::vector<std::string> told = overlaps_of(two_boxes(shared, turn));
            REQUIRE(told.size() == 1);
            CHECK(told[0].find("the regions 'left' and 'right' overlap, around (") == 0);
            CHECK(told[0].find("belongs to 'left'") != std::string::npos);
            const Vec3 at = test::apply(rotation({1, 2, 3}, -turn), place_in(told[0]));
            CHECK(at[0] > 15.37 - shared - 1e-3);
            CHECK(at[0] < 15.37 + 1e-3);
        }
    }
    for (const double more : {3.0, 0.2, 0.01}) {
        CAPTURE(more);
        const std::vector<std::string> told = overlaps_of(ball_in_box(more));
        REQUIRE(told.size() == 1);
        const Vec3 at = place_in(told[0]);
        const double radius = std::hypot(at[0] - 14.2, at[1] - 15.1, at[2] - 15.3);
        CHECK(radius > 9 - 1e-3);
        CHECK(radius < 9 + more + 1e-3);
    }
}

TEST_CASE("a ball that dips into a plate by a hair overlaps it, one that touches it does not") {
    for (const int level : {3, 5}) {
        for (const double deep : {0.1, 0.01, 0.001, 0.0, -0.001}) {
            CAPTURE(level);
            CAPTURE(deep);
            Model model;
            add_region(model, add_ball(model, {13.3, 16.1, 10}, 9), "ball");
            add_region(model, add_box(model, {0, 0, 19 - deep}, {30, 30, 22}), "plate");
            CHECK(overlaps_of(model, at_level(level)).size() == (deep > 0 ? 1 : 0));
        }
    }
}

TEST_CASE("a region inside another one overlaps it, though it has no element") {
    Model model;
    add_region(model, add_box(model, {0, 0, 0}, {30, 30, 30}), "all");
    add_region(model, add_ball(model, {12.3, 8.4, 21.5}, 2), "hidden");
    CHECK(overlaps_of(model).size() == 1);
    // Cells as large as can be inside.
    MeshOptions options = at_level(kOverlapLevel);
    options.interior_coarsening = 3;
    CHECK(overlaps_of(model, options).size() == 1);
}

TEST_CASE("regions that only touch, exactly or but for rounding, are no overlap") {
    for (const double turn : {0.0, 0.7}) {
        for (const double shared : {0.0, 1e-9, 1e-6, 1e-5, -1e-6, -0.3}) {
            CAPTURE(shared);
            CAPTURE(turn);
            CHECK(overlaps_of(two_boxes(shared, turn)).empty());
        }
    }
    for (const double more : {0.0, 1e-9, 1e-6, 1e-5, -1e-6, -0.2}) {
        CAPTURE(more);
        CHECK(overlaps_of(ball_in_box(more)).empty());
    }
    // One inside the other, one around both, all touching all.
    Model shells;
    const NodeIndex core = add_torus(shells, 9, 3);
    const NodeIndex around = add_torus(shells, 9, 5);
    add_region(shells, core, "core");
    add_region(shells, subtract(shells, {around, core}), "shell");
    add_region(shells, subtract(shells, {add_box(shells, {-15, -15, -6}, {15, 15, 6}), around}), "air");
    CHECK(overlaps_of(shells).empty());
    MeshOptions graded = at_level(4);
    graded.refine = 2;
    CHECK(overlaps_of(shells, graded).empty());
}

TEST_CASE("what is told of overlaps does not depend on threads; --strict refuses them") {
    Model model;
    for (int k = 0; k < 5; ++k)
        add_region(model, add_ball(model, {4.0 * k, 3.0 * (k % 2), 0}, 5), "ball" + std::to_string(k));
    MeshOptions options = at_level(kOverlapLevel);
    options.threads = 1;
    const std::vector<std::string> one = overlaps_of(model, options);
    options.threads = 3;
    CHECK(overlaps_of(model, options) == one);
    // Neighbours, and those but one: five lines and a last one for the others.
    REQUIRE(one.size() == 6);
    CHECK(one.back() == "2 other pairs of regions overlap");
    options.strict = true;
    CHECK_THROWS_WITH_AS(generate(model, options),
                         doctest::Contains("strict: the regions 'ball0' and 'ball1' overlap, around ("),
                         Error);
}

}  // namespace mortise::test
