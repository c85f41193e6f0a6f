// Netgen's curves, extrusions and revolutions: volumes in closed form, closed surfaces, errors.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

#include "host/common/constants.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/triangle_measures.hpp"

using namespace mortise;
using doctest::Approx;
using test::region_at;
using test::volume;

namespace {

Model read_sweep(const std::string& statements) {
    return parse_model("algebraic3d\n" + statements + "\ntlo s;", "geo", "m.geo");
}

const TriangleSurface& shell(const Model& model) {
    for (const CsgNode& node : model.nodes) {
        if (node.primitive.triangles != nullptr) return *node.primitive.triangles;
    }
    FAIL("no polyhedron");
    std::abort();
}

/// Every edge has one triangle on either side.
bool is_simply_closed(const TriangleSurface& surface) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : surface.triangles) {
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
        const auto other = edges.find({edge.second, edge.first});
        if (count != 1 || other == edges.end() || other->second != 1) return false;
    }
    return true;
}

double read_volume(const std::string& statements) {
    const Model model = read_sweep(statements);
    CHECK(is_simply_closed(shell(model)));
    return volume(shell(model));
}

// About (3, 2), radius 1: by the corners of a square, and by the centre.
const std::string kCircleBySplines =
    "curve2d c = (8; 3,1; 4,1; 4,2; 4,3; 3,3; 2,3; 2,2; 2,1; 4; 3,1,2,3; 3,3,4,5; 3,5,6,7; 3,7,8,1);\n";
const std::string kCircleByArcs =
    "curve2d c = (5; 3,1; 4,2; 3,3; 2,2; 3,2; 4; 4,1,5,2; 4,2,5,3; 4,3,5,4; 4,4,5,1);\n";
const std::string kSquare = "curve2d c = (4; 1,1; 1,-1; -1,-1; -1,1; 4; 2,1,2; 2,2,3; 2,3,4; 2,4,1);\n";
const std::string kRectangle = "curve2d c = (4; 0,0; 2,0; 2,1; 0,1; 4; 2,1,2; 2,2,3; 2,3,4; 2,4,1);\n";
const std::string kSegment = "curve3d p = (2; 0,0,0; 0,10,0; 1; 2,1,2);\n";

}  // namespace

TEST_CASE("revolution of a circle is a torus") {
    for (const std::string& circle : {kCircleBySplines, kCircleByArcs}) {
        const std::string torus = circle + "solid s = revolution(1,2,3; 1,2,7; c);";
        // Chords lose 1/1100 of the area at most.
        CHECK(read_volume(torus) == Approx(2 * kPi * 2 * kPi).epsilon(1e-3));
        const Model model = read_sweep(torus);
        CHECK(shell(model).group.empty());
        CHECK(region_at(model, {3.9 - 1, 2, 3 + 3}) == 1);
        CHECK(region_at(model, {1, 2, 6}) == 0);
        CHECK(region_at(model, {1, 2 + 2.98, 6}) == 1);
        CHECK(region_at(model, {1, 2 + 2, 3 + 3.98}) == 1);
        CHECK(region_at(model, {1, 2 + 2, 3 + 4.02}) == 0);
    }
}

TEST_CASE("revolution of lines is made of cones and planes") {
    // A cone of radius 2 and height 3 along +x, its axis closed by itself.
    const Model cone =
        read_sweep("curve2d c = (3; 0,0; 0,2; 3,0; 2; 2,1,2; 2,2,3); solid s = revolution(1,0,0; 5,0,0; c);");
    for (const CsgNode& node : cone.nodes) CHECK(!node.primitive.triangles);
    int wrong = 0;
    for (int i = 0; i < 20; ++i) {
        for (int j = 0; j < 20; ++j) {
            const Vec3 p = {0.41 + 0.2 * i, -2.1 + 0.213 * j, 0.37};
            const bool in = p[0] > 1 && std::hypot(p[1], p[2]) < 2 - (p[0] - 1) * 2 / 3;
            wrong += (region_at(cone, p) == 1) != in;
        }
    }
    CHECK(wrong == 0);
    // All surfaces are called after the solid.
    for (const CsgNode& node : cone.nodes) {
        if (node.op == CsgNode::Op::kPrimitive) CHECK(node.name == "s");
    }
    // Closed, off the axis: a tube.
    const Model tube = read_sweep(
        "curve2d c = (4; 0,1; 2,1; 2,3; 0,3; 4; 2,1,2; 2,2,3; 2,3,4; 2,4,1);"
        "solid s = revolution(0,0,0; 0,0,1; c) -bc=4;");
    CHECK(region_at(tube, {0.9, 0, 1}) == 0);
    CHECK(region_at(tube, {1.1, 0, 1}) == 1);
    CHECK(region_at(tube, {0, -2.9, 1.9}) == 1);
    CHECK(region_at(tube, {0, -2.9, 2.1}) == 0);
}

