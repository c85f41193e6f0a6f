// Meshes of solids with creases and corners: every element good, every feature kept.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"

namespace mortise::test {
namespace {

/// The bounds that the documentation promises for creases between 30 and 330 degrees.
void check_bounds(const Meshed& m) {
    CHECK(m.defects == "");
    CHECK(m.check.nonmanifold_edges == 0);
    CHECK(m.check.min_dihedral >= 15);
    CHECK(m.check.max_dihedral <= 160);
    CHECK(worst_jacobian(m.check) >= 0.12);
}

Model turned(const Model& model, int pose) {
    const Vec3 axis = {std::sin(1.3 * pose + 0.4), std::cos(2.1 * pose), std::sin(3.7 * pose + 1.1)};
    return transformed(model, rotation(axis, 0.37 + 0.9 * pose));
}

/// In pose 41 a crease passes a grid vertex within a few thousandths of a cell.
TEST_CASE("boxes in many poses: good elements, eight exact corners, exact volume") {
    for (const int pose : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 20, 26, 41, 43}) {
        CAPTURE(pose);
        const Vec3 size = {1 + 0.01 * pose, 0.8, 1.3};
        const Affine map =
            rotation({std::sin(1.3 * pose + 0.4), std::cos(2.1 * pose), std::sin(3.7 * pose + 1.1)},
                     0.37 + 0.9 * pose);
        const Model box = transformed(one_solid([&](Model& m) { return add_box(m, {0, 0, 0}, size); }), map);
        const Meshed m = mesh_and_check(box, 4 + pose % 3);
        CHECK(m.defects == "");
        CHECK(m.check.nonmanifold_edges == 0);
        CHECK(m.check.euler_characteristic == 2);
        CHECK(m.check.volume == doctest::Approx(size[0] * size[1] * size[2]).epsilon(1e-7));
        for (int c = 0; c < 8; ++c) {
            const Vec3 corner = apply(map, {(c & 1) * size[0], ((c >> 1) & 1) * size[1], (c >> 2) * size[2]});
            CHECK(nearest_node(m.mesh, corner) < 1e-9);
        }
        CHECK(m.check.min_dihedral >= 17.9);
        CHECK(m.check.max_dihedral <= 155.1);
        CHECK(worst_jacobian(m.check) >= 0.199);
    }
}

TEST_CASE("cylinders in any pose: good elements, circles of the right length") {
    for (int pose = 0; pose < 4; ++pose) {
        CAPTURE(pose);
        const Model model = turned(one_solid([](Model& m) { return add_cylinder(m, 0.7, -1, 1); }), pose);
        MeshOptions options;
        options.level = 6;
        const Meshed m = mesh_and_check(model, options);
        check_bounds(m);
        CHECK(m.check.euler_characteristic == 2);
        CHECK(m.check.volume == doctest::Approx(kPi * 0.49 * 2).epsilon(4e-3));
        double length = 0;
        for (const auto& curve : m.report.features.curves) length += curve.length;
        CHECK(length == doctest::Approx(4 * kPi * 0.7).epsilon(1e-3));
    }
}

TEST_CASE("a block with a hole, a cut ball and crossing cylinders") {
    const Model drilled = one_solid([](Model& m) {
        return subtract(m, {add_box(m, {-1, -1, -1}, {1, 1, 1}), add_cylinder(m, 0.5, -2, 2)});
    });
    const Model cut = one_solid([](Model& m) {
        return subtract(m, {add_ball(m, {0, 0, 0}, 1), add_box(m, {0.2, -2, -2}, {2, 2, 2})});
    });
    const Model crossing = one_solid([](Model& m) {
        const NodeIndex other = m.add_transform(rotation({1, 0, 0}, kPi / 2), add_cylinder(m, 0.5, -1, 1));
        return unite(m, {add_cylinder(m, 0.7, -1, 1), other});
    });
    const Meshed drilled_mesh = mesh_and_check(turned(drilled, 1), 6);
    check_bounds(drilled_mesh);
    CHECK(drilled_mesh.check.euler_characteristic == 0);
    const Meshed cut_mesh = mesh_and_check(turned(cut, 2), 6);
    check_bounds(cut_mesh);
    CHECK(cut_mesh.check.euler_characteristic == 2);
    const Meshed crossing_mesh = mesh_and_check(turned(crossing, 3), 6);
    check_bounds(crossing_mesh);
    CHECK(crossing_mesh.check.euler_characteristic == 2);
}

TEST_CASE("the tip of a cone is there") {
    const Affine map = rotation({1, 2, 3}, 0.7);
    const Model cone = transformed(one_solid([](Model& m) { return add_frustum(m, 0.8, 0, 0, 1.5); }), map);
    const Meshed m = mesh_and_check(cone, 6);
    CHECK(m.defects == "");
    CHECK(nearest_node(m.mesh, apply(map, {0, 0, 1.5})) < 1e-9);
}

TEST_CASE("two regions: good elements on both sides of the interface, the same area from both") {
    const Model model = [] {
        Model m;
        m.source = "test model";
        const NodeIndex ball = add_ball(m, {0.1, 0.05, 0}, 0.6);
        const NodeIndex box = add_box(m, {-1, -1, -1}, {1, 1, 1});
        const NodeIndex hollow = subtract(m, {box, ball});
        add_region(m, ball, "ball");
        add_region(m, hollow, "rest");
        return m;
    }();
    const Meshed m = mesh_and_check(model, 5);
    CHECK(m.defects == "");
    CHECK(m.check.min_dihedral >= 15);
    CHECK(m.check.max_dihedral <= 160);
    CHECK(worst_jacobian(m.check) >= 0.12);
    CHECK(m.check.volume == doctest::Approx(8).epsilon(1e-9));
    CHECK(enclosed_volume(m.mesh, 1) == doctest::Approx(4 * kPi / 3 * 0.216).epsilon(2e-2));
}

TEST_CASE("improvement does not depend on threads, and never makes the worst element worse") {
    for (const std::uint64_t seed : {3, 11, 45, 60, 105}) {
        CAPTURE(seed);
        const Model model = make_random_model(seed).model;
        MeshOptions options;
        options.level = 5;
        options.improve = false;
        const Meshed plain = mesh_and_check(model, options);
        options.improve = true;
        options.threads = 1;
        const Meshed one = mesh_and_check(model, options);
        options.threads = 4;
        const Meshed four = mesh_and_check(model, options);
        CHECK(one.defects == "");
        CHECK(is_same_mesh(one.mesh, four.mesh));
        CHECK(worst_jacobian(one.check) >= 0.999 * std::min(0.2, worst_jacobian(plain.check)));
        options.smooth = 0;
        const Meshed still = mesh_and_check(model, options);
        CHECK(still.defects == "");
    }
}

}  // namespace
}  // namespace mortise::test
