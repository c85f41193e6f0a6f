// MeshOptions::min_angle: elements that are good enough already become better.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/common/constants.hpp"
#include "host/improve/improve.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

Model asset(const std::string& name) {
    return read_model(std::string(MORTISE_SOURCE_DIR) + "/assets/models/" + name + ".csg");
}

Model ball(double radius) {
    return one_solid([&](Model& model) { return add_ball(model, {0.1, -0.2, 0.3}, radius); });
}

MeshOptions options(int level, double min_angle, bool tetrahedra = false) {
    MeshOptions result;
    result.level = level;
    result.min_angle = min_angle;
    result.tetrahedra = tetrahedra;
    return result;
}

/// The largest angle that goes with a smallest one, by the definition of quality in improve/quality.hpp.
double largest_angle(double smallest) {
    const double radians = kPi / 180;
    return 180 - std::asin(std::sin(smallest * radians) * std::sin(25 * radians) / std::sin(18 * radians)) /
                     radians;
}

TEST_CASE("what good elements are split into is good, too") {
    for (const int level : {4, 5, 6}) {
        CAPTURE(level);
        const Meshed m = mesh_and_check(asset("bracket"), options(level, 18, true));
        CHECK(m.defects == "");
        CHECK(m.check.min_dihedral > 17.99);
        CHECK(m.check.min_scaled_jacobian[static_cast<std::size_t>(ElementType::kTetrahedron)] > 0.1999);
        CHECK(m.report.features.corners.size() == 12);
    }
}

TEST_CASE("the quality of an angle is its sine") {
    for (const double angle : {18.0, 25.0, 31.7, 35.0}) {
        CHECK(improve::quality_of_angle(angle) ==
              doctest::Approx(std::sin(angle * kPi / 180)).epsilon(1e-14));
    }
    CHECK(improve::quality_of_angle(18) == doctest::Approx(improve::kGoodQuality).epsilon(1e-4));
}

TEST_CASE("a ball: every angle that is asked for, as hexahedra and as tetrahedra") {
    for (const bool tetrahedra : {false, true}) {
        for (const double angle : {22.0, 26.0}) {
            CAPTURE(tetrahedra);
            CAPTURE(angle);
            const Meshed m = mesh_and_check(ball(7), options(4, angle, tetrahedra));
            CHECK(m.defects == "");
            CHECK(m.report.below_min_angle == 0);
            CHECK(m.check.min_dihedral >= angle - 0.01);
            CHECK(m.check.max_dihedral <= largest_angle(angle) + 0.1);
            CHECK(m.check.volume == doctest::Approx(4 * kPi / 3 * 343).epsilon(0.015));
            CHECK((m.mesh.elements[0].size() > 0) == !tetrahedra);
        }
    }
}

TEST_CASE("creases and corners: better elements, the same solid") {
    std::size_t cubes_before = 0, cubes_after = 0;
    for (const char* name : {"bracket", "object_x", "block"}) {
        CAPTURE(name);
        const Meshed before = mesh_and_check(asset(name), 5);
        const Meshed after = mesh_and_check(asset(name), options(5, 25));
        CHECK(after.defects == "");
        CHECK(before.check.min_dihedral < 20);
        CHECK(after.check.min_dihedral > 23);
        CHECK(after.check.max_dihedral < 148);
        // A few may be stuck.
        CHECK(after.report.below_min_angle * 1000 < after.mesh.element_count());
        CHECK(after.check.volume == doctest::Approx(before.check.volume).epsilon(5e-4));
        CHECK(after.check.euler_characteristic == before.check.euler_characteristic);
        CHECK(after.report.features.corners.size() == before.report.features.corners.size());
        cubes_before += before.mesh.elements[0].size();
        cubes_after += after.mesh.elements[0].size();
    }
    CHECK(static_cast<double>(cubes_after) > 0.7 * static_cast<double>(cubes_before));
}

// Pyramids at a zone's border, which no run of three mended: each left another one, of 16.6 degrees.
TEST_CASE("a wider zone mends what the borders of others held") {
    for (const double angle : {22.0, 25.0}) {
        CAPTURE(angle);
        const Meshed m = mesh_and_check(asset("bracket"), options(6, angle));
        CHECK(m.defects == "");
        CHECK(m.check.min_dihedral > angle - 0.1);
        CHECK(m.report.below_min_angle <= 1);
    }
}