TEST_CASE("revolution of an open spline is a ball, of lines and splines a capsule") {
    const std::string ball =
        "curve2d c = (5; -2,0; -2,2; 0,2; 2,2; 2,0; 2; 3,1,2,3; 3,3,4,5); solid s = "
        "revolution(0,0,0;0,1,0;c);";
    CHECK(read_volume(ball) == Approx(4 * kPi * 8 / 3).epsilon(1e-3));
    const std::string capsule =
        "curve2d c = (6; -2,0; -2,2; 0,2; 3,2; 5,2; 5,0; 3; 3,1,2,3; 2,3,4; 3,4,5,6);"
        "solid s = revolution(0,0,0;0,0,9;c);";
    CHECK(read_volume(capsule) == Approx(4 * kPi * 8 / 3 + 4 * kPi * 3).epsilon(1e-3));
    // Pieces that meet at an angle are faces of their own.
    const Model bullet = read_sweep(
        "curve2d c = (5; 0,0; 0,2; 3,2; 5,2; 5,0; 3; 2,1,2; 2,2,3; 3,3,4,5);"
        "solid s = revolution(0,0,0;0,0,9;c);");
    CHECK(shell(bullet).group_names == std::vector<std::string>{"side1", "side2"});
}

TEST_CASE("extrusion of lines along lines is exact") {
    const std::string prism = kRectangle + kSegment + "solid s = extrusion(p; c; 0,0,1);";
    CHECK(read_volume(prism) == Approx(20).epsilon(1e-12));
    const Model model = read_sweep(prism);
    // Coordinates count along tangent x z = +x, and z.
    CHECK(region_at(model, {1.9, 9.9, 0.9}) == 1);
    CHECK(region_at(model, {-0.1, 5, 0.5}) == 0);
    CHECK(region_at(model, {1, 5, 1.1}) == 0);
    CHECK(shell(model).group_names ==
          std::vector<std::string>{"side1", "side2", "side3", "side4", "start", "end"});
    for (const CsgNode& node : model.nodes) {
        if (node.primitive.triangles != nullptr) CHECK(node.primitive.sharp_angle == 0);
    }
    // A condition joins the faces.
    CHECK(shell(read_sweep(kRectangle + kSegment + "solid s = extrusion(p; c; 0,0,1) -bc=1;")).group_names ==
          std::vector<std::string>{""});

    // Mitre: volume is area times length through the centroid; the square is centred on the path.
    const std::string corner = kSquare + "curve3d p = (3; 0,0,0; 10,0,0; 10,7,0; 2; 2,1,2; 2,2,3);";
    CHECK(read_volume(corner + "solid s = extrusion(p; c; 0,0,1);") == Approx(4 * 17).epsilon(1e-12));
    // Up a ramp: z leans with the path.
    const std::string ramp = kSquare + "curve3d p = (3; 0,0,0; 10,0,0; 20,0,10; 2; 2,1,2; 2,2,3);";
    CHECK(read_volume(ramp + "solid s = extrusion(p; c; 0,0,1);") ==
          Approx(4 * (10 + 10 * std::sqrt(2))).epsilon(1e-12));
    // A closed path: a frame.
    const std::string frame =
        kSquare + "curve3d p = (4; 0,0,0; 9,0,0; 9,6,0; 0,6,0; 4; 2,1,2; 2,2,3; 2,3,4; 2,4,1);";
    CHECK(read_volume(frame + "solid s = extrusion(p; c; 0,0,1);") == Approx(4 * 30).epsilon(1e-12));
}

TEST_CASE("extrusion along curves") {
    // Pappus: a square along a quarter circle of radius 5, also with straight ends.
    const std::string quarter = kSquare + "curve3d p = (3; 5,0,0; 5,5,0; 0,5,0; 1; 3,1,2,3);";
    CHECK(read_volume(quarter + "solid s = extrusion(p; c; 0,0,1);") == Approx(4 * 2.5 * kPi).epsilon(1e-3));
    const std::string hook = kSquare + "curve3d p = (4; 5,-3,0; 5,0,0; 0,0,0; 0,5,0; 2; 2,1,2; 4,2,3,4);";
    CHECK(read_volume(hook + "solid s = extrusion(p; c; 0,0,1);") ==
          Approx(4 * (3 + 2.5 * kPi)).epsilon(1e-3));
    // A whole torus, closed: no caps. The profile's centre is 3 to the right, 2 up.
    const std::string ring =
        kCircleBySplines +
        "curve3d p = (8; 5,0,0; 5,5,0; 0,5,0; -5,5,0; -5,0,0; -5,-5,0; 0,-5,0; 5,-5,0; 4; 3,1,2,3; 3,3,4,5; "
        "3,5,6,7; 3,7,8,1);";
    const Model torus = read_sweep(ring + "solid s = extrusion(p; c; 0,0,2);");
    CHECK(is_simply_closed(shell(torus)));
    CHECK(volume(shell(torus)) == Approx(kPi * 2 * kPi * 8).epsilon(2e-3));
    CHECK(shell(torus).group.empty());
    CHECK(region_at(torus, {8, 0, 2}) == 1);
    CHECK(region_at(torus, {5, 0, 0}) == 0);
}

