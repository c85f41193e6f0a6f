// Meshes of solids given by triangles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/model/triangle_measures.hpp"
#include "tests/triangles/shapes.hpp"

namespace mortise::test {
namespace {

/// A cube less a tilted box, as OpenSCAD writes it: one face of the box meets the top at 22 degrees.
const char* const kTiltedPocket =
    "OFF 22 40 0\n"
    "20 0 20\n20 20 0\n20 20 20\n20 0 0\n17.9753 8.95659 20\n18.031 7.78604 20\n"
    "18.0576 7.22758 20\n12.6759 18.1354 20\n8.11401 15.856 20\n0 20 20\n1.9424 12.7724 20\n"
    "11.886 4.14395 20\n7.32412 1.86463 20\n1.96899 12.214 20\n2.02474 11.0434 20\n0 0 20\n"
    "0 0 0\n0 20 0\n18.6642 7.57778 19.7451\n16.393 7.46961 14.1926\n11.1014 18.0604 16.1507\n"
    "6.62746 1.83145 18.2968\n3 0 1 2\n3 1 0 3\n3 4 0 2\n3 0 5 6\n3 0 4 5\n3 2 7 4\n3 8 9 10\n"
    "3 7 9 8\n3 9 7 2\n3 11 0 6\n3 12 0 11\n3 9 13 10\n3 9 14 13\n3 12 15 0\n3 14 15 12\n"
    "3 15 14 9\n3 16 1 3\n3 1 16 17\n3 16 9 17\n3 9 16 15\n3 1 9 2\n3 9 1 17\n3 16 0 15\n"
    "3 0 16 3\n3 18 6 5\n3 19 6 18\n3 6 19 11\n3 18 5 4\n3 20 7 8\n3 20 4 7\n3 4 20 18\n"
    "3 19 18 20\n3 20 8 10\n3 20 13 19\n3 13 20 10\n3 12 21 14\n3 19 14 21\n3 14 19 13\n"
    "3 11 21 12\n3 21 11 19\n";

}  // namespace

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

TEST_CASE("no loose piece beside a letter whose outline comes close to a cell") {
    const Model model = parse_model(
        "multmatrix([[0.960779, 0.108355, 0.255269, 0], [0, 0.920505, -0.390731, 0], "
        "[-0.277315, 0.375406, 0.884402, 0], [0, 0, 0, 1]]) { cube([40, 12, 2]); "
        "multmatrix([[1, 0, 0, 20], [0, 1, 0, 6], [0, 0, 1, 1.5], [0, 0, 0, 1]]) linear_extrude(height = "
        "1.5) "
        "text(text = \"is\", size = 5, halign = \"center\", valign = \"center\"); }",
        "csg", "plate.csg");
    MeshOptions options;
    options.level = 6;
    options.refine = 1;
    options.improve = false;
    const Meshed m = mesh_and_check(model, options);
    CHECK(m.defects.empty());
    CHECK(m.check.components == 1);
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
        CHECK(m.check.volume == doctest::Approx(volume(star)).epsilon(2e-3));
        const Meshed certified = mesh_and_check(solid_of(star, 0), 4, false);
        CHECK(certified.defects.empty());
    }
}

TEST_CASE("rugged stars whose triangles make curved patches: what bulges through an edge cuts no pyramid") {
    std::size_t curved = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        CAPTURE(seed);
        MeshOptions options;
        options.level = 4;
        options.improve = false;
        const Meshed m = mesh_and_check(solid_of(random_star(seed, 2, 0.75, 1.3), 30), options);
        CHECK(m.defects == "");
        curved += m.mesh.surface_names.size() < 128 ? 1 : 0;
    }
    CHECK(curved == 30);
}

TEST_CASE("rugged stars and cones: nodes of a face move with its own corners, for both cells") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        Model model = solid_of(random_star(seed, 2, 0.8, 1.25), 30);
        const std::uint32_t cone =
            add_frustum(model, random.uniform(0.4, 0.8), random.uniform(0.4, 0.8), -2, 2);
        const std::uint32_t turned = model.add_transform(
            rotation({random.uniform(-1, 1), random.uniform(-1, 1), 1}, random.uniform(0, 3)), cone);
        model.regions[0].root = seed % 2 == 0 ? unite(model, {model.regions[0].root, turned})
                                              : subtract(model, {model.regions[0].root, turned});
        MeshOptions options;
        options.level = 4;
        options.improve = false;
        CHECK(mesh_and_check(model, options).defects == "");
    }
}

