// Meshes of solids with one smooth surface: valid, and every element good, before any repositioning.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "mortise/check.hpp"
#include "mortise/mesher.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise {
namespace {

Model formula(const std::string& text) {
    Model model;
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = text;
    model.regions.push_back({"solid", model.add_primitive(primitive), 0, {}});
    model.clip = Box3{{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}};
    return model;
}

Model ball(double x, double y, double z) {
    Model model;
    const auto node =
        model.add_transform({1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}, model.add_primitive(sphere(1)));
    model.regions.push_back({"ball", node, 0, {}});
    return model;
}

struct Case {
    std::string name;
    Model model;
    int level;
    std::int64_t euler;
    double min_dihedral = 15;
};

void check_smooth(const Case& item) {
    CAPTURE(item.name);
    CAPTURE(item.level);
    MeshOptions options;
    options.level = item.level;
    options.improve = false;
    MeshReport report;
    const Mesh mesh = test::generate(item.model, options, &report);
    const CheckReport check = check_mesh(mesh);
    CHECK(check.valid());
    if (!check.valid()) MESSAGE(check.defects[0].what, ": ", check.defects[0].first);
    double jacobian = 1;
    for (const double each : check.min_scaled_jacobian) jacobian = std::min(jacobian, each);
    MESSAGE(item.name, " at level ", item.level, ": ", mesh.element_count(), " elements, dihedral ",
            check.min_dihedral, " to ", check.max_dihedral, ", scaled Jacobian ", jacobian);
    CHECK(report.cnio_cells == 0);
    CHECK(check.euler_characteristic == item.euler);
    CHECK(check.nonmanifold_edges == 0);
    CHECK(check.min_dihedral >= item.min_dihedral);
    CHECK(check.max_dihedral <= 160);
    CHECK(jacobian >= 0.15);
}

}  // namespace

TEST_CASE("smooth solids: dihedral angles within 15 to 160 degrees") {
    check_smooth({"ball", ball(0, 0, 0), 3, 2});
    check_smooth({"ball", ball(0, 0, 0), 5, 2});
    check_smooth({"ball off centre", formula("(x-0.0371)^2+(y+0.0213)^2+(z-0.0511)^2-1.01"), 5, 2});
    check_smooth({"ellipsoid", formula("x^2+4*y^2+9*z^2-1"), 6, 2});
    check_smooth({"blob", formula("x^4+y^4+z^4-0.5*x^2*y^2-0.9+0.2*sin(3*x+y)"), 5, 2});
    check_smooth({"tilted torus", formula("(sqrt((0.8*x-0.6*z)^2+y^2)-0.8)^2+(0.6*x+0.8*z)^2-0.09"), 6, 0});
    check_smooth({"gyroid in a shell",
                  formula("sin(3*x)*cos(3*y)+sin(3*y)*cos(3*z)+sin(3*z)*cos(3*x)"
                          "+2*(x^2+y^2+z^2)^2-1.2"),
                  6, 2});
}

TEST_CASE("surfaces that graze faces of the grid are simple") {
    // Poles of balls bulge through faces; where the normals of a torus are those of the grid it is a saddle,
    // and corners of a face may be inside by turns. Both are rare elsewhere. Of the tori, in this pose and
    // with radii near 4 cells, some have tetrahedra of one inside corner with 13.8 degrees, before
    // improvement.
    std::mt19937_64 random(20);
    const auto between = [&random](double low, double high) {
        return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    const auto number = [](double value) { return "(" + std::to_string(value) + ")"; };
    for (int i = 0; i < 25; ++i) {
        std::string moved[3];
        for (int j = 0; j < 3; ++j)
            moved[j] = "(" + std::string(1, "xyz"[j]) + "-" + number(between(-0.2, 0.2)) + ")";
        // Radii of 4 cells and more.
        const std::string ball_radius = number(between(0.4, 1));
        check_smooth({"ball " + std::to_string(i),
                      formula(moved[0] + "^2+" + moved[1] + "^2+" + moved[2] + "^2-" + ball_radius + "^2"), 5,
                      2});
        // The axis lies along (0, 1, 1), so that at its waist the grid's y and z are diagonals of the saddle.
        const std::string along = "((" + moved[1] + "+" + moved[2] + ")*" + number(std::sqrt(0.5)) + ")";
        const std::string across = "((" + moved[1] + "-" + moved[2] + ")*" + number(std::sqrt(0.5)) + ")";
        const std::string ring = number(between(0.75, 0.8));
        const std::string tube = number(between(0.38, 0.4));
        check_smooth({"torus " + std::to_string(i),
                      formula("(sqrt(" + moved[0] + "^2+" + across + "^2)-" + ring + ")^2+" + along + "^2-" +
                              tube + "^2"),
                      5, 0, 13.5});
    }
}

TEST_CASE("a plane parallel to the grid keeps hexahedra") {
    // The faces lie 0.2 of a cell off grid planes; only cells at the edges are complex.
    Model model;
    model.regions.push_back({"box", model.add_primitive(box({0, 0, 0}, {2.04, 1.44, 1.64})), 0, {}});
    MeshOptions options;
    options.size = 0.2;
    options.improve = false;
    MeshReport report;
    const Mesh mesh = test::generate(model, options, &report);
    const CheckReport check = check_mesh(mesh);
    CHECK(check.valid());
    std::size_t snapped = 0;
    for (std::size_t i = 0; i < mesh.elements[0].size(); ++i) {
        snapped += mesh.elements[0].kind[i] == static_cast<std::uint8_t>(ElementKind::kSnio) ? 1 : 0;
    }
    std::size_t others = 0;
    for (std::size_t t = 1; t < kElementTypes; ++t) {
        for (const std::uint8_t kind : mesh.elements[t].kind) {
            others += kind == static_cast<std::uint8_t>(ElementKind::kSnio) ? 1 : 0;
        }
    }
    CHECK(snapped > 100);
    CHECK(check.volume == doctest::Approx(2.04 * 1.44 * 1.64).epsilon(1e-6));
    MESSAGE("hexahedra on the faces: ", snapped, ", other templates' elements: ", others);
}

}  // namespace mortise
