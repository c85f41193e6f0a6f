// Meshes of second order: figures of straight and curved elements, and damage by its own name.
#include <cmath>

#include <doctest/doctest.h>

#include "mortise/check.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

std::string defects_of(const Mesh& mesh) {
    std::string text;
    for (const Defect& defect : check_mesh(mesh).defects)
        text += defect.what + " (" + std::to_string(defect.count) + "): " + defect.first + "\n";
    return text;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The node in the middle of a local edge of the first element of a type.
NodeId middle_of(const Mesh& mesh, ElementType type, int edge) {
    return mesh.block(type).middles[static_cast<std::size_t>(edge)];
}

}  // namespace

TEST_CASE("straight edges: the figures of first order") {
    const Mesh first = mixed();
    const CheckReport flat = check_mesh(first), second = check_mesh(with_middles(first));
    CHECK(defects_of(with_middles(first)) == "");
    CHECK(second.volume == flat.volume);
    CHECK(second.boundary_area == doctest::Approx(flat.boundary_area).epsilon(1e-12));
    CHECK(second.euler_characteristic == flat.euler_characteristic);
    CHECK(second.min_scaled_jacobian == flat.min_scaled_jacobian);
}

TEST_CASE("volumes that curved edges add are known on paper") {
    // An edge's node that moves by d adds the integral of its shape function over each face at it to the
    // volume: 1/6 of a triangle of area 1/2, 1/3 of a unit square, if d is normal to the other faces there.
    const struct {
        ElementType type;
        int edge;
        double move[3], added;
    } cases[] = {
        {ElementType::kTetrahedron, 0, {0, 0, -0.1}, 0.1 / 6},
        {ElementType::kWedge, 0, {0, 0, -0.1}, 0.1 / 6},
        {ElementType::kWedge, 6, {0, 0, 0.1}, 0},
        {ElementType::kHexahedron, 0, {0, 0, -0.1}, 0.1 / 3},
        {ElementType::kHexahedron, 9, {0.1, 0, 0}, 0.1 / 3},
        {ElementType::kPyramid, 0, {0, 0, -0.1}, 0.1 / 3 - 0.1 / 12},  // its slanted face goes down, too
    };
    for (const auto& c : cases) {
        CAPTURE(static_cast<int>(c.type));
        CAPTURE(c.edge);
        const Mesh unit = unit_element(c.type);
        const double before = check_mesh(unit).volume;
        Mesh mesh = with_middles(unit);
        const NodeId node = middle_of(mesh, c.type, c.edge);
        for (std::size_t j = 0; j < 3; ++j) mesh.points[3 * std::size_t{node} + j] += c.move[j];
        CHECK(defects_of(mesh) == "");
        CHECK(check_mesh(mesh).volume - before == doctest::Approx(c.added).epsilon(1e-9));
    }
}

TEST_CASE("areas of curved facets: a cylinder's side") {
    Mesh mesh = with_middles(unit_element(ElementType::kHexahedron));
    const double half = std::sqrt(0.5);
    for (const int edge : {1, 5}) {
        double* const p =
            mesh.points.data() + 3 * std::size_t{middle_of(mesh, ElementType::kHexahedron, edge)};
        p[0] = 0.5 + half;  // on the circle around (0.5, 0.5) through the corners
    }
    const double area = check_mesh(mesh).boundary_area - 3 - 2 * (1 + 2.0 / 3 * (half - 0.5));
    // The length of a parabola's arc of that height over a chord of 1.
    const double h = 4 * (half - 0.5), slope = std::sqrt(1 + h * h);
    CHECK(area == doctest::Approx(0.5 * slope + std::log(h + slope) / (2 * h)).epsilon(1e-6));
}

TEST_CASE("an edge that turns its element over") {
    for (const ElementType type :
         {ElementType::kHexahedron, ElementType::kWedge, ElementType::kPyramid, ElementType::kTetrahedron}) {
        Mesh mesh = with_middles(unit_element(type));
        // Nearly at the end of its edge: the Jacobian is negative there, all corners are where they were.
        double* const p = mesh.points.data() + 3 * std::size_t{middle_of(mesh, type, 0)};
        p[0] += 0.4;
        CHECK(has(defects_of(mesh), "with non-positive Jacobian (1)"));
    }
}

TEST_CASE("middles that are wrong") {
    const Mesh whole = with_middles(mixed());
    Mesh mesh = whole;
    std::swap(mesh.block(ElementType::kPyramid).middles[4], mesh.block(ElementType::kPyramid).middles[5]);
    CHECK(has(defects_of(mesh), "node in the middle of an edge that is used elsewhere"));

    mesh = whole;
    mesh.block(ElementType::kTetrahedron).middles[5] = mesh.block(ElementType::kTetrahedron).nodes[0];
    CHECK(has(defects_of(mesh), "a corner of an element, too"));

    mesh = whole;  // the shared edge of pyramid and hexahedron gets a second node
    mesh.block(ElementType::kPyramid).middles[0] = add_node(mesh, 0.5, -0.01, 1);
    CHECK(has(defects_of(mesh), "edge with two nodes in its middle"));

    mesh = whole;
    std::swap(mesh.facets.middles[0], mesh.facets.middles[1]);
    CHECK(has(defects_of(mesh), "listed facet with other nodes in the middles of its edges"));

    mesh = whole;
    mesh.block(ElementType::kWedge).middles.pop_back();
    CHECK(has(defects_of(mesh), "wedge middles: 8 values, expected 9"));

    mesh = whole;
    mesh.facets.middles.clear();
    CHECK(has(defects_of(mesh), "facet middles: 0 values"));

    mesh = whole;
    mesh.block(ElementType::kHexahedron).middles[0] = 1000;
    CHECK(has(defects_of(mesh), "element with a node index out of range"));

    mesh = whole;
    add_node(mesh, 7, 7, 7);
    CHECK(has(defects_of(mesh), "unused node (1)"));
}
