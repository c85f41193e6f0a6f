// STL, OBJ and OFF: closed forms, repairs, refusals, and the corpora where they are present.
#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "host/model/outlines/polygon_triangles.hpp"
#include "tests/corpora.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/triangle_measures.hpp"

namespace fs = std::filesystem;
using namespace mortise;
using mortise::test::is_closed;
using mortise::test::volume;

namespace {

const TriangleSurface& surface_of(const Model& model) { return *model.nodes[0].primitive.triangles; }

/// A tetrahedron of volume 1/6 as triangles of coordinates, outwards.
const double kTetrahedronCorners[4][3][3] = {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}},
                                             {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                             {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                             {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

std::string ascii_tetrahedron(bool inside_out = false, const std::string& name = "name with words") {
    std::ostringstream text;
    text << "solid " << name << "\n";
    for (const auto& t : kTetrahedronCorners) {
        text << " facet normal nan 0 0\n  outer loop\n";
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& p = t[inside_out ? 2 - k : k];
            text << "   vertex " << p[0] << " +" << p[1] << " " << p[2] << "e-0\n";
        }
        text << "  endloop\n endfacet\n";
    }
    text << "endsolid " << name << "\n";
    return text.str();
}

std::string binary_tetrahedron(const std::string& header, float shift = 0) {
    std::string bytes = header;
    bytes.resize(80, ' ');
    const auto append = [&](const void* from, std::size_t size) {
        bytes.append(static_cast<const char*>(from), size);
    };
    const std::uint32_t count = 4;
    append(&count, 4);
    for (const auto& t : kTetrahedronCorners) {
        const float normal[3] = {0, 0, 0};
        append(normal, 12);
        for (const auto& p : t) {
            for (const double x : p) {
                const float value = static_cast<float>(x) + shift;
                append(&value, 4);
            }
        }
        bytes += std::string(2, '\0');
    }
    return bytes;
}

const char* const kCubeOfQuads =
    "# cube\nmtllib a.mtl\no cube\n"
    "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\n"
    "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvn 0 0 1\nvt 0 0\ns off\n"
    "f 4 3 2 1\nf 5/1/1 6/1/1 7/1/1 8/1/1\nf 1//1 2//1 6//1 5//1\n"
    "f -7 -6 \\\n -2 -3\nf 3 4 8 7 # last\nf 4 1 5 8\n";

}  // namespace

TEST_CASE("the same tetrahedron in every format") {
    const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    const std::string off =
        "OFF\n# points\n4 4 6\n0 0 0\n1 0 0\n0 1 0 # y\n\n0 0 1\n"
        "3 0 2 1\n3 0 1 3 255 0 0\n3 0 3 2\n3 1 2 3\n";
    const std::string coff =
        "COFF 4 4 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n0 0 1 1 0 0 1\n"
        "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    std::string upper = ascii_tetrahedron();
    for (char& c : upper) c = c >= 'a' && c <= 'z' && c != 'e' ? static_cast<char>(c - 'a' + 'A') : c;
    const std::pair<std::string, const char*> files[] = {
        {ascii_tetrahedron(), "stl"},
        {ascii_tetrahedron(true), "stl"},  // inside out: turned over
        {upper, "stl"},
        {ascii_tetrahedron(false, ""), "stl"},
        {binary_tetrahedron("binary"), "stl"},
        {binary_tetrahedron("solid as some programs write"), "stl"},
        {binary_tetrahedron(std::string("solid\0", 6)) + "appended", "stl"},
        {obj, "obj"},
        {off, "off"},
        {coff, "off"},
    };
    for (const auto& [content, format] : files) {
        CAPTURE(format);
        CAPTURE(content.substr(0, 40));
        const Model model = parse_model(content, format, std::string("folder/part.") + format);
        CHECK(model.regions.size() == 1);
        CHECK(model.regions[0].name == "part");
        CHECK(model.warnings.empty());
        CHECK(model.nodes[0].primitive.sharp_angle == 40);
        const TriangleSurface& surface = surface_of(model);
        CHECK(surface.points.size() == 4);
        CHECK(surface.triangles.size() == 4);
        CHECK(is_closed(surface));
        CHECK(volume(surface) == doctest::Approx(1.0 / 6));
        CHECK(test::region_at(model, {0.1, 0.1, 0.1}) == 1);
        CHECK(test::region_at(model, {0.5, 0.5, 0.5}) == 0);
    }
}

TEST_CASE("an OBJ of quadrilaterals with all kinds of indices") {
    const Model model = parse_model(kCubeOfQuads, "obj", "cube.obj");
    CHECK(surface_of(model).points.size() == 8);
    CHECK(surface_of(model).triangles.size() == 12);
    CHECK(is_closed(surface_of(model)));
    CHECK(volume(surface_of(model)) == doctest::Approx(1));
}

TEST_CASE("equal and nearly equal points are joined") {
    // The cube with a point of its own for each corner of each face, one moved by 1e-11.
    std::string text;
    const int faces[6][4] = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4},
                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    for (const auto& face : faces) {
        for (const int i : face) {
            const bool right = i == 1 || i == 2 || i == 5 || i == 6;
            const char* x = right ? "1" : "-0.0";
            if (&face == &faces[2] && i == 5) x = "1.00000000001";
            text += std::string("v ") + x + ((i & 2) != 0 ? " 1" : " 0") + (i >= 4 ? " 1\n" : " 0\n");
        }
        text += "f -4 -3 -2 -1\n";
    }
    const Model model = parse_model(text, "obj", "cube.obj");
    CHECK(surface_of(model).points.size() == 8);
    CHECK(is_closed(surface_of(model)));
    CHECK(model.warnings.empty());
}

