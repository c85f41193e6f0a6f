// Walls much thinner than cells: facets of curved skins are chords, and must not make such a wall thicker.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr int kFilmLevel = 4;
constexpr double kRadius = 10;
constexpr double kCell = 2 * kRadius / 15;  ///< about: the root cube has half a cell around the solid

double ball_volume(double radius) { return 4 * kPi / 3 * radius * radius * radius; }

MeshOptions options() {
    MeshOptions result;
    result.level = kFilmLevel;
    return result;
}

TEST_CASE("spherical shells keep their volume") {
    for (const double thickness : {0.002, 0.02, 0.3}) {
        CAPTURE(thickness);
        const double inner = kRadius - thickness * kCell;
        const Meshed m = mesh_and_check(one_solid([&](Model& model) {
                                            return subtract(model, {add_ball(model, {0, 0, 0}, kRadius),
                                                                    add_ball(model, {0, 0, 0}, inner)});
                                        }),
                                        options());
        CHECK(m.defects == "");
        CHECK(m.check.euler_characteristic == 4);
        const double expected = ball_volume(kRadius) - ball_volume(inner);
        CHECK(m.check.volume > 0.9 * expected);
        CHECK(m.check.volume < 1.25 * expected);
    }
}

TEST_CASE("a coating between two regions keeps its volume") {
    const double thickness = 0.005 * kCell;
    Model model;
    model.source = "test model";
    const NodeIndex core = add_ball(model, {0, 0, 0}, kRadius - thickness);
    const NodeIndex ball = add_ball(model, {0, 0, 0}, kRadius);
    const NodeIndex coating = subtract(model, {ball, core});
    const NodeIndex box = add_box(model, {-11, -11, -11}, {11, 11, 11});
    add_region(model, core, "core");
    add_region(model, coating, "coating");
    add_region(model, subtract(model, {box, ball}), "air");
    const Meshed m = mesh_and_check(model, options());
    CHECK(m.defects == "");
    const double expected = ball_volume(kRadius) - ball_volume(kRadius - thickness);
    REQUIRE(m.check.region_volume.size() == 3);
    CHECK(m.check.region_volume[1] > 0.8 * expected);
    CHECK(m.check.region_volume[1] < 1.5 * expected);
    CHECK(m.check.region_volume[0] == doctest::Approx(ball_volume(kRadius - thickness)).epsilon(0.01));
}

TEST_CASE("elements of a thin wall are even, and there are not many more than the wall needs") {
    // Each of them is as flat as the wall forces it to be; the worst is not much worse than the others.
    const double inner = kRadius - 0.1 * kCell;
    const Meshed m = mesh_and_check(
        one_solid([&](Model& model) {
            return subtract(model, {add_cylinder(model, kRadius, -5, 5), add_cylinder(model, inner, -6, 6)});
        }),
        options());
    CHECK(m.defects == "");
    std::vector<float> quality = m.report.scaled_jacobians;
    REQUIRE(!quality.empty());
    std::sort(quality.begin(), quality.end());
    const float median = quality[quality.size() / 2];
    CHECK(median < 0.2F);
    CHECK(quality.front() > 0.2F * median);
    const double area = 4 * kPi * kRadius * 10;
    CHECK(static_cast<double>(quality.size()) < 25 * area / (kCell * kCell));
}

}  // namespace
}  // namespace mortise::test