TEST_CASE("asked for more than all elements can have, most come near it") {
    struct Case {
        double angle, low, high;  ///< what is asked, and the quantiles that are to be reached
    };
    // Without moves that help all elements of a star together the 1 % quantile was 37.4 degrees. With 44 both
    // are to be better than those of Netgen's mesh of this size, 38.4 and 115.8 (bench/quality.sh): they were
    // 39.1 and 118.2 with 40 as the most.
    for (const Case c : {Case{40, 38.5, 120}, Case{44, 40, 115.5}}) {
        CAPTURE(c.angle);
        MeshOptions o = options(5, c.angle, true);
        o.quality = true;
        const Meshed m = mesh_and_check(asset("bracket"), o);
        CHECK(m.defects == "");
        REQUIRE(m.report.quality.has_value());
        CHECK(m.report.quality->angles.low_percentile > c.low);
        CHECK(m.report.quality->angles.high_percentile < c.high);
        CHECK(m.check.min_dihedral > 30);
        CHECK(m.check.max_dihedral < 136);
        CHECK(m.report.below_min_angle > 0);
    }
}

TEST_CASE("larger angles leave cells between two sizes as they are") {
    // Their scaled Jacobians of 0.258 once counted: all of them, and the cubes around, became tetrahedra.
    MeshOptions o = options(5, 25);
    o.interior_coarsening = 3;
    const Meshed coarse = mesh_and_check(ball(7), o);
    o.min_angle = 18;
    const Meshed before = mesh_and_check(ball(7), o);
    CHECK(coarse.defects == "");
    CHECK(coarse.check.min_dihedral > 24.5);
    const auto hexahedra = [](const Meshed& m) { return m.mesh.elements[0].size(); };
    CHECK(hexahedra(coarse) > hexahedra(before) / 2);
    CHECK(coarse.mesh.element_count() < before.mesh.element_count() * 3 / 2);
}

TEST_CASE("what cannot be reached is counted") {
    // The model has an angle of ten degrees along 20 units, some fifteen cells.
    const Model wedge = parse_model(
        "rotate([10, 20, 30]) linear_extrude(height = 20) polygon([[0, 0], [40, 0], [40, 7.0531]]);", "csg",
        "wedge.csg");
    const Meshed m = mesh_and_check(wedge, options(5, 25));
    CHECK(m.defects == "");
    CHECK(m.report.below_min_angle > 10);
    CHECK(m.report.below_min_angle < m.mesh.element_count() / 10);
    CHECK(std::any_of(m.report.warnings.begin(), m.report.warnings.end(), [&](const std::string& w) {
        return w.find(std::to_string(m.report.below_min_angle) + " elements are worse than asked") == 0;
    }));
    CHECK(mesh_and_check(wedge, 5).report.below_min_angle == 0);
}

TEST_CASE("raised meshes do not depend on threads or pieces, graded ones neither") {
    for (const bool graded : {false, true}) {
        CAPTURE(graded);
        MeshOptions o = options(4, 27);
        if (graded) o.sizes.push_back({{0, 0, 0}, 0.2, 0.5});
        o.threads = 1;
        const Meshed one = mesh_and_check(asset("bracket"), o);
        CHECK(one.defects == "");
        o.threads = 3;
        o.pieces = graded ? 1 : 5;
        CHECK(is_same_mesh(mesh_and_check(asset("bracket"), o).mesh, one.mesh));
    }
}

TEST_CASE("thin walls keep their volume when the quality of their elements is raised") {
    const double cell = 20.0 / 15;
    for (const double thickness : {0.02, 0.3, 0.6}) {
        CAPTURE(thickness);
        const double inner = 10 - thickness * cell;
        const Meshed m = mesh_and_check(
            one_solid([&](Model& model) {
                return subtract(model, {add_ball(model, {0, 0, 0}, 10), add_ball(model, {0, 0, 0}, inner)});
            }),
            options(4, 32));
        CHECK(m.defects == "");
        CHECK(m.check.euler_characteristic == 4);
        const double expected = 4 * kPi / 3 * (1000 - inner * inner * inner);
        CHECK(m.check.volume > 0.9 * expected);
        CHECK(m.check.volume < 1.25 * expected);
    }
}

TEST_CASE("angles out of range, and angles without improvement, are refused") {
    MeshOptions o = options(4, 45);
    CHECK_THROWS_WITH(generate_mesh(ball(7), o),
                      "min_angle (--min-angle) 45 is out of range; use 18 to 44 degrees");
    o.min_angle = 25;
    o.improve = false;
    CHECK_THROWS_WITH(generate_mesh(ball(7), o),
                      doctest::Contains("elements reach larger angles by being improved only"));
}

}  // namespace
}  // namespace mortise::test
