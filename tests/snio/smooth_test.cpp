// Meshes of solids with one smooth surface: valid, and every element good, before any repositioning.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "mortise/check.hpp"
#include "mortise/mesher.hpp"

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
};

void check_smooth(const Case& item) {
    CAPTURE(item.name);
    CAPTURE(item.level);
    MeshOptions options;
    options.level = item.level;
    options.improve = false;
    MeshReport report;
    const Mesh mesh = generate_mesh(item.model, options, &report);
    const CheckReport check = check_mesh(mesh);
    CHECK(check.valid());
    if (!check.valid()) MESSAGE(check.defects[0].what, ": ", check.defects[0].first);
    double jacobian = 1;
    for (const double each : check.min_scaled_jacobian) jacobian = std::min(jacobian, each);
    MESSAGE(item.name, " at level ", item.level, ": ", mesh.element_count(), " elements, dihedral ",
            check.min_dihedral, " to ", check.max_dihedral, ", scaled Jacobian ", jacobian);
    // Where the surface bulges through a face between four corners of one side, the certificate does its
    // work.
    CHECK(report.cnio_cells <= report.nio_cells / 100);
    CHECK(check.euler_characteristic == item.euler);
    CHECK(check.nonmanifold_edges == 0);
    CHECK(check.min_dihedral >= 15);
    CHECK(check.max_dihedral <= 160);
    CHECK(jacobian >= 0.145);
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

TEST_CASE("a plane parallel to the grid keeps hexahedra") {
    // The faces lie 0.2 of a cell off grid planes; only cells at the edges are complex.
    Model model;
    model.regions.push_back({"box", model.add_primitive(box({0, 0, 0}, {2.04, 1.44, 1.64})), 0, {}});
    MeshOptions options;
    options.size = 0.2;
    options.improve = false;
    MeshReport report;
    const Mesh mesh = generate_mesh(model, options, &report);
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
