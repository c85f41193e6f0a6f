// Meshes of solids given by triangles.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/mesher/meshed.hpp"
#include "tests/triangles/shapes.hpp"

namespace mortise::test {

TEST_CASE("a cube of triangles has the mesh of a cube") {
    const Meshed triangles = mesh_and_check(solid_of(prism({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, 2), 0), 4);
    const Meshed planes = mesh_and_check(one_solid([](Model& m) {
                                             return add_box(m, {0, 0, 0}, {2, 2, 2});
                                         }),
                                         4);
    CHECK(triangles.defects.empty());
    CHECK(triangles.mesh.points == planes.mesh.points);
    CHECK(triangles.mesh.elements[0].nodes == planes.mesh.elements[0].nodes);
}

TEST_CASE("flat faces are exact: the L block") {
    for (const Affine& map : {kIdentity, rotation({1, 2, 3}, 0.7), scaling({-1, 1, 1})}) {
        const Meshed m = mesh_and_check(solid_of(l_block(), 0, map), 5);
        CHECK(m.defects.empty());
        CHECK(m.check.volume == doctest::Approx(5).epsilon(1e-7));
        CHECK(m.check.boundary_area == doctest::Approx(22).epsilon(1e-7));
        CHECK(m.report.unresolved == 0);
        for (const Vec3& corner : l_block().points) CHECK(nearest_node(m.mesh, apply(map, corner)) < 1e-8);
    }
}

TEST_CASE("surfaces are named after groups, or numbered") {
    const Meshed named = mesh_and_check(solid_of(prism({{0, 0}, {2, 0}, {3, 2}, {0, 2}}, 2, true), 0), 4);
    CHECK(named.mesh.surface_names == std::vector<std::string>{"part_bottom", "part_top", "part_side"});
    const Meshed numbered = mesh_and_check(solid_of(l_block(), 0), 4);
    CHECK(numbered.mesh.surface_names.size() == 8);
    CHECK(numbered.mesh.surface_names[0] == "part_face1");
}

TEST_CASE("random stars: valid, the right volume") {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        const TriangleSurface star = random_star(seed, 1, 0.6, 1.4);
        const Meshed m = mesh_and_check(solid_of(star, 0), 5);
        CHECK(m.defects.empty());
        CHECK(m.check.volume == doctest::Approx(volume_of(star)).epsilon(2e-3));
        const Meshed certified = mesh_and_check(solid_of(star, 0), 4, false);
        CHECK(certified.defects.empty());
    }
}

TEST_CASE("a smooth surface of triangles meshes like a smooth solid") {
    const TriangleSurface sphere = unit_sphere(4);
    const Meshed m = mesh_and_check(solid_of(sphere, 30), 5);
    CHECK(m.defects.empty());
    CHECK(m.check.min_dihedral > 17.5);
    CHECK(m.check.max_dihedral < 155.5);
    CHECK(m.check.volume == doctest::Approx(volume_of(sphere)).epsilon(5e-3));
    CHECK(m.report.unresolved == 0);
}

TEST_CASE("patches meet in sharp creases: a round post of triangles") {
    std::vector<std::array<double, 2>> outline;
    for (int i = 0; i < 64; ++i) {
        outline.push_back({std::cos(i * 0.09817477042468103), std::sin(i * 0.09817477042468103)});
    }
    const TriangleSurface post = prism(outline, 1.7, true);
    const Meshed m = mesh_and_check(solid_of(post, 20, rotation({1, 2, 3}, 0.7)), 5);
    CHECK(m.defects.empty());
    CHECK(m.check.volume == doctest::Approx(volume_of(post)).epsilon(2e-3));
    CHECK(m.check.min_dihedral > 12);
    double length = 0;
    for (const auto& curve : m.report.features.curves) length += curve.length;
    CHECK(length == doctest::Approx(4 * std::acos(-1.0)).epsilon(5e-3));
}

TEST_CASE("faces that are left out of crowded cells are told") {
    const Model model = solid_of(random_star(2, 3, 0.9, 1.1), 0);
    const Meshed coarse = mesh_and_check(model, 3);
    CHECK(coarse.defects.empty());
    REQUIRE_FALSE(coarse.report.warnings.empty());
    CHECK(coarse.report.warnings[0].find("more faces of triangles") != std::string::npos);
    MeshOptions strict;
    strict.level = 3;
    strict.strict = true;
    CHECK_THROWS_AS(generate_mesh(model, strict), Error);
}

TEST_CASE("surfaces with holes, and triangles that overlap, make valid meshes") {
    TriangleSurface open = unit_sphere(3);
    open.triangles.erase(open.triangles.begin() + 100, open.triangles.begin() + 110);
    for (const double sharp : {0.0, 30.0}) {
        for (const bool templates : {true, false}) {
            CAPTURE(sharp);
            CAPTURE(templates);
            CHECK(mesh_and_check(solid_of(open, sharp), 4, templates).defects.empty());
        }
    }
    TriangleSurface bowl = unit_sphere(3);
    bowl.triangles.resize(bowl.triangles.size() / 2);
    Model half = solid_of(bowl, 30);
    CHECK(mesh_and_check(half, 4).defects.empty());
}

TEST_CASE("set operations with primitives; the same bytes for any threads and pieces") {
    Model model = solid_of(random_star(3, 2, 0.8, 1.2), 40);
    const auto hole = add_cylinder(model, 0.3, -2, 2);
    model.regions[0].root = subtract(model, {model.regions[0].root, hole});
    MeshOptions options;
    options.level = 5;
    options.threads = 1;
    const Meshed one = mesh_and_check(model, options);
    CHECK(one.defects.empty());
    options.threads = 3;
    options.pieces = 5;
    options.work_group_size = 4;
    CHECK(is_same_mesh(one.mesh, mesh_and_check(model, options).mesh));
}

}  // namespace mortise::test