TEST_CASE("vertices beside creases of triangles snap as beside those of other solids") {
    std::uint64_t poor[3] = {};  // of triangles, of planes, of triangles without snapping
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        const Affine turn = rotation({random.uniform(-1, 1), random.uniform(-1, 1), 1}, random.uniform(0, 3));
        const Model triangles = solid_of(l_block(), 0, turn);
        const Model planes = transformed(
            one_solid([](Model& m) {
                return unite(m, {add_box(m, {0, 0, 0}, {3, 1, 1}), add_box(m, {0, 0, 0}, {1, 3, 1})});
            }),
            turn);
        MeshOptions options;
        options.level = 5;
        options.improve = false;
        for (int i = 0; i < 3; ++i) {
            options.snap = i < 2;
            const Meshed m = mesh_and_check(i == 1 ? planes : triangles, options);
            CHECK(m.defects == "");
            CHECK(m.check.volume == doctest::Approx(5).epsilon(1e-7));
            const auto& jacobians = m.report.scaled_jacobians;
            poor[i] += static_cast<std::uint64_t>(
                std::count_if(jacobians.begin(), jacobians.end(), [](float x) { return x < 0.2f; }));
        }
    }
    MESSAGE("poor elements: ", poor[0], ", of planes ", poor[1], ", without snapping ", poor[2]);
    CHECK(10 * poor[0] < 11 * poor[1]);
    CHECK(7 * poor[0] < poor[2]);
}

TEST_CASE("a smooth surface of triangles meshes like a smooth solid") {
    const TriangleSurface sphere = unit_sphere(4);
    const Meshed m = mesh_and_check(solid_of(sphere, 30), 5);
    CHECK(m.defects.empty());
    CHECK(m.check.min_dihedral > 17.5);
    CHECK(m.check.max_dihedral < 155.5);
    CHECK(m.check.volume == doctest::Approx(volume(sphere)).epsilon(5e-3));
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
    CHECK(m.check.volume == doctest::Approx(volume(post)).epsilon(2e-3));
    CHECK(m.check.min_dihedral > 12);
    double length = 0;
    for (const auto& curve : m.report.features.curves) length += curve.length;
    CHECK(length == doctest::Approx(4 * std::acos(-1.0)).epsilon(5e-3));
}

TEST_CASE("flat faces that meet at a small angle are no curved surface") {
    const Model model = parse_model(kTiltedPocket, "off", "pocket.off");
    for (const int level : {4, 5}) {
        CAPTURE(level);
        const Meshed m = mesh_and_check(model, level);
        CHECK(m.defects == "");
        CHECK(m.check.euler_characteristic == 2);
        CHECK(m.check.components == 1);
        CHECK(m.report.dropped_features == 0);
        CHECK(m.report.hinge_edges + m.report.hinge_nodes == 0);
        // By the divergence theorem on the file's triangles.
        CHECK(m.check.volume == doctest::Approx(7568.0).epsilon(1e-4));
        CHECK(*std::min_element(m.report.scaled_jacobians.begin(), m.report.scaled_jacobians.end()) > 0.1F);
    }
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
    CHECK_THROWS_AS(generate(model, strict), Error);
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

TEST_CASE("open stars: leaves whose neighbours do not agree bear their moved vertices") {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        TriangleSurface star = random_star(seed, 2, 0.85, 1.15);
        for (int holes = 2; holes > 0; --holes) {
            const auto first = static_cast<std::ptrdiff_t>(random.uniform(0, 120));
            star.triangles.erase(star.triangles.begin() + first, star.triangles.begin() + first + 3);
        }
        Model model = solid_of(star, 30);
        const std::uint32_t cone =
            add_frustum(model, random.uniform(0.4, 0.6), random.uniform(0.4, 0.6), -1.5, 1.5);
        const std::uint32_t turned = model.add_transform(
            rotation({random.uniform(-1, 1), random.uniform(-1, 1), 1}, random.uniform(0, 3)), cone);
        model.regions[0].root = subtract(model, {model.regions[0].root, turned});
        MeshOptions options;
        options.level = 4;
        options.improve = false;
        CHECK(mesh_and_check(model, options).defects == "");
    }
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