namespace {

/// The unit cube, each triangle with points of its own, moved by up to `noise` along each axis; `copies`
/// times.
std::string noisy_cube(double noise, int copies = 1) {
    const int faces[6][4] = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4},
                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    std::mt19937 random(11);
    const auto moved = [&](bool high) {
        return (high ? 1.0 : 0.0) + noise * (static_cast<double>(random() % 2001) / 1000 - 1);
    };
    std::ostringstream text;
    text.precision(17);
    for (int copy = 0; copy < copies; ++copy) {
        for (const auto& face : faces) {
            for (const auto& triangle : {std::array<int, 3>{0, 1, 2}, std::array<int, 3>{0, 2, 3}}) {
                for (const int k : triangle) {
                    const int i = face[k];
                    const double x = moved(i == 1 || i == 2 || i == 5 || i == 6);
                    const double y = moved((i & 2) != 0);
                    text << "v " << x << " " << y << " " << moved(i >= 4) << "\n";
                }
                text << "f -3 -2 -1\n";
            }
        }
    }
    return text.str();
}

}  // namespace

TEST_CASE("points that noise keeps apart are joined, and faces along the axes are plane again") {
    for (const double noise : {1e-8, 1e-7, 1e-6, 1e-5}) {
        CAPTURE(noise);
        const Model model = parse_model(noisy_cube(noise), "obj", "cube.obj");
        const TriangleSurface& cube = surface_of(model);
        CHECK(cube.points.size() == 8);
        CHECK(cube.triangles.size() == 12);
        CHECK(is_closed(cube));
        CHECK(volume(cube) == doctest::Approx(1).epsilon(10 * noise));
        std::set<double> coordinates[3];
        for (const Vec3& point : cube.points) {
            for (std::size_t j = 0; j < 3; ++j) coordinates[j].insert(point[j]);
        }
        for (const auto& values : coordinates) CHECK(values.size() == 2);
        REQUIRE(model.warnings.size() == 1);
        CHECK(model.warnings[0].find("cube.obj: 28 points were joined with others up to ") == 0);
    }
    // Too much for noise: told, and left as it is.
    const Model torn = parse_model(noisy_cube(0.01), "obj", "cube.obj");
    CHECK(surface_of(torn).points.size() > 8);
    CHECK(torn.warnings[0].find("have only one triangle") != std::string::npos);
}

