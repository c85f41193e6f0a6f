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

/// Thin plates through one point, each turned otherwise, in a ball.
Model plates(int count) {
    std::string text = "intersection() { sphere(r = 1); union() {";
    for (int i = 0; i < count; ++i) {
        text += "rotate([" + std::to_string(137.5 * i) + ", " + std::to_string(61.8 * i) +
                ", 0]) cube([3, 3, 0.01], center = true);";
    }
    return parse_model(text + "} }", "csg", "plates.csg");
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
    const improve::Counters crowded = improved(plates(40), 2, mesh);
    CHECK(crowded.block.given_up > 0);
    CHECK(crowded.block.tried == 0);
    CHECK(check_mesh(mesh).valid());
    // The same kind of model where cells have room.
    const improve::Counters roomy = improved(plates(3), 4, mesh);
    CHECK(roomy.block.given_up == 0);
    CHECK(roomy.block.tried > 0);
    CHECK(check_mesh(mesh).valid());
}

}  // namespace mortise::test
