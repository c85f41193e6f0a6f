// Curved solids: the error of the volume falls with the square of the cell size.
//
// Levels 4 to 6; MORTISE_FULL_CONVERGENCE=1 adds level 7 (minutes).
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Solid {
    const char* name;
    double volume;
    std::function<NodeIndex(Model&)> build;
};

std::vector<Solid> curved_solids() {
    const Affine turn = rotation({1, 2, 3}, 0.7);
    const auto across = rotation({1, 0, 0}, kPi / 2);
    return {
        {"ball", 4 * kPi / 3,
         [](Model& m) {
             return add_ball(m, {0.1, 0.2, 0.3}, 1);
         }},
        {"cylinder", 4 * kPi, [](Model& m) { return add_cylinder(m, 1, -2, 2); }},
        {"turned cylinder", 4 * kPi,
         [=](Model& m) { return m.add_transform(turn, add_cylinder(m, 1, -2, 2)); }},
        {"pointed cone", kPi, [](Model& m) { return add_frustum(m, 1, 0, 0, 3); }},
        {"turned frustum", 2 * kPi / 3 * (1 + 0.5 + 0.25),
         [=](Model& m) { return m.add_transform(turn, add_frustum(m, 1, 0.5, -1, 1)); }},
        {"torus", 2 * kPi * kPi * 2 * 0.49, [](Model& m) { return add_torus(m, 2, 0.7); }},
        {"turned torus", 2 * kPi * kPi * 2 * 0.49,
         [=](Model& m) { return m.add_transform(turn, add_torus(m, 2, 0.7)); }},
        {"ellipsoid", 4 * kPi / 3 * 1 * 0.7 * 1.6,
         [=](Model& m) {
             return m.add_transform(compose(turn, scaling({1, 0.7, 1.6})), add_ball(m, {0, 0, 0}, 1));
         }},
        {"hollow ball", 4 * kPi / 3 * (1 - 0.216),
         [](Model& m) {
             return subtract(m, {add_ball(m, {0, 0, 0}, 1), add_ball(m, {0, 0, 0}, 0.6)});
         }},
        {"two crossing cylinders", 16.0 / 3,
         [=](Model& m) {
             const NodeIndex one = m.add_primitive(infinite_cylinder(1));
             return intersect(m, {one, m.add_transform(across, one)});
         }},
        {"box with a round hole", 4 * 4 * 2 - 2 * kPi,
         [](Model& m) {
             return subtract(m, {add_box(m, {-2, -2, -1}, {2, 2, 1}), add_cylinder(m, 1, -2, 2)});
         }},
        {"lens", 2 * kPi / 3 * 0.25 * 2.5,
         [](Model& m) {
             return intersect(m, {add_ball(m, {0, 0, -0.5}, 1), add_ball(m, {0, 0, 0.5}, 1)});
         }},
    };
}

}  // namespace

TEST_CASE("volumes of curved solids converge with order two") {
    const int last = environment_number("MORTISE_FULL_CONVERGENCE", 0) != 0 ? 7 : 6;
    for (const Solid& solid : curved_solids()) {
        for (const bool templates : {true, false}) {
            if (!templates && last < 7 && solid.name != std::string("torus")) continue;
            double count = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
            std::string errors;
            for (int level = 4; level <= last; ++level) {
                const Meshed result = mesh_and_check(one_solid(solid.build), level, templates);
                CHECK(result.defects == "");
                const double error = std::fabs(result.check.volume / solid.volume - 1);
                errors += std::to_string(error) + " ";
                const double x = std::log(result.report.cell_size), y = std::log(error);
                count += 1, sum_x += x, sum_y += y, sum_xx += x * x, sum_xy += x * y;
            }
            const double order = (count * sum_xy - sum_x * sum_y) / (count * sum_xx - sum_x * sum_x);
            CAPTURE(solid.name);
            CAPTURE(errors);
            CAPTURE(templates);
            CHECK(order >= 1.9);
        }
    }
}

}  // namespace mortise::test