TEST_CASE("a body that is given twice is there once") {
    const Model model = parse_model(noisy_cube(0, 2), "obj", "cube.obj");
    CHECK(surface_of(model).triangles.size() == 12);
    CHECK(is_closed(surface_of(model)));
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0] == "cube.obj: 12 triangles were given more than once");
}

TEST_CASE("faces that disagree are turned over; open edges are reported") {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    const Model turned = parse_model(points + "f 1 2 3\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "obj", "t.obj");
    CHECK(is_closed(surface_of(turned)));
    CHECK(volume(surface_of(turned)) == doctest::Approx(1.0 / 6));
    REQUIRE(turned.warnings.size() == 1);
    CHECK(turned.warnings[0].find("t.obj: 1 triangle was turned over") == 0);

    const std::string bipyramid =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\n"
        "f 1 2 4\nf 1 4 3\nf 2 3 4\nf 2 1 5\nf 3 2 5\n";
    const Model open = parse_model(bipyramid, "obj", "t.obj");
    REQUIRE(open.warnings.size() == 1);
    CHECK(open.warnings[0].find("t.obj: 3 edges have only one triangle") == 0);

    // An inner surface that is inside out is a cavity; here the whole file is inside out, too.
    const std::string cavity = "v -9 -9 -9\nv 45 -9 -9\nv -9 45 -9\nv -9 -9 45\n";
    const Model shells = parse_model(
        points + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n" + cavity + "f 5 6 7\nf 5 8 6\nf 5 7 8\nf 6 8 7\n",
        "obj", "t.obj");
    CHECK(shells.warnings.empty());
    CHECK(volume(surface_of(shells)) == doctest::Approx(54.0 * 54 * 54 / 6 - 1.0 / 6));
    CHECK(test::region_at(shells, {0.1, 0.1, 0.1}) == 0);
    CHECK(test::region_at(shells, {-1, -1, -1}) == 1);
}

TEST_CASE("corners in the middle of an edge leave no crack") {
    // The top of the cube has a fifth corner where two faces of its front side meet.
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv .5 0 0\nv .5 0 1\n"
        "f 4 3 2 9 1\nf 5 10 6 7 8\nf 1 9 10 5\nf 9 2 6 10\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    const Model model = parse_model(text, "obj", "t.obj");
    CHECK(model.warnings.empty());
    CHECK(is_closed(surface_of(model)));
    CHECK(volume(surface_of(model)) == doctest::Approx(1));
}

TEST_CASE("polygons that are not convex are divided into triangles inside them") {
    const auto area_of = [](const std::vector<Vec3>& points,
                            const std::vector<std::array<std::uint32_t, 3>>& triangles, double& smallest) {
        double sum = 0;
        smallest = 1e300;
        for (const auto& t : triangles) {
            const auto& a = points[t[0]];
            const auto& b = points[t[1]];
            const auto& c = points[t[2]];
            const double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
            sum += area;
            smallest = std::min(smallest, area);
        }
        return sum;
    };
    const auto polygon_area = [](const std::vector<Vec3>& p) {
        double sum = 0;
        for (std::size_t i = 0; i < p.size(); ++i) {
            const Vec3& q = p[(i + 1) % p.size()];
            sum += p[i][0] * q[1] - p[i][1] * q[0];
        }
        return sum / 2;
    };
    std::vector<std::vector<Vec3>> polygons = {
        {{0, 0, 0}, {2, 0, 0}, {1, 0.5, 0}, {1, 2, 0}},  // arrow head
        {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}},  // U
        // A square with a square hole, joined by a bridge.
        {{0, 0, 0},
         {3, 0, 0},
         {3, 3, 0},
         {0, 3, 0},
         {0, 0, 0},
         {1, 1, 0},
         {1, 2, 0},
         {2, 2, 0},
         {2, 1, 0},
         {1, 1, 0}},
        // Corners along straight edges.
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}},
    };
    std::vector<Vec3> star;
    std::vector<Vec3> spiral;
    for (int i = 0; i < 60; ++i) {
        const double angle = i * 0.10471975511965977;
        const double radius = i % 2 == 0 ? 1 : 0.2;
        star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    for (int i = 0; i < 60; ++i)
        spiral.push_back({(1 + 0.05 * i) * std::cos(0.3 * i), (1 + 0.05 * i) * std::sin(0.3 * i), 0});
    for (int i = 59; i >= 0; --i)
        spiral.push_back({(0.9 + 0.05 * i) * std::cos(0.3 * i), (0.9 + 0.05 * i) * std::sin(0.3 * i), 0});
    polygons.push_back(star);
    polygons.push_back(spiral);
    for (const auto& polygon : polygons) {
        CAPTURE(polygon.size());
        std::vector<std::uint32_t> corners;
        for (std::uint32_t i = 0; i < polygon.size(); ++i) corners.push_back(i);
        std::vector<std::array<std::uint32_t, 3>> triangles;
        model_reader::triangulate_polygon(polygon, corners, triangles);
        CHECK(triangles.size() == polygon.size() - 2);
        double smallest = 0;
        const double area = area_of(polygon, triangles, smallest);
        // All triangles turn the same way as the polygon, and their areas add up: they lie inside it.
        const double expected = polygon_area(polygon);
        CHECK(area == doctest::Approx(expected));
        if (expected > 0) CHECK(smallest > 1e-6);
    }
}

