// Blocks in which nothing would become good: cells that hold far more surfaces than they can show, and films.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "host/improve/improve.hpp"
#include "mortise/check.hpp"
#include "mortise/mesher.hpp"
#include "mortise/model.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

/// Thin plates through one point, each turned otherwise, in a ball. The ball may be another region: leaves of
/// one region are meshed by where they are in and out alone if they are crowded.
Model plates(int count, bool with_ball) {
    std::string text = "union() {";
    for (int i = 0; i < count; ++i) {
        text += "rotate([" + std::to_string(137.5 * i) + ", " + std::to_string(61.8 * i) +
                ", 0]) cube([3, 3, 0.01], center = true);";
    }
    Model model = parse_model(text + "}", "csg", "plates.csg");
    const NodeIndex united = model.regions[0].root;
    model.regions.clear();
    const NodeIndex ball = add_ball(model, {0, 0, 0}, 1);
    if (with_ball) add_region(model, ball, "ball");
    add_region(model, intersect(model, {ball, united}), "plates");
    return model;
}

improve::Counters improved(const Model& model, int level, double merge_distance, Mesh& mesh) {
    MeshOptions options;
    options.level = level;
    options.improve = false;
    mesh = generate(model, options);
    improve::Options improving;
    improving.level = level;
    improving.merge_distance = merge_distance;
    improve::Counters counters;
    mesh = improve::improve(std::move(mesh), bind_model(model, level), improving, &counters);
    return counters;
}

}  // namespace

TEST_CASE("blocks of crowded cells are left as they are") {
    Mesh mesh;
    const improve::Counters crowded = improved(plates(40, true), 2, 0, mesh);
    CHECK(crowded.block.given_up > 0);
    CHECK(crowded.block.tried == 0);
    CHECK(check_mesh(mesh).valid());
    // The same kind of model where cells have room.
    const improve::Counters roomy = improved(plates(3, false), 4, 0, mesh);
    CHECK(roomy.block.given_up == 0);
    CHECK(roomy.block.tried > 0);
    CHECK(check_mesh(mesh).valid());
}

/// A ball less one that is a little beside it: a film of 0.01 of a cell at most.
TEST_CASE("films stay as plain changes leave them") {
    constexpr double kRadius = 8;
    constexpr double kShift = 0.005;
    const Model film = one_solid([&](Model& model) {
        return subtract(model,
                        {add_ball(model, {0, 0, 0}, kRadius), add_ball(model, {kShift, 0, 0}, kRadius)});
    });
    Mesh mesh;
    const improve::Counters counters = improved(film, 5, 0.05, mesh);
    CHECK(counters.block.tried > 0);
    CHECK(counters.block.compound == 0);
    CHECK(check_mesh(mesh).valid());
    const double volume = 3.14159265358979 * kRadius * kRadius * kShift;
    CHECK(enclosed_volume(mesh, 1) == doctest::Approx(volume).epsilon(0.25));
}

}  // namespace mortise::test
