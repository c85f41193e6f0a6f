// Which flat faces of a polyhedron make one curved surface.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/tape/facets.hpp"
#include "tests/triangles/shapes.hpp"

namespace mortise::test {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kSharp = 40;

/// A prism whose outline turns by these degrees between edges of length 1 at its bottom, and by more
/// elsewhere.
TriangleSurface bent_prism(const std::vector<double>& turns, double height) {
    double direction = -0.5 * std::accumulate(turns.begin(), turns.end(), 0.0);
    std::vector<std::array<double, 2>> outline = {{-0.5 * static_cast<double>(turns.size() + 1), -3}};
    const auto go = [&](double degrees, double length) {
        const auto last = outline.back();
        outline.push_back(
            {last[0] + length * std::cos(degrees * kDegree), last[1] + length * std::sin(degrees * kDegree)});
    };
    go(direction, 1);
    for (const double turn : turns) go(direction += turn, 1);
    const double left = outline.front()[0];
    go(direction + 60, 6);
    outline.push_back({left, outline.back()[1]});
    return prism(outline, height);
}

std::size_t patches(const TriangleSurface& surface) { return tape::find_facets(surface, kSharp).patches; }

/// Cuts a triangle into three, so that its face no longer looks like a facet.
void divide_all(TriangleSurface& surface) {
    const std::size_t count = surface.triangles.size();
    for (std::size_t t = 0; t < count; ++t) {
        const auto c = surface.triangles[t];
        Vec3 middle{};
        for (std::size_t j = 0; j < 3; ++j) {
            middle[j] = (surface.points[c[0]][j] + surface.points[c[1]][j] + surface.points[c[2]][j]) / 3;
        }
        const auto m = static_cast<std::uint32_t>(surface.points.size());
        surface.points.push_back(middle);
        surface.triangles[t] = {c[0], c[1], m};
        surface.triangles.push_back({c[1], c[2], m});
        surface.triangles.push_back({c[2], c[0], m});
    }
}

}  // namespace

TEST_CASE("one small turn between faces is a crease, a row of them is a curve") {
    for (const auto& [turns, joined] :
         std::vector<std::pair<std::vector<double>, std::size_t>>{{{30}, 0},
                                                                  {{30, 30}, 0},
                                                                  {{30, 30, 30}, 3},
                                                                  {{15, 15, 15, 15}, 4},
                                                                  {{12, 39, 12}, 0},
                                                                  {{9}, 1}}) {
        CAPTURE(turns.size());
        CAPTURE(turns[0]);
        TriangleSurface surface = bent_prism(turns, 2);
        divide_all(surface);
        const std::size_t faces = turns.size() + 1 + 5;  // and top, bottom and three that close the outline
        CHECK(tape::find_facets(surface, 0).patches == faces);
        CHECK(patches(surface) == faces - joined);
    }
}

TEST_CASE("coarse tessellations are smooth: prisms, balls") {
    std::vector<std::array<double, 2>> outline;
    for (int k = 0; k < 10; ++k) outline.push_back({std::cos(36 * k * kDegree), std::sin(36 * k * kDegree)});
    TriangleSurface ten = prism(outline, 1);
    CHECK(patches(ten) == 3);
    divide_all(ten);
    CHECK(patches(ten) == 3);
    CHECK(patches(unit_sphere(2)) == 1);
}

TEST_CASE("a smooth ring that meets itself at a corner is parted where it turns most") {
    std::vector<std::array<double, 2>> outline;  // three quarters of a circle, and its tangents
    for (int k = 0; k <= 27; ++k)
        outline.push_back({std::cos((135 + 10 * k) * kDegree), std::sin((135 + 10 * k) * kDegree)});
    outline.push_back({0, std::sqrt(2)});
    const TriangleSurface teardrop = prism(outline, 1);
    const tape::Facets facets = tape::find_facets(teardrop, kSharp);
    CHECK(facets.patches == 4);  // with top and bottom
    std::size_t walls[4] = {};
    for (std::size_t t = 0; t < teardrop.triangles.size(); ++t) {
        const std::uint32_t plane = facets.of_triangle[t];
        if (std::fabs(facets.planes[plane][2]) < 0.5) ++walls[facets.patch_of_plane[plane]];
    }
    std::sort(walls, walls + 4);
    CHECK(walls[1] == 0);
    CHECK(walls[2] + walls[3] == 2 * outline.size());
    CHECK(walls[3] - walls[2] <= 4);  // triangles, two a face
}

}  // namespace mortise::test
