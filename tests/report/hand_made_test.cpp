// Features and the whole report of a cube made by hand, whole and damaged.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/report/hand_made.hpp"

using namespace mortise;
using test::cube_of_cubes;
using test::HandMade;

namespace {

NodeId node_at(const Mesh& mesh, const Vec3& p) {
    for (NodeId i = 0; i < mesh.node_count(); ++i) {
        if (std::equal(p.begin(), p.end(), mesh.points.begin() + 3 * static_cast<std::ptrdiff_t>(i)))
            return i;
    }
    FAIL("no such node");
    return 0;
}

}  // namespace

TEST_CASE("nodes of a cube by the number of its planes through them") {
    const int n = 4;
    const HandMade made = cube_of_cubes(n);
    REQUIRE(made.facet_surface.size() == made.mesh.facets.size());
    const Features features = made.features();
    for (std::size_t i = 0; i < made.mesh.node_count(); ++i) {
        int planes = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const double x = made.mesh.points[3 * i + j];
            planes += x == 0 || x == n ? 1 : 0;
        }
        CHECK(int{features.model_dimension[i]} == 3 - planes);
    }
    CHECK(features.corners.size() == 8);
    REQUIRE(features.curves.size() == 12);
    for (const FeatureCurve& curve : features.curves) {
        CHECK_FALSE(curve.closed);
        CHECK(curve.nodes.size() == n + 1);
        CHECK(curve.length == doctest::Approx(n));
        CHECK(curve.model_angle == doctest::Approx(90));
        CHECK(curve.surfaces[0] < curve.surfaces[1]);
        CHECK(curve.name ==
              made.mesh.surface_names[curve.surfaces[0]] + "+" + made.mesh.surface_names[curve.surfaces[1]]);
        CHECK(features.model_dimension[curve.nodes.front()] == 0);
        CHECK(features.model_dimension[curve.nodes.back()] == 0);
    }
}

TEST_CASE("the whole report of a perfect cube") {
    const HandMade made = cube_of_cubes(4);
    const QualityReport report = made.assess(3);
    CHECK(report.cell_size == doctest::Approx(1));
    CHECK(report.mesh_to_model.samples > 96 * 9);
    CHECK(report.mesh_to_model.maximum < 1e-14 * 8);
    CHECK(report.model_to_mesh.samples >= 96);
    CHECK(report.model_to_mesh.maximum < 1e-11);
    CHECK(report.max_normal_angle < 1e-10);
    CHECK(report.corners_expected == 8);
    CHECK(report.corners_found == 8);
    CHECK(report.corners_extra == 0);
    CHECK(report.missing.empty());
    CHECK(report.crease_length == doctest::Approx(48));
    REQUIRE(report.surfaces.size() == 6);
    for (const SurfaceFigures& surface : report.surfaces) {
        CHECK(surface.facets == 16);
        CHECK(surface.components == 1);
        CHECK(surface.area == doctest::Approx(16));
    }
}

TEST_CASE("a corner that moved is missing, and the distances tell by how much") {
    HandMade made = cube_of_cubes(4);
    const NodeId corner = node_at(made.mesh, {4, 4, 4});
    for (std::size_t j = 0; j < 3; ++j) made.mesh.points[3 * corner + j] = 3.75;
    const QualityReport report = made.assess(3);
    CHECK(report.corners_expected == 8);
    CHECK(report.corners_found == 7);
    CHECK(report.corners_extra == 1);
    REQUIRE(report.missing.size() == 1);
    for (const double x : report.missing[0].place) CHECK(x == doctest::Approx(4).epsilon(1e-12));
    CHECK(report.missing[0].nearest == doctest::Approx(0.25 * std::sqrt(3.0)));
    std::vector<std::string> names = report.missing[0].surfaces;
    std::sort(names.begin(), names.end());
    CHECK(names == std::vector<std::string>{"cube_xmax", "cube_ymax", "cube_zmax"});
    // Every facet at the corner has its node 0.25 away from its own plane.
    CHECK(report.mesh_to_model.maximum == doctest::Approx(0.25));
    for (const double x : report.mesh_to_model.place) CHECK(x == doctest::Approx(3.75));
    CHECK(report.model_to_mesh.maximum > 0.05);
    CHECK(report.model_to_mesh.maximum < 0.25 * std::sqrt(3.0));
    CHECK(report.max_normal_angle > 5);
    REQUIRE(!report.worst.empty());
    CHECK(report.worst[0].cause ==
          "touches corner of cube_xmax, cube_ymax, cube_zmax, smallest model angle 90 degrees");
}

