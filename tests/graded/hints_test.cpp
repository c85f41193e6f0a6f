// Netgen's singular, point and closesurfaces statements: how many cells there are where they ask for some.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

Meshed mesh_geo(const std::string& text, int level, int coarsening = 0) {
    MeshOptions options;
    options.level = level;
    options.interior_coarsening = coarsening;
    options.improve = false;
    return mesh_and_check(parse_model("algebraic3d\n" + text, "geo", "hints.geo"), options);
}

/// The largest extent along an axis of the elements with a node for which `choose` holds.
template <typename Choose>
double widest(const Mesh& mesh, Choose choose) {
    double width = 0;
    for (int t = 0; t < kElementTypes; ++t) {
        const auto& nodes = mesh.elements[static_cast<std::size_t>(t)].nodes;
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        for (std::size_t i = 0; i < nodes.size(); i += size) {
            bool chosen = false;
            Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
            for (std::size_t k = 0; k < size; ++k) {
                const double* p = mesh.points.data() + 3 * std::size_t{nodes[i + k]};
                chosen = chosen || choose(p);
                for (std::size_t j = 0; j < 3; ++j) {
                    low[j] = std::min(low[j], p[j]);
                    high[j] = std::max(high[j], p[j]);
                }
            }
            if (!chosen) continue;
            for (std::size_t j = 0; j < 3; ++j) width = std::max(width, high[j] - low[j]);
        }
    }
    return width;
}

const char* const kBrick =
    "solid p = plane(0,0,0;0,0,-1); solid q = plane(0,0,1;0,0,1); solid r = plane(0,0,0;-1,0,0);"
    "solid s = plane(1,0,0;1,0,0); solid t = plane(0,0,0;0,-1,0); solid u = plane(0,1,0;0,1,0);"
    "solid a = p and q and r and s and t and u; tlo a;";

}  // namespace

TEST_CASE("singular edges, points and faces: two levels, or the size that is given") {
    const Meshed plain = mesh_geo(kBrick, 4);
    const double cell = plain.report.cell_size;
    REQUIRE(plain.report.finest_level == 4);
    const auto near = [](double a, double b) { return std::fabs(a - b) < 1e-9; };
    struct Case {
        const char* text;
        double size;  ///< in cells
        bool edge, point;
    };
    for (const Case& c :
         {Case{"singular edge p r;", 0.25, true, true},
          Case{"singular edge p r -maxh=0.01;", 0.125, true, true},
          Case{"singular point p r t;", 0.25, false, true}, Case{"singular face a p;", 0.25, true, true},
          Case{"point (0, 0, 0);", 0.25, false, true},
          Case{"point (0, 0, 0) -maxh=0.01;", 0.125, false, true}}) {
        CAPTURE(std::string(c.text));
        const Meshed m = mesh_geo(std::string(kBrick) + c.text, 4);
        CHECK(m.defects == "");
        CHECK(m.check.volume == doctest::Approx(1).epsilon(1e-9));
        CHECK(m.report.finest_level == (c.size < 0.25 ? 7 : 6));
        const double at_edge =
            widest(m.mesh, [&](const double* p) { return near(p[0], 0) && near(p[2], 0); });
        const double at_point =
            widest(m.mesh, [&](const double* p) { return near(p[0], 0) && near(p[1], 0) && near(p[2], 0); });
        CHECK((at_edge <= c.size * cell * 1.001) == c.edge);
        CHECK((at_point <= c.size * cell * 1.001) == c.point);
        // Far away everything is as it was.
        CHECK(widest(m.mesh, [&](const double* p) { return near(p[0], 1) && near(p[2], 1); }) ==
              doctest::Approx(cell));
    }
}

TEST_CASE("closesurfaces: two cells across a gap and across a wall, no more elsewhere") {
    // A gap of 0.03 between two bricks; a cell has 1/14.
    const char* gap =
        "solid p = plane(0,0,0.5;0,0,1); solid q = plane(0,0,0.53;0,0,-1);"
        "solid a = orthobrick(0,0,0;1,1,1) and p; solid b = orthobrick(0,0,0;1,1,1) and q; tlo a; tlo b;";
    const Meshed plain = mesh_geo(gap, 4);
    CHECK(plain.report.finest_level == 4);
    const Meshed fine = mesh_geo(std::string(gap) + "identify closesurfaces p q;", 4);
    CHECK(fine.defects == "");
    CHECK(fine.check.volume == doctest::Approx(0.97).epsilon(1e-6));
    const double finest = std::ldexp(fine.report.cell_size, 4 - fine.report.finest_level);
    CHECK(finest <= 0.015);
    CHECK(finest > 0.0075);
    const auto at = [](double z) { return [z](const double* p) { return std::fabs(p[2] - z) < 1e-9; }; };
    CHECK(widest(fine.mesh, at(0.5)) <= 0.015 * 1.001);
    CHECK(widest(fine.mesh, at(0.53)) <= 0.015 * 1.001);
    CHECK(widest(fine.mesh, at(0)) == doctest::Approx(fine.report.cell_size));

    // A shell between two spheres: nodes on both, and others between them.
    const char* shell =
        "solid i = sphere(0,0,0;0.9); solid o = sphere(0,0,0;1); solid a = o and not i; tlo a;";
    const Meshed shell_fine = mesh_geo(std::string(shell) + "identify closesurfaces i o;", 4, 2);
    CHECK(shell_fine.defects == "");
    const double volume = 4.0 / 3 * 3.14159265358979 * (1 - 0.729);
    CHECK(shell_fine.check.volume == doctest::Approx(volume).epsilon(0.01));
    CHECK(std::ldexp(shell_fine.report.cell_size, 4 - shell_fine.report.finest_level) <= 0.05);
    CHECK(shell_fine.report.finest_level <= 7);
}

TEST_CASE("hints are sizes of the model: --no-model-sizes drops them") {
    MeshOptions options;
    options.level = 4;
    options.model_sizes = false;
    const Meshed m = mesh_and_check(
        parse_model(std::string("algebraic3d\n") + kBrick + "singular edge p r;", "geo", "hints.geo"),
        options);
    CHECK(m.report.finest_level == 4);
}

}  // namespace mortise::test
