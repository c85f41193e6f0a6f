// Distances to formulas that jump, or are no number somewhere: gradients do not lead to such surfaces.
#include <doctest/doctest.h>

#include <string>

#include "mortise/mesher.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/report/hand_made.hpp"

using namespace mortise;

namespace {

QualityReport quality_of(const std::string& formula, double half) {
    MeshOptions options;
    options.level = 5;
    options.quality = true;
    options.box = Box3{{-half, -half, -0.9}, {half, half, 0.9}};
    MeshReport report;
    test::generate(parse_model(formula, "formula", "jumps.formula"), options, &report);
    REQUIRE(report.quality.has_value());
    return *report.quality;
}

}  // namespace

TEST_CASE("samples on a formula's jumps are measured to these, not to where gradients lead") {
    // A cylinder in steps: walls are zeros, terraces jumps of the formula, far from its zeros.
    const QualityReport steps = quality_of("sqrt(x^2 + y^2) - 1 - 0.3 * floor(2 * z)", 1.6);
    CHECK(steps.mesh_to_model.samples > 1000);
    CHECK(steps.mesh_to_model.unmeasured == 0);
    CHECK(steps.mesh_to_model.maximum < 0.8 * steps.cell_size);
    // A ball whose formula has no gradient anywhere: its facets do not lie on it.
    const QualityReport ball = quality_of("floor(1.5 * (x^2 + y^2 + z^2)) - 0.5", 0.95);
    CHECK(ball.mesh_to_model.samples > 1000);
    CHECK(ball.mesh_to_model.maximum > 0.5 * ball.model_to_mesh.maximum);
    CHECK(ball.mesh_to_model.maximum < 2 * ball.model_to_mesh.maximum);
    // 0 / 0 in a plane of the grid changes nothing.
    const QualityReport sinc = quality_of("y^2 + z^2 / 0.7 - sin(2 * x) / (4 * x)", 1.2);
    const QualityReport whole = quality_of("y^2 + z^2 / 0.7 - sin(2 * (x + 1e-9)) / (4 * (x + 1e-9))", 1.2);
    CHECK(sinc.mesh_to_model.unmeasured == 0);
    CHECK(sinc.mesh_to_model.maximum == doctest::Approx(whole.mesh_to_model.maximum).epsilon(0.01));
    CHECK(sinc.mesh_to_model.mean == doctest::Approx(whole.mesh_to_model.mean).epsilon(0.01));
}

TEST_CASE("samples that no surface is near are counted, not measured") {
    test::HandMade made = test::cube_of_cubes(3);
    Model far;
    Primitive jump;
    jump.kind = Primitive::Kind::kExpression;
    jump.expression = "floor(x) - 9.5";
    far.regions.push_back({"far", far.add_primitive(jump, "far"), 0, {}});
    made.model = tape::bind(tape::compile(far), {-2, -2, -2}, 7);
    made.facet_surface.assign(made.mesh.facets.size(), 0);
    made.mesh.facets.surface = made.facet_surface;
    made.mesh.surface_names = {"far"};
    const QualityReport report = made.assess(3);
    CHECK(report.mesh_to_model.samples == 0);
    CHECK(report.mesh_to_model.unmeasured == 13 * made.mesh.facets.size());
    CHECK(report.mesh_to_model.maximum == 0);
}