TEST_CASE("triangle files: errors name the place and what was expected") {
    struct Case {
        std::string content;
        const char* format;
        const char* message;
    };
    std::string truncated = binary_tetrahedron("binary");
    truncated.resize(200);
    truncated[0] = '\x80';
    std::string infinite = binary_tetrahedron("binary", std::numeric_limits<float>::infinity());
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    const Case cases[] = {
        {"", "stl", "m.stl:1:1: expected 'solid' or a binary STL file, found end of file"},
        {"solid\n facet normal 0 0 1\n outer loop\n vertex 0 0\n", "stl",
         "m.stl:4:12: expected a coordinate"},
        {"solid\n facet normal 0 0 1\n outer loop\n vertex 0 0 nan\n", "stl",
         "m.stl:4:13: expected a coordinate (a finite number), found 'nan'"},
        {"solid\n facet normal 0 0 1\n outer loop\n vertex 0 0 1e999\n", "stl",
         "m.stl:4:13: the number '1e999' is too large"},
        {"solid\n facet normal 0 0 1\n loop\n", "stl", "m.stl:3:2: expected 'outer', found 'loop'"},
        {"solid a\n foo", "stl", "m.stl:2:2: expected 'facet' or 'endsolid', found 'foo'"},
        {"solid a\n", "stl", "m.stl:2:1: expected 'facet' or 'endsolid', found end of file"},
        {"solid a\nendsolid\nfoo", "stl", "m.stl:3:1: expected 'solid' or the end of file"},
        {"solid a\nendsolid\n", "stl", "m.stl: it has 0 triangles with an area"},
        {std::string("\0\0", 2), "stl", "m.stl: byte 2: the file ends inside its header"},
        {truncated, "stl", "m.stl: byte 200: the file ends after 2 of 4 triangles"},
        {infinite, "stl", "m.stl: byte 96: a coordinate of triangle 1 is inf"},
        {points + "f 1 2\n", "obj", "m.obj:5:1: this face has 2 corners"},
        {points + "f 1 2 x\n", "obj", "m.obj:5:7: expected the number of a point, found 'x'"},
        {points + "f 1 2.5 3\n", "obj", "m.obj:5:5: expected the number of a point, found '2.5'"},
        {points + "f 1 2 0\n", "obj", "m.obj:5:7: point 0 does not exist; points are counted from 1"},
        {points + "f 1 2 5\n", "obj", "m.obj:5:7: point 5 does not exist; there are 4 points"},
        {points + "f 1 2 -5\n", "obj", "m.obj:5:7: point 0 does not exist"},
        {points + "f 1 2 99999999999999999999\n", "obj",
         "m.obj:5:7: the number '99999999999999999999' is too large"},
        {"v 1 1 0\n" + points + "f -4 -3 -2\nf -4 -2 -3\nf -3 1 -2\nf -3 -2 1\n", "obj",
         "m.obj: its triangles enclose no volume"},
        {"", "obj", "m.obj: there are no faces (lines such as f 1 2 3); expected a Wavefront OBJ file"},
        {"<!DOCTYPE html>\n", "obj", "m.obj: there are no faces"},
        {std::string("\0\0v 1 2 3\n", 10), "obj",
         "m.obj:1:1: expected a Wavefront OBJ file, found byte 0x00"},
        {"v 1e300 0 0\n" + points + "f 1 2 3\nf 1 3 2\nf 1 2 3\nf 1 3 2\n", "obj",
         "m.obj: a coordinate is 1e+300; expected at most 1e100, choose other units"},
        {"v 1 2\n", "obj", "m.obj:1:6: expected a coordinate (a finite number), found the end of the line"},
        {"foo", "off", "m.off:1:1: expected OFF, COFF or NOFF, found 'foo'"},
        {"OFF BINARY\n", "off", "m.off:1:5: binary OFF files are not read"},
        {"OFF\n4 x 0\n", "off", "m.off:2:3: expected the number of faces, found 'x'"},
        {"OFF\n-4 1 0\n", "off", "m.off:2:1: expected the number of points"},
        {"OFF\n4 1 0\n0 0 0\n1 1 1\n", "off", "m.off:5:1: the file ends after 2 of 4 points"},
        {"OFF\n3 2 0\n0 0 0\n1 1 1\n1 0 0\n3 0 1 2\n", "off", "m.off:7:1: the file ends after 1 of 2 faces"},
        {"OFF\n3 1 0\n0 0 0\n1 1 1\n1 0 0\n3 0 1 3\n", "off",
         "m.off:6:7: point 3 does not exist; there are 3 points, counted from 0"},
        {"OFF\n3 1 0\n0 0 0\n1 1 1\n1 0 0\n2 0 1\n", "off", "m.off:6:1: this face has 2 corners"},
        {"OFF\n1000000000000 1 0\n0 0 0\n", "off",
         "m.off:4:1: the file ends after 1 of 1000000000000 points"},
    };
    for (const Case& c : cases) {
        const std::string message = test::refusal(c.content, c.format);
        CAPTURE(message);
        CAPTURE(c.message);
        CHECK(message.find(std::string("2 ") + c.message) == 0);
        CHECK(message.find('\n') == std::string::npos);
    }
}

