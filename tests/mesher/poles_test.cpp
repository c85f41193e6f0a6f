// Poles: points where two creases of the same two surfaces cross (host/tape/pole.hpp).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr double kRadius = 10;

Affine random_pose(RandomSource& random) {
    const Vec3 axis = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const Vec3 by = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
    return compose(translation(by), rotation(axis, random.uniform(0, 2 * kPi)));
}

/// A cylinder of kRadius along an axis in the xy plane, at this angle to the x axis.
NodeIndex add_pipe(Model& model, double angle, double low, double high) {
    const Affine lie = rotation({0, 1, 0}, kPi / 2);
    return model.add_transform(compose(rotation({0, 0, 1}, angle), lie),
                               add_cylinder(model, kRadius, low, high));
}

/// Length of the ellipse with these half axes, by its integral.
double ellipse_length(double a, double b) {
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double t = 2 * kPi * (i + 0.5) / kSteps;
        sum += std::hypot(a * std::sin(t), b * std::cos(t)) * 2 * kPi / kSteps;
    }
    return sum;
}

/// Both poles are nodes and corners of the mesh.
void check_poles(const Meshed& m, const Affine& pose) {
    for (const double side : {-kRadius, kRadius}) {
        const Vec3 pole = apply(pose, {0, 0, side});
        CHECK(nearest_node(m.mesh, pole) < 1e-9 * 40);
        const auto& corners = m.report.features.corners;
        CHECK(std::count_if(corners.begin(), corners.end(), [&](const FeatureCorner& c) {
                  const double* p = m.mesh.points.data() + 3 * std::size_t{c.node};
                  return std::hypot(p[0] - pole[0], p[1] - pole[1], p[2] - pole[2]) < 1e-6;
              }) == 1);
    }
}

double crease_length(const Meshed& m) {
    double length = 0;
    for (const FeatureCurve& curve : m.report.features.curves) length += curve.length;
    return length;
}

}  // namespace

TEST_CASE("two pipes of one radius: four creases from pole to pole, in any pose") {
    RandomSource random(1);
    int incomplete = 0;
    for (int i = 0; i < 12; ++i) {
        CAPTURE(i);
        const double angle = kPi / (i % 3 == 0 ? 3 : 2);
        const Affine pose = i == 0 ? translation({0, 0, 0}) : random_pose(random);
        const Model model = one_solid([&](Model& m) {
            return m.add_transform(pose,
                                   intersect(m, {add_pipe(m, 0, -40, 40), add_pipe(m, angle, -40, 40)}));
        });
        const Meshed m = mesh_and_check(model, 5 + i % 2);
        CHECK(m.defects == "");
        CHECK(m.check.euler_characteristic == 2);
        check_poles(m, pose);
        CHECK(m.report.features.curves.size() == 4);
        CHECK(m.check.min_dihedral >= 17);
        CHECK(worst_jacobian(m.check) >= 0.19);
        // At one of some sixty poles two creases end early (docs/design/limits.md).
        if (m.report.features.corners.size() != 2) {
            ++incomplete;
            continue;
        }
        // Two ellipses, in the planes that halve the angles between the axes.
        const double length = ellipse_length(kRadius, kRadius / std::sin(angle / 2)) +
                              ellipse_length(kRadius, kRadius / std::cos(angle / 2));
        CHECK(crease_length(m) == doctest::Approx(length).epsilon(3e-3));
    }
    CHECK(incomplete <= 1);
}

TEST_CASE("a tee of equal pipes: the branch ends in a plane through the poles") {
    for (int i = 0; i < 4; ++i) {
        CAPTURE(i);
        RandomSource random(static_cast<std::uint64_t>(i));
        const Affine pose = i == 0 ? translation({0, 0, 0}) : random_pose(random);
        const Model model = one_solid([&](Model& m) {
            return m.add_transform(pose, unite(m, {add_pipe(m, 0, -30, 30), add_pipe(m, kPi / 2, 0, 40)}));
        });
        const Meshed m = mesh_and_check(model, 6);
        CHECK(m.defects == "");
        check_poles(m, pose);
        CHECK(m.report.features.corners.size() == 2);
        if (i == 0) CHECK(m.report.warnings.empty());  // poles on an edge of the grid
        // Two half ellipses and the three open ends.
        const double length = ellipse_length(kRadius, std::sqrt(2.0) * kRadius) + 6 * kPi * kRadius;
        CHECK(crease_length(m) == doctest::Approx(length).epsilon(1e-3));
        CHECK(worst_jacobian(m.check) >= 0.19);
    }
}

TEST_CASE("a plane at a torus's inner rim cuts it along an eight") {
    RandomSource random(5);
    const Affine pose = random_pose(random);
    const Model model = one_solid([&](Model& m) {
        return m.add_transform(pose,
                               intersect(m, {add_torus(m, 20, 7), add_box(m, {13, -40, -40}, {40, 40, 40})}));
    });
    const Meshed m = mesh_and_check(model, 6);
    CHECK(m.defects == "");
    const Vec3 pole = apply(pose, {13, 0, 0});
    CHECK(nearest_node(m.mesh, pole) < 1e-9 * 60);
    REQUIRE(m.report.features.corners.size() == 1);
    CHECK(m.report.features.curves.size() == 2);
    CHECK(worst_jacobian(m.check) >= 0.19);
}

TEST_CASE("the same mesh at poles for any threads, work-group size and pieces") {
    const Model model = one_solid([](Model& m) {
        return m.add_transform(rotation({1, 2, 3}, 0.7),
                               intersect(m, {add_pipe(m, 0, -40, 40), add_pipe(m, kPi / 2, -40, 40)}));
    });
    MeshOptions options;
    options.level = 5;
    const Mesh whole = generate(model, options);
    options.pieces = 7;
    options.threads = 1;
    options.work_group_size = 8;
    CHECK(is_same_mesh(whole, generate(model, options)));
}

TEST_CASE("contacts that are no poles: one inside the other, along a line, pipes of two radii") {
    const auto corners = [](const Model& model) {
        const Meshed m = mesh_and_check(model, 5);
        CHECK(m.defects == "");
        return m.report.features.corners.size();
    };
    // A ball against the inside of a pipe's wall touches in a point, a pipe along a plane in a line.
    CHECK(corners(one_solid([](Model& m) {
              return unite(m, {add_pipe(m, 0, -20, 20),
                               m.add_transform(translation({0, 0, 5}), add_ball(m, Vec3{0, 0, 0}, 5))});
          })) == 0);
    CHECK(corners(one_solid([](Model& m) {
              return unite(m, {add_pipe(m, 0, -20, 20), add_box(m, {-20, -10, -10}, {20, 10, 0})});
          })) == 4);
    CHECK(corners(one_solid([](Model& m) {
              return unite(m, {add_pipe(m, 0, -30, 30),
                               m.add_transform(rotation({1, 0, 0}, kPi / 2), add_cylinder(m, 9, -30, 30))});
          })) == 0);
}

}  // namespace mortise::test
