// Figures of valid meshes against closed forms.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "host/quality/jacobian.hpp"
#include "host/quality/shape.hpp"
#include "mortise/check.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

std::string defect_names(const CheckReport& report) {
    std::string names;
    for (const Defect& defect : report.defects) names += defect.what + ": " + defect.first + "\n";
    return names;
}

CheckReport check_valid(const Mesh& mesh) {
    const CheckReport report = check_mesh(mesh);
    CHECK_MESSAGE(report.valid(), defect_names(report));
    return report;
}

std::size_t index_of(ElementType type) { return static_cast<std::size_t>(type); }

}  // namespace

TEST_CASE("unit elements: volume, area, Euler characteristic, scaled Jacobian, angles") {
    struct Expected {
        ElementType type;
        double volume, area, scaled_jacobian, min_dihedral, max_dihedral;
        std::uint64_t facets;
    };
    const double degrees = 180 / std::acos(-1.0);
    const double slant = std::atan(2.0) * degrees;  // unit pyramid: side faces against the base
    const Expected table[] = {
        {ElementType::kHexahedron, 1, 6, 1, 90, 90, 6},
        {ElementType::kWedge, 0.5, 3 + std::sqrt(2.0), std::sqrt(0.5), 45, 90, 5},
        {ElementType::kPyramid, 1.0 / 3, 1 + std::sqrt(5.0), 1 / std::sqrt(1.5), slant,
         std::acos(-0.2) * degrees, 5},
        {ElementType::kTetrahedron, 1.0 / 6, 1.5 + std::sqrt(0.75), 0.5,
         std::acos(1 / std::sqrt(3.0)) * degrees, 90, 4},
    };
    for (const Expected& expected : table) {
        CAPTURE(index_of(expected.type));
        const Mesh mesh = unit_element(expected.type);
        const CheckReport report = check_valid(mesh);
        CHECK(report.volume == doctest::Approx(expected.volume).epsilon(1e-14));
        CHECK(report.boundary_area == doctest::Approx(expected.area).epsilon(1e-14));
        CHECK(report.euler_characteristic == 2);
        CHECK(report.boundary_facets == expected.facets);
        CHECK(report.min_scaled_jacobian[index_of(expected.type)] ==
              doctest::Approx(expected.scaled_jacobian).epsilon(1e-14));
        CHECK(report.min_dihedral == doctest::Approx(expected.min_dihedral).epsilon(1e-12));
        CHECK(report.max_dihedral == doctest::Approx(expected.max_dihedral).epsilon(1e-12));
        CHECK(scaled_jacobians(mesh) ==
              std::vector<float>{static_cast<float>(report.min_scaled_jacobian[index_of(expected.type)])});
    }
}

TEST_CASE("regular tetrahedron: scaled Jacobian 0.707, dihedral 70.53 degrees") {
    Mesh mesh = unit_element(ElementType::kTetrahedron);
    mesh.points = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
    // This order is left-handed: swapping two nodes makes it right-handed.
    CHECK_FALSE(check_mesh(mesh).valid());
    std::swap(mesh.elements[3].nodes[0], mesh.elements[3].nodes[1]);
    list_facets(mesh);
    const CheckReport report = check_valid(mesh);
    CHECK(report.min_scaled_jacobian[3] == doctest::Approx(std::sqrt(0.5)).epsilon(1e-14));
    CHECK(report.min_dihedral == doctest::Approx(70.528779365509308).epsilon(1e-13));
    CHECK(report.max_dihedral == doctest::Approx(70.528779365509308).epsilon(1e-13));
    CHECK(report.volume == doctest::Approx(8.0 / 3).epsilon(1e-14));
}

TEST_CASE("structured grid: known counts and figures") {
    const CheckReport report = check_valid(grid(4, 3, 2, 2, [](int i, int, int) { return i < 1 ? 1 : 2; }));
    CHECK(report.nodes == 60);
    CHECK(report.elements[0] == 24);
    CHECK(report.boundary_facets == 2 * (12 + 8 + 6));
    CHECK(report.interface_facets == 6);
    CHECK(report.nonmanifold_edges == 0);
    CHECK(report.euler_characteristic == 2);
    CHECK(report.components == 1);
    CHECK(report.volume == 24);
    CHECK(report.boundary_area == doctest::Approx(52));
    CHECK(report.region_volume == std::vector<double>{6, 18});
    CHECK(report.min_scaled_jacobian == std::array<double, 4>{1, 1, 1, 1});
    CHECK(report.min_dihedral == doctest::Approx(90));
    CHECK(report.max_dihedral == doctest::Approx(90));
}