TEST_CASE("what is not read of OBJ and OFF files is told once") {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    const std::string faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    CHECK(parse_model("# a\no b\nvn 0 0 1\n" + points + "s off\nusemtl c\n" + faces, "obj", "m.obj")
              .warnings.empty());
    const Model odd = parse_model(points + faces + "surf 0 1\nrubbish\n", "obj", "m.obj");
    REQUIRE(odd.warnings.size() == 1);
    CHECK(odd.warnings[0] == "m.obj:9:1: 2 lines are not known and not read, first 'surf'");
    const std::string off = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    CHECK(parse_model(off + "# end\n\n", "off", "m.off").warnings.empty());
    const Model more = parse_model(off + "2 0 1\n", "off", "m.off");
    REQUIRE(more.warnings.size() == 1);
    CHECK(more.warnings[0] == "m.off:11:1: what follows the last face is not read");
}

TEST_CASE("a large file is read fast") {
    // A torus of many facets; 50 MB/s and more on one core, asserted with a wide margin.
    constexpr int kRound = 400;
    std::ostringstream text;
    text.precision(9);
    text << "solid torus\n";
    const auto at = [](int i, int j) -> Vec3 {
        const double u = 6.283185307179586 * (i % kRound) / kRound;
        const double v = 6.283185307179586 * (j % kRound) / kRound;
        const double rho = 3 + std::cos(v);
        return {rho * std::cos(u), rho * std::sin(u), std::sin(v)};
    };
    for (int i = 0; i < kRound; ++i) {
        for (int j = 0; j < kRound; ++j) {
            const Vec3 corners[2][3] = {{at(i, j), at(i + 1, j), at(i + 1, j + 1)},
                                        {at(i, j), at(i + 1, j + 1), at(i, j + 1)}};
            for (const auto& triangle : corners) {
                text << "facet normal 0 0 0\nouter loop\n";
                for (const Vec3& p : triangle)
                    text << "vertex " << p[0] << " " << p[1] << " " << p[2] << "\n";
                text << "endloop\nendfacet\n";
            }
        }
    }
    text << "endsolid torus\n";
    const std::string content = text.str();
    const auto start = std::chrono::steady_clock::now();
    const Model model = parse_model(content, "stl", "torus.stl");
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double speed = static_cast<double>(content.size()) / 1e6 / seconds;
    std::cout << "ascii STL: " << content.size() / 1000000 << " MB, " << static_cast<int>(speed) << " MB/s\n";
    CHECK(speed > 5);
    CHECK(surface_of(model).points.size() == kRound * kRound);
    CHECK(surface_of(model).triangles.size() == 2 * kRound * kRound);
    CHECK(is_closed(surface_of(model)));
    CHECK(volume(surface_of(model)) == doctest::Approx(2 * 9.869604401089358 * 3).epsilon(1e-3));
}

