// Meshes of moved, scaled and mirrored models: the same up to rounding and up to ties.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

/// Nothing in it is parallel to the axes or symmetric, except by the map that a test applies.
Model plain_model() {
    return one_solid([](Model& m) {
        const NodeIndex block =
            m.add_transform(rotation({1, 2, 3}, 0.8), add_box(m, {-2, -1.5, -1}, {2, 1.5, 1}));
        const NodeIndex hole = m.add_transform(rotation({2, -1, 1}, 0.5), add_cylinder(m, 0.61, -4, 4));
        return unite(m, {subtract(m, {block, hole}), add_ball(m, {1.13, 0.91, 1.27}, 0.83)});
    });
}

/// A box around the model fixes the grid: the bounds that the mesher finds by itself follow no symmetry.
Meshed mesh_in_box(const Model& model, const Vec3& centre, int level, bool improve = true) {
    constexpr double kHalf = 3.5;
    MeshOptions options;
    options.level = level;
    options.improve = improve;
    options.box = Box3{{centre[0] - kHalf, centre[1] - kHalf, centre[2] - kHalf},
                       {centre[0] + kHalf, centre[1] + kHalf, centre[2] + kHalf}};
    return mesh_and_check(model, options);
}

}  // namespace

TEST_CASE("a power of two as scale changes nothing but the scale") {
    const Model model = plain_model();
    const Meshed plain = mesh_and_check(model, 5);
    for (const double scale : {0x1p-12, 8.0, 0x1p20}) {
        CAPTURE(scale);
        Meshed scaled = mesh_and_check(transformed(model, scaling({scale, scale, scale})), 5);
        for (double& coordinate : scaled.mesh.points) coordinate /= scale;
        CHECK(is_same_mesh(scaled.mesh, plain.mesh));
    }
}

TEST_CASE("a translation moves the mesh") {
    const Model model = plain_model();
    const Meshed plain = mesh_in_box(model, {0, 0, 0}, 5, false);
    const Vec3 by = {3.7, -11.3, 0.9};
    const Meshed moved = mesh_in_box(transformed(model, translation(by)), by, 5, false);
    CHECK(moved.defects == "");
    REQUIRE(moved.mesh.node_count() == plain.mesh.node_count());
    CHECK(moved.check.elements == plain.check.elements);
    double largest = 0;
    for (std::size_t i = 0; i < plain.mesh.points.size(); ++i) {
        largest = std::max(largest, std::fabs(moved.mesh.points[i] - plain.mesh.points[i] - by[i % 3]));
    }
    CHECK(largest < 1e-7 * plain.report.cell_size);
    // Improvement chooses between changes of nearly equal worth, which rounding may turn.
    const Meshed plain_improved = mesh_in_box(model, {0, 0, 0}, 5);
    const Meshed moved_improved = mesh_in_box(transformed(model, translation(by)), by, 5);
    CHECK(moved_improved.defects == "");
    CHECK(moved_improved.check.euler_characteristic == plain_improved.check.euler_characteristic);
    CHECK(moved_improved.check.volume == doctest::Approx(plain_improved.check.volume).epsilon(1e-3));
}

TEST_CASE("the 48 symmetries of the cube keep cells, topology and volume") {
    const Model model = plain_model();
    const Meshed plain = mesh_in_box(model, {0, 0, 0}, 4);
    const Meshed unimproved = mesh_in_box(model, {0, 0, 0}, 4, false);
    CHECK(plain.defects == "");
    std::size_t order[3] = {0, 1, 2};
    do {
        for (int mirror = 0; mirror < 8; ++mirror) {
            Affine map{};
            for (std::size_t i = 0; i < 3; ++i) map[4 * i + order[i]] = (mirror >> i) & 1 ? -1 : 1;
            CAPTURE(order[0]);
            CAPTURE(order[1]);
            CAPTURE(mirror);
            const Meshed image = mesh_in_box(transformed(model, map), {0, 0, 0}, 4);
            CHECK(image.defects == "");
            CHECK(image.report.in_cells == plain.report.in_cells);
            CHECK(image.report.nio_cells == plain.report.nio_cells);
            CHECK(image.check.euler_characteristic == plain.check.euler_characteristic);
            const Meshed image_unimproved = mesh_in_box(transformed(model, map), {0, 0, 0}, 4, false);
            CHECK(image_unimproved.check.volume == doctest::Approx(unimproved.check.volume).epsilon(3e-3));
            CHECK(image_unimproved.check.boundary_area ==
                  doctest::Approx(unimproved.check.boundary_area).epsilon(3e-3));
            // The hole's radius is 1.2 cells: chords cost 0.9 % of the volume at most.
            CHECK(image.check.volume == doctest::Approx(plain.check.volume).epsilon(6e-3));
            CHECK(image.check.boundary_area == doctest::Approx(plain.check.boundary_area).epsilon(6e-3));
        }
    } while (std::next_permutation(std::begin(order), std::end(order)));
}

TEST_CASE("a solid and its complement share their surface and fill the box") {
    Model model = plain_model();
    const NodeIndex solid = model.regions[0].root;
    const NodeIndex around = add_box(model, {-4, -4, -4}, {4, 4, 4});
    Model both = add_region(model, around, "rest");
    Model rest_only = both;
    rest_only.regions = {both.regions[1]};
    rest_only.regions[0].root = subtract(rest_only, {around, solid});

    const Meshed two = mesh_and_check(both, 5);
    const Meshed rest = mesh_and_check(rest_only, 5);
    CHECK(two.defects == "");
    CHECK(rest.defects == "");
    CHECK(two.check.region_volume[0] + two.check.region_volume[1] == doctest::Approx(512).epsilon(1e-9));
    CHECK(rest.check.volume == doctest::Approx(two.check.region_volume[1]).epsilon(1e-4));
    CHECK(facet_area(rest.mesh, 1, 0) - 384 == doctest::Approx(facet_area(two.mesh, 1, 2)).epsilon(1e-2));
}

}  // namespace mortise::test
