// Cells that hold far more surfaces than they can show: nothing would become good there, in hours.
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

improve::Counters improved(const Model& model, int level, Mesh& mesh) {
    MeshOptions options;
    options.level = level;
    options.improve = false;
    mesh = generate_mesh(model, options);
    improve::Options improving;
    improving.level = level;
    improve::Counters counters;
    mesh = improve::improve(std::move(mesh), bind_model(model, level), improving, &counters);
    return counters;
}

}  // namespace

TEST_CASE("blocks of crowded cells are left as they are") {
    Mesh mesh;
    const improve::Counters crowded = improved(plates(40, true), 2, mesh);
    CHECK(crowded.block.given_up > 0);
    CHECK(crowded.block.tried == 0);
    CHECK(check_mesh(mesh).valid());
    // The same kind of model where cells have room.
    const improve::Counters roomy = improved(plates(3, false), 4, mesh);
    CHECK(roomy.block.given_up == 0);
    CHECK(roomy.block.tried > 0);
    CHECK(check_mesh(mesh).valid());
}

}  // namespace mortise::test
