// polyhedron(points, faces): faces of all kinds, errors.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "host/model/csg/csg_polyhedron.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;

namespace {

struct Outcome {
    Model model;
    std::uint32_t node = 0;
    std::vector<std::string> warnings;
    std::string error;
};

Outcome make(const std::vector<Vec3>& points, const std::vector<std::vector<double>>& faces) {
    Outcome outcome;
    std::vector<double> numbers;
    std::vector<std::size_t> ends;
    for (const auto& face : faces) {
        numbers.insert(numbers.end(), face.begin(), face.end());
        ends.push_back(numbers.size());
    }
    try {
        outcome.node = outcome.model.add_primitive(
            polyhedron(model_reader::polyhedron_surface(points, {numbers.data(), ends.data(), ends.size()},
                                                        "m.csg", {3, 7}, outcome.warnings),
                       model_reader::kPolyhedronSharpAngle));
    } catch (const Error& error) {
        outcome.error = error.what();
    }
    return outcome;
}

const std::vector<Vec3> kCubePoints = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                       {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
// Clockwise seen from outside.
const std::vector<std::vector<double>> kCubeFaces = {{0, 1, 2, 3}, {7, 6, 5, 4}, {4, 5, 1, 0},
                                                     {5, 6, 2, 1}, {6, 7, 3, 2}, {7, 4, 0, 3}};

}  // namespace

TEST_CASE("polyhedron: a cube, also inside out, also with one face wrong") {
    auto reversed = kCubeFaces;
    for (auto& face : reversed) face = {face[3], face[2], face[1], face[0]};
    auto mixed = kCubeFaces;
    mixed[2] = reversed[2];
    for (const auto& faces : {kCubeFaces, reversed, mixed}) {
        const Outcome cube = make(kCubePoints, faces);
        REQUIRE(cube.error.empty());
        CHECK(cube.warnings.size() == (faces == mixed ? 1 : 0));
        CHECK(test::holds(cube.model, cube.node, {0.9, 0.1, 0.5}));
        CHECK_FALSE(test::holds(cube.model, cube.node, {1.1, 0.1, 0.5}));
    }
}

TEST_CASE("polyhedron: faces that are not convex") {
    // A prism over a U: 4 x 3 less a notch of 2 x 2, height 2.
    const std::vector<std::array<double, 2>> outline = {{0, 0}, {4, 0}, {4, 3}, {3, 3},
                                                        {3, 1}, {1, 1}, {1, 3}, {0, 3}};
    std::vector<Vec3> points;
    for (const double z : {0.0, 2.0}) {
        for (const auto& p : outline) points.push_back({p[0], p[1], z});
    }
    std::vector<std::vector<double>> faces = {{0, 1, 2, 3, 4, 5, 6, 7}, {15, 14, 13, 12, 11, 10, 9, 8}};
    for (int i = 0; i < 8; ++i) {
        const int j = (i + 1) % 8;
        faces.push_back({double(i), double(i + 8), double(j + 8), double(j)});
    }
    const Outcome prism = make(points, faces);
    REQUIRE(prism.error.empty());
    CHECK(prism.warnings.empty());
    int wrong = 0;
    for (int i = 0; i < 13; ++i) {
        for (int j = 0; j < 13; ++j) {
            const Vec3 p = {-0.97 + 0.5 * i, -0.97 + 0.5 * j, 0.7};
            const bool inside =
                p[0] > 0 && p[0] < 4 && p[1] > 0 && p[1] < 3 && !(p[0] > 1 && p[0] < 3 && p[1] > 1);
            wrong += test::holds(prism.model, prism.node, p) != inside;
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("polyhedron: errors") {
    const auto refusal = [](const std::vector<Vec3>& points, const std::vector<std::vector<double>>& faces) {
        return make(points, faces).error;
    };
    const std::string start = "m.csg:3:7: 'polyhedron': ";
    CHECK(refusal({}, {}) == start + "0 faces; a closed surface needs at least four");
    auto faces = kCubeFaces;
    faces[4][2] = 8;
    CHECK(refusal(kCubePoints, faces) ==
          start + "face 4 uses point 8, which does not exist; there are 8, counted from 0");
    faces[4][2] = -1;
    CHECK(refusal(kCubePoints, faces).find("face 4 uses point -1") != std::string::npos);
    faces[4][2] = 1.5;
    CHECK(refusal(kCubePoints, faces).find("face 4 uses point 1.5") != std::string::npos);
    faces[4][2] = std::nan("");
    CHECK(refusal(kCubePoints, faces).find("face 4 uses point nan") != std::string::npos);
    faces[4] = {1, 2};
    CHECK(refusal(kCubePoints, faces) == start + "face 4 has 2 corners; expected at least three");
    auto points = kCubePoints;
    points[3][1] = std::numeric_limits<double>::infinity();
    CHECK(refusal(points, kCubeFaces) == start + "point 3 has the coordinate inf; expected finite numbers");
    points = kCubePoints;
    for (auto& point : points) point[2] = 0;
    CHECK(refusal(points, kCubeFaces).find("m.csg:3:7: 'polyhedron': ") == 0);
    CHECK(refusal(points, kCubeFaces).find("enclose no volume") != std::string::npos);
}
