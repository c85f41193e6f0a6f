// Features finer than elements bear, but too far apart to be merged: elements around them become smaller.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "tests/improve/stepped.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr int kRefineLevel = 5;

Model read(const std::string& text) { return parse_model(text, "csg", "refine.csg"); }

}  // namespace

// Scaled Jacobians were 0.058 and 0.1.
TEST_CASE("a step of a tenth of a cell has good elements and keeps its height") {
    MeshOptions options;
    options.level = kRefineLevel;
    for (const double step : {0.06, 0.1}) {
        CAPTURE(step);
        const Model model = stepped(step);
        options.threads = 1;
        const Meshed m = mesh_and_check(model, options);
        CHECK(m.defects == "");
        CHECK(m.report.merged_nodes == 0);
        CHECK(worst(m) >= 0.16);
        CHECK(m.check.volume == doctest::Approx(20 * 20 * 10 + 19 * 13 * 10 + 20 * 13 * step).epsilon(1e-9));
        for (const double y : {3.3, 16.3}) {
            CHECK(nearest_node(m.mesh, {0.8 * 19 - 0.6 * y, 0.6 * 19 + 0.8 * y, 10 + step}) < 1e-9);
            CHECK(nearest_node(m.mesh, {0.8 * 20 - 0.6 * y, 0.6 * 20 + 0.8 * y, 10}) < 1e-9);
        }
        options.threads = 2;
        CHECK(is_same_mesh(m.mesh, mesh_and_check(model, options).mesh));
    }
}

// A groove of a tenth of a cell around a cylinder: the new nodes lie on curved surfaces and creases.
TEST_CASE("a shallow groove around a cylinder") {
    const Model model = read(
        "difference() { cylinder(h = 20, r1 = 8, r2 = 8); difference() {"
        " multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 7.3], [0, 0, 0, 1]])"
        " { cylinder(h = 4.1, r1 = 9, r2 = 9); }"
        " cylinder(h = 20, r1 = 7.93, r2 = 7.93); } }");
    MeshOptions options;
    options.level = kRefineLevel;
    const Meshed m = mesh_and_check(model, options);
    CHECK(m.defects == "");
    CHECK(m.report.merged_nodes == 0);
    CHECK(worst(m) >= 0.16);
    const double pi = 3.14159265358979323846;
    CHECK(m.check.volume == doctest::Approx(pi * (8 * 8 * (20 - 4.1) + 7.93 * 7.93 * 4.1)).epsilon(4e-3));
    for (std::size_t i = 0; i < m.mesh.points.size(); i += 3) {
        const double* p = m.mesh.points.data() + i;
        CHECK(p[0] * p[0] + p[1] * p[1] <= 8 * 8 * (1 + 1e-7));
    }
}

}  // namespace mortise::test
