// Features closer to each other than a small part of a cell: kept apart they force slivers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host/improve/clash.hpp"
#include "tests/improve/stepped.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

std::size_t slivers(const Meshed& m) {
    const std::vector<float>& all = m.report.scaled_jacobians;
    return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [](float x) { return x < 0.1f; }));
}

/// Nodes of the box of 20 x 20 x 10 that the step does not touch.
constexpr double kFar[4][3] = {{0, 0, 0}, {0, 0, 10}, {0, 20, 0}, {0, 20, 10}};

}  // namespace

TEST_CASE("a step far lower than a cell makes no slivers") {
    std::size_t left = 0;
    std::size_t before = 0;
    for (const double step : {0.004, 0.01, 0.02, 0.03}) {
        CAPTURE(step);
        const Model model = stepped(step);
        MeshOptions options;
        options.level = 5;
        const Meshed merged = mesh_and_check(model, options);
        CHECK(merged.defects == "");
        CHECK(merged.report.merged_nodes > 0);
        // Volume: of each box, less what they share. A merged node is off by the step at most, along a strip
        // of two cells.
        const double volume = 20 * 20 * 10 + 19 * 13 * 10 + 20 * 13 * step;
        CHECK(merged.check.volume == doctest::Approx(volume).epsilon(3e-4));
        for (const auto& corner : kFar) {
            const Vec3 turned = {0.8 * corner[0] - 0.6 * corner[1], 0.6 * corner[0] + 0.8 * corner[1],
                                 corner[2]};
            CHECK(nearest_node(merged.mesh, turned) < 1e-9);
        }
        options.merge_distance = 0;
        const Meshed kept = mesh_and_check(model, options);
        CHECK(kept.defects == "");
        CHECK(kept.report.merged_nodes == 0);
        // Around a higher step elements may become smaller instead.
        if (step < 0.015) CHECK(slivers(kept) > 20);
        CHECK(3 * slivers(merged) <= slivers(kept));
        left += slivers(merged);
        before += slivers(kept);
        CHECK(kept.check.volume == doctest::Approx(volume).epsilon(1e-9));
        options.merge_distance = 0.05;
        options.strict = true;
        if (step < 0.01) CHECK(mesh_and_check(model, options).report.merged_nodes == 0);
    }
    CHECK(10 * left <= before);
}

// A tool that ends a little above the plate, as people write it, beside a rib that is higher: the plate's top
// and the rib's underside face away from each other, but on opposite sides of the step.
TEST_CASE("a step between surfaces that face away from each other, without material between") {
    const Model model = parse_model(
        "difference() { union() { cube(size = [32, 21, 7]);"
        " multmatrix([[1, 0, 0, 12], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(size = [2.31, 21, "
        "10]); } }"
        " multmatrix([[1, 0, 0, 18], [0, 1, 0, 10.31], [0, 0, 1, 5], [0, 0, 0, 1]])"
        " { cylinder(h = 2.01, r1 = 2.8, r2 = 4.81); } }",
        "csg", "countersink.csg");
    MeshOptions options;
    options.level = 5;
    const Meshed merged = mesh_and_check(model, options);
    CHECK(merged.defects == "");
    CHECK(merged.report.merged_nodes > 0);
    CHECK(slivers(merged) == 0);
}

TEST_CASE("features farther apart are not merged") {
    MeshOptions options;
    options.level = 5;
    const Meshed m = mesh_and_check(stepped(0.5), options);
    CHECK(m.defects == "");
    CHECK(m.report.merged_nodes == 0);
    CHECK(m.check.volume == doctest::Approx(20 * 20 * 10 + 19 * 13 * 10 + 20 * 13 * 0.5).epsilon(1e-9));
}

/// Merged corners are put where the model has them, and there a node lay that had been removed: this counted
/// as a clash, and blocks were left unimproved.
TEST_CASE("a node that no element has does not clash") {
    const std::vector<improve::Point> before = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    const std::vector<improve::Point> after = {{0, 0, 0}, {2, 0, 0}, {2, 0, 0}};
    const std::vector<improve::Tetrahedron> none;
    const std::vector<std::size_t> first = {0, 0, 0};
    const std::vector<std::uint8_t> changed = {1, 1};
    const auto clashes = [&](std::uint32_t third) {
        const std::vector<std::uint32_t> owner = {0, 0, third};
        return improve::find_clashes({before, after, owner, 0xfffffffeu, none, first, changed, 1}, 1);
    };
    CHECK(clashes(1) == std::vector<std::uint32_t>{0});
    CHECK(clashes(improve::kNone).empty());
}

}  // namespace mortise::test
