// Large files of every format are read at tens of megabytes per second: no step may take more than time
// linear in the file. Asserted with a wide margin, since machines are shared; the figures are printed.
#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <iostream>
#include <sstream>

#include "mortise/model.hpp"

using namespace mortise;

namespace {

constexpr double kTurn = 6.283185307179586;

Model timed(const std::string& text, const std::string& format, const std::string& what) {
    const auto start = std::chrono::steady_clock::now();
    Model model = parse_model(text, format, "m." + format);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double speed = static_cast<double>(text.size()) / 1e6 / seconds;
    std::cout << what << ": " << text.size() / 1000000 << " MB, " << static_cast<int>(speed) << " MB/s\n";
    CHECK(speed > 8);
    return model;
}

/// A torus of kRound x kRound squares, by functions that write its points and its squares.
constexpr int kRound = 500;

void write_torus(std::ostringstream& text, const std::function<void(double, double, double)>& point,
                 const std::function<void()>& between, const std::function<void(int, int, int, int)>& face) {
    text.precision(9);
    for (int i = 0; i < kRound; ++i) {
        for (int j = 0; j < kRound; ++j) {
            const double u = kTurn * i / kRound;
            const double v = kTurn * j / kRound;
            point((3 + std::cos(v)) * std::cos(u), (3 + std::cos(v)) * std::sin(u), std::sin(v));
        }
    }
    between();
    for (int i = 0; i < kRound; ++i) {
        for (int j = 0; j < kRound; ++j) {
            const int next = (i + 1) % kRound;
            const int up = (j + 1) % kRound;
            face(kRound * i + j, kRound * next + j, kRound * next + up, kRound * i + up);
        }
    }
}

std::size_t triangles_of(const Model& model) {
    return model.nodes[model.regions[0].root].primitive.triangles->triangles.size();
}

}  // namespace

TEST_CASE("large .csg files") {
    std::ostringstream text;
    constexpr int kBoxes = 50000;
    for (int i = 0; i < kBoxes; ++i) {
        text
            << "multmatrix([[1, 0, 0, " << 3 * i << ".125], [0, 0.8, -0.6, " << i % 97
            << ".5], [0, 0.6, 0.8, 0.0625], [0, 0, 0, 1]]) {\n\tcube(size = [1, 2, 3], center = false);\n}\n";
    }
    CHECK(timed(text.str(), "csg", ".csg of boxes").nodes.size() > 2 * kBoxes);

    std::ostringstream torus;
    torus << "polyhedron(points = [";
    bool first = true;
    const auto comma = [&] {
        if (!first) torus << ", ";
        first = false;
    };
    write_torus(
        torus,
        [&](double x, double y, double z) {
            comma();
            torus << "[" << x << ", " << y << ", " << z << "]";
        },
        [&] {
            torus << "], faces = [";
            first = true;
        },
        [&](int a, int b, int c, int d) {
            comma();
            torus << "[" << d << ", " << c << ", " << b << ", " << a << "]";
        });
    torus << "], convexity = 1);\n";
    CHECK(triangles_of(timed(torus.str(), "csg", ".csg of a polyhedron")) == 2 * kRound * kRound);
}

TEST_CASE("large .geo files") {
    std::ostringstream text;
    text << "algebraic3d\n";
    constexpr int kBalls = 50000;
    for (int i = 0; i < kBalls; ++i) {
        text << "solid s" << i << " = sphere(" << i << ".25, 0, 0; 0.75) and orthobrick(" << i << ", -9, -9; "
             << i + 1 << ", 9, 9) -maxh=0.5;\n";
    }
    text << "solid all = s0";
    for (int i = 1; i < kBalls; ++i) text << " or\n s" << i;
    text << ";\ntlo all;\n";
    const Model model = timed(text.str(), "geo", ".geo of balls");
    CHECK(model.nodes[model.regions[0].root].children.size() == kBalls);
}

TEST_CASE("large .vm files") {
    std::ostringstream text;
    text << "_0 var-x\n_1 var-y\n_2 var-z\n" << std::hex;
    constexpr int kSteps = 200000;
    for (int i = 3; i < kSteps; i += 3) {
        text << "_" << i << " const 1.5\n_" << i + 1 << " sub _0 _" << i << "\n_" << i + 2 << " max _"
             << i + 1 << " _" << i - 1 << "\n";
    }
    CHECK(timed(text.str(), "vm", ".vm").nodes.size() == 1);
}

TEST_CASE("large triangle files") {
    std::ostringstream obj;
    write_torus(
        obj, [&](double x, double y, double z) { obj << "v " << x << " " << y << " " << z << "\n"; }, [] {},
        [&](int a, int b, int c, int d) {
            obj << "f " << a + 1 << " " << b + 1 << " " << c + 1 << " " << d + 1 << "\n";
        });
    CHECK(triangles_of(timed(obj.str(), "obj", ".obj")) == 2 * kRound * kRound);
    std::ostringstream off;
    off << "OFF\n" << kRound * kRound << " " << kRound * kRound << " 0\n";
    write_torus(
        off, [&](double x, double y, double z) { off << x << " " << y << " " << z << "\n"; }, [] {},
        [&](int a, int b, int c, int d) { off << "4 " << a << " " << b << " " << c << " " << d << "\n"; });
    CHECK(triangles_of(timed(off.str(), "off", ".off")) == 2 * kRound * kRound);

    std::ostringstream unused;
    std::vector<std::array<float, 3>> points;
    std::string stl(84, ' ');
    const auto append = [&stl](const void* data, std::size_t size) {
        stl.append(static_cast<const char*>(data), size);
    };
    write_torus(
        unused,
        [&](double x, double y, double z) {
            points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
        },
        [] {},
        [&](int a, int b, int c, int d) {
            for (const auto& corners : {std::array<int, 3>{a, b, c}, std::array<int, 3>{a, c, d}}) {
                const std::array<float, 3> normal{};
                append(normal.data(), 12);
                for (const int corner : corners) append(points[static_cast<std::size_t>(corner)].data(), 12);
                stl.append(2, '\0');
            }
        });
    const std::uint32_t count = 2 * kRound * kRound;
    std::memcpy(&stl[80], &count, 4);
    CHECK(triangles_of(timed(stl, "stl", "binary .stl")) == count);
}