TEST_CASE("ring, cavity, separate parts and touching edges") {
    const CheckReport ring =
        check_valid(grid(3, 3, 1, 1, [](int i, int j, int) { return i == 1 && j == 1 ? 0 : 1; }));
    CHECK(ring.euler_characteristic == 0);
    const CheckReport cavity =
        check_valid(grid(3, 3, 3, 1, [](int i, int j, int k) { return i == 1 && j == 1 && k == 1 ? 0 : 1; }));
    CHECK(cavity.euler_characteristic == 4);
    CHECK(cavity.components == 1);
    const CheckReport parts = check_valid(grid(3, 1, 1, 1, [](int i, int, int) { return i == 1 ? 0 : 1; }));
    CHECK(parts.components == 2);
    CHECK(parts.euler_characteristic == 4);
    const CheckReport touching =
        check_valid(grid(2, 2, 1, 1, [](int i, int j, int) { return i == j ? 1 : 0; }));
    CHECK(touching.components == 2);
    CHECK(touching.nonmanifold_edges == 1);
    CHECK(touching.parts == 1);
    CHECK(touching.nonmanifold_nodes == 0);
    CHECK(parts.parts == 2);
    CHECK(cavity.parts == 1);
    const CheckReport hinge =
        check_valid(grid(2, 2, 2, 1, [](int i, int j, int k) { return i == j && j == k ? 1 : 0; }));
    CHECK(hinge.components == 2);
    CHECK(hinge.parts == 1);
    CHECK(hinge.nonmanifold_nodes == 1);
    CHECK(hinge.nonmanifold_edges == 0);
    // Two voids that touch at a node: one solid, its boundary still hangs on that node.
    const CheckReport voids = check_valid(grid(4, 4, 4, 1, [](int i, int j, int k) {
        const bool first = i == 1 && j == 1 && k == 1;
        return first || (i == 2 && j == 2 && k == 2) ? 0 : 1;
    }));
    CHECK(voids.components == 1);
    CHECK(voids.parts == 1);
    CHECK(voids.nonmanifold_nodes == 1);
}

TEST_CASE("all element types together") {
    const CheckReport report = check_valid(mixed());
    CHECK(report.components == 1);
    CHECK(report.euler_characteristic == 2);
    CHECK(report.interface_facets == 1);
    const double tetrahedron = 1.5 / 6;
    CHECK(report.volume == doctest::Approx(1 + 0.5 + 1.0 / 3 + tetrahedron).epsilon(1e-14));
    CHECK(report.region_volume[0] == doctest::Approx(1.5).epsilon(1e-14));
    CHECK(report.region_volume[1] == doctest::Approx(1.0 / 3 + tetrahedron).epsilon(1e-14));
}

TEST_CASE("volumes of elements with warped faces add up: moving an inner node changes nothing") {
    Mesh mesh = grid(3, 3, 3, 1);
    for (std::size_t i = 0; i < mesh.node_count(); ++i) {
        const double* p = mesh.points.data() + 3 * i;
        const bool inner = p[0] > 0 && p[0] < 3 && p[1] > 0 && p[1] < 3 && p[2] > 0 && p[2] < 3;
        if (!inner) continue;
        mesh.points[3 * i] += 0.21 * std::sin(double(i));
        mesh.points[3 * i + 1] += 0.23 * std::cos(double(7 * i));
        mesh.points[3 * i + 2] += 0.19 * std::sin(double(5 * i));
    }
    const CheckReport report = check_valid(mesh);
    CHECK(report.volume == doctest::Approx(27).epsilon(1e-14));
    CHECK(report.min_scaled_jacobian[0] < 0.9);
    // The same across types: the pyramid's base is a warped face of the cube.
    Mesh two = mixed();
    const double before = check_mesh(two).volume;
    two.points[3 * 5 + 2] += 0.3;  // node 5 also belongs to the boundary: compare with its mirror image
    const double up = check_valid(two).volume;
    two.points[3 * 5 + 2] -= 0.6;
    CHECK(0.5 * (up + check_valid(two).volume) == doctest::Approx(before).epsilon(1e-13));
}

TEST_CASE("an empty mesh is valid and has no figures") {
    const CheckReport report = check_valid(Mesh{});
    CHECK(report.volume == 0);
    CHECK(report.components == 0);
    CHECK(report.min_scaled_jacobian == std::array<double, 4>{1, 1, 1, 1});
}

