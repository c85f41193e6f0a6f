// Poles of pairs of surfaces against closed forms.
#include "host/tape/pole.hpp"
#include "host/common/constants.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

std::vector<std::uint32_t> surfaces_of_kind(const tape::BoundModel& model, std::int32_t kind) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t s = 0; s < model.surfaces.size(); ++s) {
        if (model.surfaces[s].kind == kind) found.push_back(s);
    }
    return found;
}

Vec3 to_local(const tape::BoundModel& model, const Vec3& x) {
    Vec3 local{};
    for (std::size_t j = 0; j < 3; ++j) local[j] = (x[j] - model.origin[j]) / model.side;
    return local;
}

Model two_pipes(double radius, double other, double angle, const Affine& pose) {
    Model model;
    const Affine lie = rotation({0, 1, 0}, kPi / 2);
    const NodeIndex first = model.add_transform(lie, add_cylinder(model, radius, -3, 3));
    const NodeIndex second =
        model.add_transform(compose(rotation({0, 0, 1}, angle), lie), add_cylinder(model, other, -3, 3));
    add_region(model, model.add_transform(pose, unite(model, {first, second})), "pipes");
    return model;
}

Affine random_pose(RandomSource& random) {
    return compose(translation({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}),
                   rotation({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                            random.uniform(0, 2 * kPi)));
}

}  // namespace

TEST_CASE("poles of two pipes of one radius, from starts all around them") {
    RandomSource random(3);
    for (int i = 0; i < 50; ++i) {
        CAPTURE(i);
        const double angle = random.uniform(0.3, kPi - 0.3);
        const Affine pose = random_pose(random);
        const tape::BoundModel model = bind_model(two_pipes(1, 1, angle, pose), 5);
        const auto pipes = surfaces_of_kind(model, kSurfaceQuadric);
        REQUIRE(pipes.size() == 2);
        const Vec3 pole = to_local(model, apply(pose, {0, 0, 1}));
        const double reach = 1.0 / 32;
        for (int k = 0; k < 10; ++k) {
            Vec3 start = pole;
            for (double& x : start) x += random.uniform(-0.4, 0.4) * reach;
            tape::Pole found;
            REQUIRE(tape::find_pole(model, pipes[0], pipes[1], start, reach, &found));
            CHECK(std::hypot(found.at[0] - pole[0], found.at[1] - pole[1], found.at[2] - pole[2]) < 1e-12);
            CHECK(found.surfaces == pipes);
        }
        tape::Pole found;
        const Vec3 far = to_local(model, apply(pose, {0, 0.5, 0.9}));
        CHECK_FALSE(tape::find_pole(model, pipes[0], pipes[1], far, reach, &found));
    }
}

TEST_CASE("pipes of nearly one radius have no pole") {
    const tape::BoundModel model = bind_model(two_pipes(1, 1 - 1e-7, 1.2, rotation({1, 1, 1}, 0.3)), 5);
    const auto pipes = surfaces_of_kind(model, kSurfaceQuadric);
    REQUIRE(pipes.size() == 2);
    const Vec3 near = to_local(model, apply(rotation({1, 1, 1}, 0.3), {0, 0, 1}));
    tape::Pole found;
    CHECK_FALSE(tape::find_pole(model, pipes[0], pipes[1], near, 1.0 / 32, &found));
}

TEST_CASE("a plane tangent to a torus: a pole at its inner rim, none at its outer rim or on top") {
    Model model;
    const NodeIndex torus = add_torus(model, 2, 0.5);
    const NodeIndex box = add_box(model, {1.5, -2.5, -1}, {2.5, 2.5, 0.5});
    add_region(model, unite(model, {torus, box}), "both");
    const tape::BoundModel bound = bind_model(model, 5);
    const auto tori = surfaces_of_kind(bound, kSurfaceTorus);
    REQUIRE(tori.size() == 1);
    const auto poles_at = [&](const Vec3& x) {
        int count = 0;
        for (const std::uint32_t plane : surfaces_of_kind(bound, kSurfacePlane)) {
            tape::Pole pole;
            if (tape::find_pole(bound, plane, tori[0], to_local(bound, x), 1.0 / 32, &pole)) ++count;
        }
        return count;
    };
    CHECK(poles_at({1.5, 0.01, 0.02}) == 1);
    CHECK(poles_at({2.5, 0.01, 0.02}) == 0);  // the plane touches in one point
    CHECK(poles_at({2, 0.01, 0.5}) == 0);     // along a circle
}

}  // namespace mortise::test
