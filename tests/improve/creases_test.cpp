// Parts whose creases pass grid vertices, or meet at small angles: no cluster of flat elements may stay.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

/// What improvement aims at, with room for rounded constants.
void check_aims(const Meshed& m) {
    CHECK(m.defects == "");
    CHECK(m.check.nonmanifold_edges == 0);
    CHECK(m.check.min_dihedral >= 17.9);
    CHECK(m.check.max_dihedral <= 155.1);
    CHECK(*std::min_element(m.check.min_scaled_jacobian.begin(), m.check.min_scaled_jacobian.end()) >= 0.199);
}

/// A hub with a conical shoulder, a bore and six countersunk bolt holes, turned.
std::string turned_hub() {
    std::ostringstream text;
    text.precision(15);
    const auto cylinder = [&](double x, double y, double z, double height, double bottom, double top) {
        text << "multmatrix([[1, 0, 0, " << x << "], [0, 1, 0, " << y << "], [0, 0, 1, " << z
             << "], [0, 0, 0, 1]]) { cylinder(h = " << height << ", r1 = " << bottom << ", r2 = " << top
             << "); }";
    };
    text << "multmatrix([[0.783962326329013, -0.406468140912384, -0.469240579362051, 0], [0.152386839344158, "
            "0.858724259114121, -0.489255452707072, 0], [0.601815023152048, 0.312051754092385, "
            "0.735147863137998, 0], [0, 0, 0, 1]]) { difference() { union() {";
    cylinder(0, 0, 0, 6, 40, 40);
    cylinder(0, 0, 0, 30, 18, 18);
    cylinder(0, 0, 6, 6, 24, 18);
    text << "}";
    cylinder(0, 0, -1, 40, 9, 9);
    for (int k = 0; k < 12; ++k) {
        const double angle = 2 * 3.14159265358979323846 * (k % 6) / 6;
        const bool hole = k < 6;
        cylinder(32 * std::cos(angle), 32 * std::sin(angle), hole ? -1 : 3, hole ? 10 : 4, 3.5,
                 hole ? 3.5 : 6.5);
    }
    text << "} }";
    return text.str();
}

}  // namespace

/// Their worst scaled Jacobians were 0.09 at level 5 and 1e-5 at level 6: ears of one tetrahedron sat on the
/// crease where it passes an edge of the grid.
TEST_CASE("a turned hub has good elements") {
    const Model hub = parse_model(turned_hub(), "csg", "hub.csg");
    for (const int level : {5, 6}) {
        CAPTURE(level);
        check_aims(mesh_and_check(hub, level));
    }
}

/// Creases of 14 degrees between sheet and cylinder; it had 0.001.
TEST_CASE("a gyroid sheet cut by a cylinder has good elements") {
    const Meshed m = mesh_and_check(read_model(MORTISE_SOURCE_DIR "/assets/models/gyroid.csg"), 5);
    check_aims(m);
    // A corner whose elements had no room for it at first.
    CHECK(nearest_node(m.mesh, {-3.5295211599412974, 9.356413863309312, -6}) < 1e-7);
}

/// What was stuck lay at the border of the improved zone.
TEST_CASE("elements at the border of the zone are improved, too") {
    check_aims(mesh_and_check(read_model(MORTISE_SOURCE_DIR "/assets/models/object_x.csg"), 6));
}

}  // namespace mortise::test