namespace {

using quality::Corners;
using quality::Vector;

/// The Jacobian of an element's map by its shape functions' derivatives, at (u, v, w) in the unit cube; for
/// the wedge u is shrunk to the triangle, for the pyramid the factor (1 - w)² is left out.
double sampled_jacobian(ElementType type, const Corners& c, double u, double v, double w) {
    const Vector* p = c.p;
    Vector du, dv, dw;
    if (type == ElementType::kHexahedron) {
        const double a[2] = {1 - u, u}, b[2] = {1 - v, v}, d[2] = {1 - w, w};
        const int id[2][2][2] = {{{0, 4}, {3, 7}}, {{1, 5}, {2, 6}}};
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j)
                for (int k = 0; k < 2; ++k) {
                    const Vector& q = p[id[i][j][k]];
                    du = du + (i == 1 ? 1.0 : -1.0) * b[j] * d[k] * q;
                    dv = dv + (j == 1 ? 1.0 : -1.0) * a[i] * d[k] * q;
                    dw = dw + (k == 1 ? 1.0 : -1.0) * a[i] * b[j] * q;
                }
    } else if (type == ElementType::kWedge) {
        u *= 1 - v;
        du = (1 - w) * (p[1] - p[0]) + w * (p[4] - p[3]);
        dv = (1 - w) * (p[2] - p[0]) + w * (p[5] - p[3]);
        dw = (1 - u - v) * (p[3] - p[0]) + u * (p[4] - p[1]) + v * (p[5] - p[2]);
    } else {
        du = (1 - v) * (p[1] - p[0]) + v * (p[2] - p[3]);
        dv = (1 - u) * (p[3] - p[0]) + u * (p[2] - p[1]);
        const Vector base = (1 - v) * ((1 - u) * p[0] + u * p[1]) + v * ((1 - u) * p[3] + u * p[2]);
        dw = p[4] - base;
    }
    return dot(cross(du, dv), dw);
}

}  // namespace

TEST_CASE("Jacobian positivity agrees with dense samples of random elements") {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> shift(-0.45, 0.45);
    for (const ElementType type : {ElementType::kHexahedron, ElementType::kWedge, ElementType::kPyramid}) {
        const Mesh unit = unit_element(type);
        int accepted = 0;
        for (int trial = 0; trial < 400; ++trial) {
            Corners corners = quality::corners_of(unit, type, 0);
            for (Vector& p : corners.p) p = p + Vector{shift(random), shift(random), shift(random)};
            double smallest = 1e9;
            constexpr int steps = 12;
            for (int i = 0; i <= steps; ++i)
                for (int j = 0; j <= steps; ++j)
                    for (int k = 0; k <= steps; ++k) {
                        const double sample = sampled_jacobian(type, corners, i / double(steps),
                                                               j / double(steps), k / double(steps));
                        smallest = std::min(smallest, sample);
                    }
            const quality::JacobianFigures figures = quality::jacobian_figures(type, corners);
            if (figures.positive) {
                ++accepted;
                CHECK(smallest > 0);
                CHECK(figures.minimum <= smallest + 1e-12);
            } else {
                // Refused: negative somewhere, if only between the samples.
                CHECK(figures.minimum <= 0);
                CHECK(smallest < 0.05);
            }
        }
        CHECK(accepted > 20);
        CHECK(accepted < 380);
    }
}

TEST_CASE("the hexahedron of the defect tests really is negative inside, with good corners") {
    const Corners corners = {{{-0.4, -0.2, -0.3},
                              {1.9, -0.7, 0.8},
                              {1.6, 1.2, 0.5},
                              {-0.7, 1.5, 0.6},
                              {-0.5, -0.2, 0.8},
                              {1.3, 0.9, 1.5},
                              {1.5, 1.4, 0.7},
                              {-0.7, 0.3, 1.0}}};
    double smallest = 1e9;
    for (int i = 0; i <= 60; ++i)
        for (int j = 0; j <= 60; ++j)
            for (int k = 0; k <= 60; ++k)
                smallest = std::min(smallest, sampled_jacobian(ElementType::kHexahedron, corners, i / 60.0,
                                                               j / 60.0, k / 60.0));
    CHECK(smallest < 0);
    CHECK(quality::scaled_jacobian(ElementType::kHexahedron, corners) > 0.5);
    CHECK_FALSE(quality::jacobian_figures(ElementType::kHexahedron, corners).positive);
}
