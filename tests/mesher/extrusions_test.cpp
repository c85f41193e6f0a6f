// Extrusions of plane shapes, whose volumes are known on paper.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Solid {
    const char* name;
    const char* text;
    double volume;
    double tolerance;
    int euler;
};

void check(const Solid& solid) {
    CAPTURE(std::string(solid.name));
    const Meshed result = mesh_and_check(parse_model(solid.text, "csg", "part.csg"), 5);
    CHECK(result.defects == "");
    CHECK(result.check.volume == doctest::Approx(solid.volume).epsilon(solid.tolerance));
    CHECK(enclosed_volume(result.mesh, 1) == doctest::Approx(result.check.volume).epsilon(1e-9));
    CHECK(result.check.euler_characteristic == solid.euler);
    CHECK(result.check.components == 1);
}

}  // namespace

TEST_CASE("extruded polygons have exact volume") {
    const Solid solids[] = {
        {"L", "linear_extrude(height = 2) { polygon(points = [[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]]); }", 12,
         1e-6, 2},
        {"star",
         "linear_extrude(height = 1, center = true) { polygon(points = [[3,0],[1,1],[0,3],[-1,1],[-3,0],"
         "[-1,-1],[0,-3],[1,-1]]); }",
         12, 1e-6, 2},
        {"plate with two holes",
         "linear_extrude(height = 1) { difference() { square(size = [9, 4]); polygon(points = [[1,1],[3,1],"
         "[3,3],[1,3],[5,1],[8,1],[5,3]], paths = [[0,1,2,3],[4,5,6]]); } }",
         36 - 4 - 3, 1e-6, -2},
        {"pyramid", "linear_extrude(height = 3, scale = 0) { square(size = 2, center = true); }", 4, 1e-6, 2},
        {"tapered L",
         "linear_extrude(height = 2, scale = 0.5) { polygon(points = [[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]]); "
         "}",
         6 * 2 * 7 / 12.0, 1e-6, 2},
        {"wedge", "linear_extrude(height = 2, scale = [0, 1]) { square(size = 2, center = true); }", 4, 1e-6,
         2},
        {"hexagonal ring",
         "rotate_extrude($fn = 6) { multmatrix([[1,0,0,2],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { square(size = "
         "[1, 1]); } }",
         (9 - 4) * 1.5 * std::sqrt(3.0), 1e-6, 0},
    };
    for (const Solid& solid : solids) check(solid);
}

TEST_CASE("curved extrusions have their volume within the mesh's accuracy") {
    const Solid solids[] = {
        {"torus",
         "rotate_extrude() { multmatrix([[1,0,0,3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { circle(r = 1); } }",
         2 * kPi * kPi * 3, 0.02, 0},
        {"plate with a bore", "linear_extrude(height = 1) { difference() { circle(r = 3); circle(r = 1); } }",
         8 * kPi, 0.01, 0},
        {"oblique cone",
         "linear_extrude(height = 3, scale = 0) { multmatrix([[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { "
         "circle(r = 2); } }",
         4 * kPi, 0.02, 2},
        {"lathe work", "rotate_extrude() { polygon(points = [[0,0],[2,0],[1,1],[2,2],[0,2]]); }",
         2 * kPi * 7 / 3, 0.01, 2},
        {"half a ring",
         "rotate_extrude(angle = 180) { multmatrix([[1,0,0,2],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { square(size "
         "= 1); } }",
         kPi * 5 / 2, 0.01, 2},
        {"twisted square", "linear_extrude(height = 3, twist = 90) { square(size = 2, center = true); }", 12,
         0.01, 2},
        {"twisted, tapered and off the axis",
         "linear_extrude(height = 3, twist = -60, scale = 0.5) { polygon(points = "
         "[[1,0],[3,0],[3,2],[1,2]]); "
         "}",
         4 * 3 * 7 / 12.0, 0.02, 2},
        {"hyperbolic sides",
         "linear_extrude(height = 2, scale = [0.5, 2]) { polygon(points = [[2,0],[0,2],"
         "[-2,0],[0,-2]]); }",
         // The mean of (1 - t/2)(1 + t) over t, times area and height.
         8 * 2 * (1 + 0.25 - 1 / 6.0), 0.01, 2},
    };
    for (const Solid& solid : solids) check(solid);
}

}  // namespace mortise::test
