// Shapes and angles of elements whose angles are known.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "mortise/check.hpp"
#include "mortise/quality.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;

namespace {

constexpr double kDegrees = 57.295779513082323;

template <std::size_t N>
std::uint64_t total(const std::array<std::uint64_t, N>& histogram) {
    return std::accumulate(histogram.begin(), histogram.end(), std::uint64_t{0});
}

}  // namespace

TEST_CASE("a cube: 24 right angles, scaled Jacobian 1") {
    const QualityReport report = element_quality(samples::unit_element(ElementType::kHexahedron));
    CHECK_FALSE(report.has_model);
    const ElementShape& shape = report.shapes[0];
    CHECK(shape.count == 1);
    CHECK(shape.minimum == doctest::Approx(1));
    CHECK(shape.percentile == doctest::Approx(1));
    CHECK(shape.mean == doctest::Approx(1));
    CHECK(shape.histogram[19] == 1);
    CHECK(report.angles.count == 24);
    CHECK(report.angles.minimum == doctest::Approx(90));
    CHECK(report.angles.maximum == doctest::Approx(90));
    CHECK(report.angles.histogram[18] + report.angles.histogram[17] == 24);
    for (std::size_t t = 1; t < 4; ++t) CHECK(report.shapes[t].count == 0);
    REQUIRE(report.worst.size() == 1);
    CHECK(report.worst[0].place == Vec3{0.5, 0.5, 0.5});
    CHECK(report.worst[0].cause.empty());
}

TEST_CASE("a regular tetrahedron: 70.53 degrees, 1/sqrt 2") {
    Mesh mesh = samples::unit_element(ElementType::kTetrahedron);
    mesh.points = {1, 1, 1, -1, 1, -1, 1, -1, -1, -1, -1, 1};
    if (scaled_jacobians(mesh)[0] < 0)
        std::swap(mesh.block(ElementType::kTetrahedron).nodes[0],
                  mesh.block(ElementType::kTetrahedron).nodes[1]);
    const QualityReport report = element_quality(mesh);
    CHECK(report.shapes[3].minimum == doctest::Approx(std::sqrt(0.5)));
    CHECK(report.angles.count == 12);
    CHECK(report.angles.minimum == doctest::Approx(kDegrees * std::acos(1.0 / 3)));
    CHECK(report.angles.maximum == doctest::Approx(kDegrees * std::acos(1.0 / 3)));
}

TEST_CASE("a wedge on a right isosceles triangle: 45 and 90 degrees") {
    const QualityReport report = element_quality(samples::unit_element(ElementType::kWedge));
    // Six corners with three angles; at each end of the two vertical edges of 45 degrees there is one.
    CHECK(report.angles.count == 18);
    CHECK(report.angles.minimum == doctest::Approx(45));
    CHECK(report.angles.maximum == doctest::Approx(90));
    CHECK(report.angles.histogram[8] + report.angles.histogram[9] == 4);
    CHECK(report.shapes[1].minimum == doctest::Approx(std::sqrt(0.5)));
}

TEST_CASE("percentiles and the worst elements among many") {
    // 1000 cubes and a row of 7 sheared ones far away, each worse than the one before.
    Mesh mesh = samples::grid(10, 10, 10, 1);
    std::vector<double> expected;
    for (int i = 0; i < 7; ++i) {
        const double shear = 1.0 + i, x = 100.0 + 20 * i;
        std::vector<NodeId> nodes;
        for (int up = 0; up < 2; ++up) {
            for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
                nodes.push_back(samples::add_node(mesh, x + u + shear * up, v, up));
            }
        }
        samples::add_element(mesh, ElementType::kHexahedron, nodes);
        expected.push_back(1 / std::sqrt(1 + shear * shear));
    }
    const QualityReport report = element_quality(mesh, 5);
    REQUIRE(report.worst.size() == 5);
    for (std::size_t i = 0; i < 5; ++i) {
        CHECK(report.worst[i].scaled_jacobian == doctest::Approx(expected[6 - i]));
        CHECK(report.worst[i].index == 1000 + 6 - i);
        // A shear by s makes edges with angles of atan(1/s) and its supplement.
        const double angle = kDegrees * std::atan(1 / (7.0 - static_cast<double>(i)));
        CHECK(report.worst[i].min_dihedral == doctest::Approx(angle));
        CHECK(report.worst[i].max_dihedral == doctest::Approx(180 - angle));
    }
    const ElementShape& shape = report.shapes[0];
    CHECK(shape.count == 1007);
    CHECK(shape.minimum == doctest::Approx(expected[6]));
    CHECK(shape.percentile == doctest::Approx(1));  // rank 10 of 1007: beyond the seven
    CHECK(total(shape.histogram) + shape.not_positive == shape.count);
    CHECK(total(report.angles.histogram) == report.angles.count);
    CHECK(report.angles.count == 24 * 1007);
    CHECK(report.angles.low_percentile == doctest::Approx(90).epsilon(0.001));
    CHECK(element_quality(mesh, 0).worst.empty());
}

TEST_CASE("flat, inverted and endless elements are counted, not divided by") {
    Mesh mesh = samples::unit_element(ElementType::kTetrahedron);
    for (const double height : {0.0, -1.0, HUGE_VAL}) {
        CAPTURE(height);
        mesh.points.back() = height;
        const QualityReport report = element_quality(mesh);
        CHECK(report.shapes[3].not_positive == 1);
        CHECK(total(report.shapes[3].histogram) == 0);
        CHECK(std::isfinite(report.shapes[3].mean));
        CHECK(std::isfinite(report.angles.maximum));
        REQUIRE(report.worst.size() == 1);
        CHECK(std::isfinite(report.worst[0].scaled_jacobian));
    }
    CHECK(element_quality(Mesh{}).worst.empty());
}