TEST_CASE("two regions in a cube: the interface's rim is a crease, with corners where it crosses edges") {
    // The upper half belongs to region 2; a model plane z = 2 separates them.
    Mesh mesh = samples::grid(4, 4, 4, 2, [](int, int, int k) { return k < 2 ? 1 : 2; });
    Model model;
    const std::uint32_t lower = model.add_primitive(box({0, 0, 0}, {4, 4, 2}), "low");
    const std::uint32_t upper = model.add_primitive(box({0, 0, 2}, {4, 4, 4}), "high");
    model.regions = {{"a", lower, 0, {}}, {"b", upper, 0, {}}};
    const tape::CompiledModel compiled = tape::compile(model);
    const tape::BoundModel bound = tape::bind(compiled, {-2, -2, -2}, 8);
    mesh.surface_names = compiled.surface_names;
    std::vector<std::uint32_t> facet_surface;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        double middle[3] = {0, 0, 0};
        for (std::size_t k = 0; k < 4; ++k) {
            for (std::size_t j = 0; j < 3; ++j) {
                middle[j] += 0.25 * mesh.points[3 * std::size_t{mesh.facets.nodes[4 * f + k]} + j];
            }
        }
        for (std::uint32_t s = 0; s < bound.surfaces.size(); ++s) {
            const double* plane = bound.surfaces[s].map;
            double value = plane[3];
            for (std::size_t j = 0; j < 3; ++j) value += plane[j] * (middle[j] + 2) / 8;
            if (std::fabs(value) > 1e-12) continue;
            facet_surface.push_back(s);
            mesh.facets.surface[f] = bound.surface_name[s];
        }
    }
    REQUIRE(facet_surface.size() == mesh.facets.size());
    const Features features = features::find_features(mesh, facet_surface, bound);
    // 8 corners of the cube, 4 of the interface; 8 edges and 4 halved ones of the cube, 4 of the interface.
    CHECK(features.corners.size() == 12);
    CHECK(features.curves.size() == 20);
    double length = 0;
    for (const FeatureCurve& curve : features.curves) {
        length += curve.length;
        CHECK(curve.model_angle == doctest::Approx(90));
    }
    CHECK(length == doctest::Approx(48 + 16));
    const QualityReport report = report::assess(mesh, facet_surface, bound, features, {3, 10, 1});
    CHECK(report.corners_expected == 12);
    CHECK(report.corners_found == 12);
    CHECK(report.corners_extra == 0);
    CHECK(report.model_to_mesh.maximum < 1e-11);
}

TEST_CASE("the report does not depend on threads") {
    const HandMade made = cube_of_cubes(6);
    const Features features = made.features();
    const QualityReport one = report::assess(made.mesh, made.facet_surface, made.model, features, {4, 10, 1});
    const QualityReport many =
        report::assess(made.mesh, made.facet_surface, made.model, features, {4, 10, 5});
    CHECK(one.model_to_mesh.maximum == many.model_to_mesh.maximum);
    CHECK(one.model_to_mesh.mean == many.model_to_mesh.mean);
    CHECK(one.mesh_to_model.mean == many.mesh_to_model.mean);
    CHECK(one.mean_normal_angle == many.mean_normal_angle);
    CHECK(one.angles.histogram == many.angles.histogram);
    for (std::size_t i = 0; i < one.worst.size(); ++i) CHECK(one.worst[i].index == many.worst[i].index);
}