TEST_CASE("a spline whose tangent turns mostly at one end still gets short chords") {
    const Model model = read_sweep("curve2d c = (4; 0,0; 10,0; 10,0.1; 0,0.1; 3; 3,1,2,3; 2,3,4; 2,4,1);" +
                                   kSegment + "solid s = extrusion(p; c; 0,0,1);");
    CHECK(is_simply_closed(shell(model)));
    CHECK(shell(model).triangles.size() < 2000);
}

TEST_CASE("errors of curves and sweeps") {
    const std::string use = "solid s = extrusion(p; c; 0,0,1);";
    const std::pair<std::string, const char*> cases[] = {
        {"curve2d c = (1; 0,0; 1; 2,1,1);", "the number of points is 1"},
        {"curve2d c = (2; 0,0; 1,0; 0);", "the number of pieces is 0"},
        {"curve2d c = (2; 0,0; 1,0; 1; 5,1,2);", "kind 5; expected 2 (line)"},
        {"curve2d c = (2; 0,0; 1,0; 1; 2,1,3);", "names the point 3; expected a number from 1 to 2"},
        {"curve2d c = (2; 0,0; 1,0; 1; 2,1,1);", "ends where it starts"},
        {"curve2d c = (2; 0,0,0; 1,0; 1; 2,1,1);", "expected ';'"},
        {"curve2d c = (2; 0,0; 1e200,0; 1; 2,1,2);", "a coordinate is 1e+200"},
        {"curve2d c = (2; 0,0; 0,0; 1; 2,1,2);", "all at the origin"},
        {"curve2d c = (4; 0,0; 1,0; 1,1; 0,1; 2; 2,1,2; 2,3,4);", "does not start where"},
        {"curve2d c = (2; 0,0; 1,0; 1; 3,1,1,2);", "is one of its ends"},
        {"curve2d c = (3; 0,0; 2,0; 1,0; 1; 3,1,2,3);", "goes back on itself"},
        {"curve2d c = (3; 0,0; 1,0; 2,0; 1; 4,1,2,3);", "half a circle"},
        {"curve2d c = (3; 0,1; 0,0; 2,0; 1; 4,1,2,3);", "are 1 and 2 from its centre"},
        {kSquare + kSquare, "the curve 'c' is defined twice"},
        {"solid s = revolution(0,0,0;1,0,0;c);", "'c' is not a curve2d"},
        {kSegment + "solid s = revolution(0,0,0;1,0,0;p);", "'p' is not a curve2d"},
        {kSquare + "solid s = extrusion(c;c;0,0,1);", "'c' is not a curve3d"},
        {kSquare + kSegment + "solid s = extrusion(p;c;0,1,0);", "along the z direction"},
        {kSquare + kSegment + "solid s = extrusion(p;c;0,0,0);", "the z direction has length 0"},
        {"curve2d c = (2; 0,0; 1,0; 1; 2,1,2);" + kSegment + use, "the profile is open"},
        {"curve2d c = (3; 0,0; 1,0; 2,0; 3; 2,1,2; 2,2,3; 2,3,1);" + kSegment + use, "encloses no area"},
        {"curve2d c = (4; 0,0; 1,1; 1,0; 0,2; 4; 2,1,2; 2,2,3; 2,3,4; 2,4,1);" + kSegment + use,
         "crosses itself"},
        {kSquare + "curve3d p = (3; 0,0,0; 9,0,0; 0,0.1,0; 2; 2,1,2; 2,2,3);" + use, "turns back"},
        {kSquare + "curve3d p = (3; 0,0,0; 1,0,0; 1,1,0; 1; 3,1,2,3);" +
             "curve2d d = (3; 2,0; -2,0; 0,1; 3; 2,1,2; 2,2,3; 2,3,1); solid s = extrusion(p; d; 0,0,1);",
         "beyond the centre of a bend"},
        {kSquare + "curve3d p = (3; 0,0,0; 9,0,3; 9,9,9; 2; 2,1,2; 2,2,3);" + use, "do not fit"},
        {"curve2d c = (2; 0,0; 1,1; 1; 2,1,2); solid s = revolution(0,0,0;1,0,0;c);",
         "does not end on the axis"},
        {kSquare + "solid s = revolution(0,0,0;1,0,0;c);", "reaches to -1"},
        {kCircleByArcs + "solid s = revolution(0,0,0;0,0,0;c);", "the axis has length 0"},
    };
    for (const auto& [text, expected] : cases) {
        CAPTURE(text);
        const std::string message = test::refusal("algebraic3d\n" + text + " tlo s;", "geo");
        CAPTURE(message);
        CHECK(message.find(expected) != std::string::npos);
        CHECK(message.find("m.geo:") != std::string::npos);
    }
}