TEST_CASE("every triangle file of the corpora is read") {
    const fs::path root = test::corpora_folder();
    for (const char* set :
         {"quartet-obj", "cgal-off", "manifold-obj", "netgen-tutorials", "openscad-examples"}) {
        if (!fs::is_directory(root / set)) {
            std::cout << "corpus " << set << ": skipped, no such folder\n";
            continue;
        }
        int count = 0;
        int open = 0;
        for (const auto& entry : fs::recursive_directory_iterator(root / set)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".stl" && extension != ".obj" && extension != ".off") continue;
            CAPTURE(entry.path().string());
            const Model model = read_model(entry.path().string());
            ++count;
            CHECK(volume(surface_of(model)) > 0);
            CHECK(is_closed(surface_of(model)) == model.warnings.empty());
            if (!model.warnings.empty()) ++open;
        }
        std::cout << "corpus " << set << ": " << count << " triangle files read, " << open
                  << " with warnings\n";
    }
}

TEST_CASE("faces with very many corners take no quadratic time") {
    std::ostringstream text;
    constexpr int kCorners = 200000;
    text << "v 0 0 1\n";
    for (int i = 0; i < kCorners; ++i) {
        const double angle = 6.283185307179586 * i / kCorners;
        const double radius = i % 2 == 0 ? 1 : 0.9;
        text << "v " << radius * std::cos(angle) << " " << radius * std::sin(angle) << " 0\n";
    }
    text << "f";
    for (int i = 0; i < kCorners; ++i) text << " " << kCorners + 1 - i;
    text << "\n";
    for (int i = 0; i < kCorners; ++i) text << "f 1 " << 2 + i << " " << 2 + (i + 1) % kCorners << "\n";
    const Model model = parse_model(text.str(), "obj", "t.obj");
    CHECK(volume(surface_of(model)) == doctest::Approx(0.9 * 3.14159265 / 3).epsilon(1e-3));
}
