// Extrusions of outlines with many edges: one surface of triangles, watertight, with the outline's volume.
#include "host/common/constants.hpp"
#include "host/model/solids/swept_outline.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/common/random.hpp"
#include "host/model/outlines/polygons.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"
#include "tests/model/triangle_measures.hpp"

using namespace mortise;
using model_reader::Contours;
using model_reader::Vec2;
using mortise::test::read_csg;
using test::is_closed;
using test::region_at;
using test::volume;

namespace {

/// Area of the triangles of a cap, each counted with its sign: no overlap if both sums agree.
std::pair<double, double> cap_areas(const TriangleSurface& surface, std::uint32_t group) {
    std::pair<double, double> sums{0, 0};
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        if (surface.group[t] != group) continue;
        const Vec3& a = surface.points[surface.triangles[t][0]];
        const Vec3& b = surface.points[surface.triangles[t][1]];
        const Vec3& c = surface.points[surface.triangles[t][2]];
        const double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
        sums.first += area;
        sums.second += std::fabs(area);
    }
    return sums;
}

double area_of(const Contours& loops) {
    double sum = 0;
    for (const auto& loop : loops) sum += model_reader::signed_area(loop);
    return sum;
}

/// A star-shaped loop about a point, with random radii.
std::vector<Vec2> blob(Random& random, const Vec2& centre, double radius, int points) {
    std::vector<Vec2> loop;
    for (int i = 0; i < points; ++i) {
        const double turn = 2 * kPi * i / points;
        const double r = radius * (0.4 + 0.6 * random.uniform());
        loop.push_back({centre[0] + r * std::cos(turn), centre[1] + r * std::sin(turn)});
    }
    return loop;
}

const Primitive* polyhedron_of(const Model& model) {
    const auto found = std::find_if(model.nodes.begin(), model.nodes.end(),
                                    [](const CsgNode& node) { return node.primitive.triangles != nullptr; });
    return found == model.nodes.end() ? nullptr : &found->primitive;
}

std::string polygon(const std::vector<Vec2>& loop) {
    std::string text;
    for (const Vec2& p : loop) {
        text += (text.empty() ? "[" : ",[") + std::to_string(p[0]) + "," + std::to_string(p[1]) + "]";
    }
    return "polygon(points = [" + text + "]);";
}

/// `count` teeth of square profile: not convex, 4 edges a tooth, all corners sharp.
std::vector<Vec2> comb(int count) {
    std::vector<Vec2> loop = {{0, -1}, {static_cast<double>(2 * count - 1), -1}};
    for (int i = count; i-- > 0;) {
        loop.push_back({2.0 * i + 1, 1});
        loop.push_back({2.0 * i, 1});
        if (i == 0) break;
        loop.push_back({2.0 * i, 0});
        loop.push_back({2.0 * i - 1, 0});
    }
    return loop;
}

std::string next_name() { return "side"; }

}  // namespace

TEST_CASE("prisms over random outlines with holes are closed, and their caps do not overlap") {
    Random random(3);
    for (int round = 0; round < 200; ++round) {
        Contours given = {blob(random, {0, 0}, 10, 40)};
        // Apart in every other round, else they cross.
        const bool apart = round % 2 == 0;
        for (int hole = 0; hole < 6; ++hole) {
            const Vec2 centre = {apart ? 2.0 * (hole % 3) - 2 : 6 * random.uniform() - 3,
                                 apart ? 2.0 * (hole / 3) - 1 : 6 * random.uniform() - 3};
            given.push_back(blob(random, centre, apart ? 0.99 : 1.2, 9));
        }
        given.push_back(blob(random, {25, 0}, 5, 20));
        const Contours loops = model_reader::normalised(given);
        const double area = area_of(loops);
        const double low_scale = round % 3 == 1 ? 0 : 1;
        const double high_scale = round % 3 == 2 ? 0 : 1.5;
        const Primitive solid = model_reader::prism(loops, {-1, 2, low_scale, high_scale}, 0, next_name);
        const TriangleSurface& surface = *solid.triangles;
        CAPTURE(round);
        CHECK(is_closed(surface));
        const double mean = (low_scale * low_scale + low_scale * high_scale + high_scale * high_scale) / 3;
        CHECK(volume(surface) == doctest::Approx(3 * area * mean).epsilon(1e-10));
        for (const std::uint32_t cap : {0U, 1U}) {
            const double scale = cap == 0 ? low_scale : high_scale;
            const auto [sum, absolute] = cap_areas(surface, cap);
            CHECK(std::fabs(sum) == doctest::Approx(area * scale * scale).epsilon(1e-10));
            // Where holes meet in several points, some triangles overlap; the sum is right all the same.
            if (apart) CHECK(absolute == doctest::Approx(std::fabs(sum)).epsilon(1e-9));
        }
    }
}

TEST_CASE("many holes in rows, and holes that share corners with the outline") {
    Contours given = {{{0, 0}, {21, 0}, {21, 21}, {0, 21}}};
    for (int i = 0; i < 10; ++i) {
        for (int j = 0; j < 10; ++j) {
            const double x = 2 * i + 1;
            const double y = 2 * j + 1;
            given.push_back({{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}});
        }
    }
    const Contours rows = model_reader::normalised(given);
    REQUIRE(rows.size() == 101);
    const Primitive plate = model_reader::prism(rows, {}, 0, next_name);
    CHECK(is_closed(*plate.triangles));
    CHECK(volume(*plate.triangles) == doctest::Approx(441 - 100));
    const auto [sum, absolute] = cap_areas(*plate.triangles, 1);
    CHECK(absolute == doctest::Approx(sum));

    const Contours touching = model_reader::normalised(
        {{{0, 0}, {6, 0}, {6, 6}, {0, 6}}, {{6, 3}, {3, 5}, {2, 3}}, {{0, 3}, {1, 2}, {1, 4}}});
    const Primitive notched = model_reader::prism(touching, {}, 0, next_name);
    CHECK(is_closed(*notched.triangles));
    CHECK(volume(*notched.triangles) == doctest::Approx(36 - 4 - 1));
}

TEST_CASE("which outlines become prisms") {
    const auto kind = [](const std::string& shape, Facets facets = Facets::kSmooth,
                         const std::string& how = "height = 2") {
        const Model model = read_csg("linear_extrude(" + how + ") { " + shape + " }", facets);
        const Primitive* solid = polyhedron_of(model);
        return solid == nullptr ? -1 : solid->sharp_angle;
    };
    const std::string small = "polygon(points = [[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]]);";
    const std::string round = "offset(r = 1) { " + small + " }";
    CHECK(kind(small) == -1);
    CHECK(kind("square();") == -1);
    CHECK(kind("circle(r = 2, $fn = 12);") == -1);
    CHECK(kind("circle(r = 2);") == -1);
    CHECK(kind(polygon(comb(3))) == 0);
    CHECK(kind(polygon(comb(20))) == 0);
    CHECK(kind(round) == model_reader::kSmoothTurn);
    // Facets as they are: convex loops are planes, the others have one plane for each edge.
    CHECK(kind("offset(r = 1) { square(size = 4); }", Facets::kExact) == -1);
    CHECK(kind("offset(r = 1, $fn = 40) { " + small + "}", Facets::kExact) == 0);
    CHECK(kind("offset(r = 1, $fn = 40) { " + small + "}") == model_reader::kSmoothTurn);
    // Twisted and unevenly scaled sides are not plane: formulas, but for curves.
    CHECK(kind(polygon(comb(3)), Facets::kSmooth, "height = 2, twist = 10") == -1);
    CHECK(kind(polygon(comb(3)), Facets::kSmooth, "height = 2, scale = [1, 2]") == -1);
    CHECK(kind(polygon(comb(3)), Facets::kSmooth, "height = 2, scale = 0") == 0);
    // Along a curve that is twisted steeply, triangles turn by more.
    CHECK(kind(round, Facets::kSmooth, "height = 2, twist = 10") > model_reader::kSmoothTurn);
    CHECK(kind(round, Facets::kSmooth, "height = 2, scale = [1, 2]") == model_reader::kSmoothTurn);
    CHECK(kind(round, Facets::kSmooth, "height = 2, twist = 10, scale = 0") == -1);
    CHECK(kind(round, Facets::kExact, "height = 2, twist = 10") == -1);
    CHECK(kind("circle(r = 2);", Facets::kSmooth, "height = 2, twist = 10") == -1);
}

TEST_CASE("swept outlines are closed and have the volume of what sweeps them") {
    Random random(4);
    for (int round = 0; round < 20; ++round) {
        // A ring about the axis, and a solid with its edge on it.
        Contours given = {blob(random, {12, 0}, 10, 60), blob(random, {12, 0}, 3, 30)};
        std::vector<Vec2> onto_axis = {{0, 20}, {0, 40}};
        for (int i = 0; i <= 20; ++i) {
            onto_axis.push_back(
                {10 * std::sin(kPi * (20 - i) / 20), 30 + 10 * std::cos(kPi * (20 - i) / 20)});
        }
        onto_axis[2][0] = onto_axis.back()[0] = 0;
        std::reverse(onto_axis.begin(), onto_axis.end());
        given.push_back(onto_axis);
        const Contours loops = model_reader::normalised(given);
        double moment = 0;  // ∫ x over the outline
        for (const auto& loop : loops) {
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Vec2& p = loop[i];
                const Vec2& q = loop[(i + 1) % loop.size()];
                moment += (p[0] * q[1] - q[0] * p[1]) * (p[0] + q[0]) / 6;
            }
        }
        model_reader::OutlineRows ring;
        ring.is_ring = true;
        ring.count = 36;
        ring.place = [](const Vec2& p, std::size_t row, std::size_t count) {
            const double angle = -2 * kPi * static_cast<double>(row) / static_cast<double>(count);
            return Vec3{p[0] * std::cos(angle), p[0] * std::sin(angle), p[1]};
        };
        const auto revolved = model_reader::swept_outline(loops, ring, 20, true, next_name);
        REQUIRE(revolved);
        CAPTURE(round);
        CHECK(is_closed(*revolved->triangles));
        // Between two rows points move along chords.
        CHECK(volume(*revolved->triangles) ==
              doctest::Approx(36 * std::sin(2 * kPi / 36) * moment).epsilon(1e-9));

        model_reader::OutlineRows twisted;
        twisted.count = 91;
        twisted.place = [](const Vec2& p, std::size_t row, std::size_t count) {
            const double along = static_cast<double>(row) / static_cast<double>(count - 1);
            const double angle = along * kPi / 2;
            return Vec3{p[0] * std::cos(angle) - p[1] * std::sin(angle),
                        p[0] * std::sin(angle) + p[1] * std::cos(angle), 30 * along};
        };
        const auto turned = model_reader::swept_outline(loops, twisted, 20, true, next_name);
        REQUIRE(turned);
        CHECK(is_closed(*turned->triangles));
        CHECK(volume(*turned->triangles) == doctest::Approx(30 * area_of(loops)).epsilon(2e-3));
    }
    // A coarse outline that is twisted steeply keeps its straight edges: arcs would make it another solid.
    std::vector<Vec2> coarse;
    for (int i = 0; i < 20; ++i) {
        coarse.push_back({7 * std::cos(2 * kPi * i / 20), 7 * std::sin(2 * kPi * i / 20)});
    }
    model_reader::OutlineRows steep;
    steep.count = 541;
    steep.twist = 3 * kPi / 18;
    steep.place = [](const Vec2& p, std::size_t row, std::size_t count) {
        const double along = static_cast<double>(row) / static_cast<double>(count - 1);
        const double angle = along * 3 * kPi;
        return Vec3{p[0] * std::cos(angle) - p[1] * std::sin(angle),
                    p[0] * std::sin(angle) + p[1] * std::cos(angle), 18 * along};
    };
    const Contours coarse_loops = model_reader::normalised({coarse});
    const auto worm = model_reader::swept_outline(coarse_loops, steep, 14, true, next_name);
    REQUIRE(worm);
    CHECK(is_closed(*worm->triangles));
    CHECK(volume(*worm->triangles) == doctest::Approx(18 * area_of(coarse_loops)).epsilon(3e-3));
    // No more triangles than it can do with.
    model_reader::OutlineRows many;
    many.count = 1000;
    many.place = [](const Vec2& p, std::size_t row, std::size_t) {
        return Vec3{p[0], p[1], static_cast<double>(row)};
    };
    const Contours fine = {blob(random, {0, 0}, 1, 300)};
    const auto fewer = model_reader::swept_outline(fine, many, 2, true, next_name);
    REQUIRE(fewer);
    CHECK(fewer->triangles->triangles.size() <= 400000 + 600);
    many.count = 4000000;
    CHECK_FALSE(model_reader::swept_outline(fine, many, 2, true, next_name));
}

TEST_CASE("polyhedra of many faces are smooth where these turn by little") {
    // A ball of 12 x 6 points, and the same with facets as they are; a tetrahedron.
    std::string points = "[0,0,-1],[0,0,1]";
    std::string faces;
    for (int i = 0; i < 18; ++i) {
        for (int j = 1; j < 9; ++j) {
            const double a = 2 * kPi * i / 18;
            const double b = kPi * j / 9;
            points += ",[" + std::to_string(std::sin(b) * std::cos(a)) + "," +
                      std::to_string(std::sin(b) * std::sin(a)) + "," + std::to_string(-std::cos(b)) + "]";
        }
    }
    const auto face = [&faces](const std::vector<int>& corners) {
        faces += faces.empty() ? "[" : ",[";
        for (std::size_t k = 0; k < corners.size(); ++k)
            faces += (k == 0 ? "" : ",") + std::to_string(corners[k]);
        faces += "]";
    };
    for (int i = 0; i < 18; ++i) {
        const int a = 2 + 8 * i;
        const int b = 2 + 8 * ((i + 1) % 18);
        face({0, a, b});
        face({1, b + 7, a + 7});
        for (int j = 0; j < 7; ++j) face({a + j, a + j + 1, b + j + 1, b + j});
    }
    const std::string ball = "polyhedron(points = [" + points + "], faces = [" + faces + "]);";
    const Model smooth = read_csg(ball);
    REQUIRE(polyhedron_of(smooth) != nullptr);
    CHECK(polyhedron_of(smooth)->sharp_angle == model_reader::kSmoothTurn);
    const Model exact = read_csg(ball, Facets::kExact);
    CHECK((polyhedron_of(exact) == nullptr || polyhedron_of(exact)->sharp_angle <= 1));
    const Model few = read_csg(
        "polyhedron(points = [[0,0,0],[9,0,0],[0,9,0],[3,3,0.3]], faces = "
        "[[0,1,2],[0,3,1],[1,3,2],[2,3,0]]);");
    CHECK((polyhedron_of(few) == nullptr || polyhedron_of(few)->sharp_angle <= 1));
}

TEST_CASE("sides: one name for each curve") {
    // A half disc: one curve and one straight edge.
    std::vector<Vec2> half;
    for (int i = 0; i <= 30; ++i) half.push_back({std::cos(kPi * i / 30), std::sin(kPi * i / 30)});
    for (std::size_t turned = 0; turned < half.size(); turned += 7) {
        std::vector<Vec2> loop = half;
        std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(turned), loop.end());
        const Model model = read_csg("linear_extrude(height = 1) { " + polygon(loop) + " }");
        const Primitive* solid = polyhedron_of(model);
        REQUIRE(solid != nullptr);
        const auto& names = solid->triangles->group_names;
        CHECK(names == std::vector<std::string>{"bottom", "top", "side1", "side2"});
        std::map<std::string, int> count;
        for (const std::uint32_t group : solid->triangles->group) ++count[names[group]];
        CHECK(std::min(count["side1"], count["side2"]) == 2);
        CHECK(std::max(count["side1"], count["side2"]) == 60);
    }
    const auto sides = [](const std::string& shape) {
        const Model model = read_csg("linear_extrude(height = 1) { " + shape + " }");
        const auto& names = polyhedron_of(model)->triangles->group_names;
        return std::set<std::string>(names.begin(), names.end()).size() - 2;
    };
    CHECK(sides(polygon(comb(5))) == 20);
    CHECK(sides(polygon(comb(10))) == 1);  // 40 edges
    const std::string ell = "offset(r = 1) { polygon(points = [[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]]); }";
    CHECK(sides(ell) == 1);  // from the sharp corner inside round to it, in two parts
    CHECK(sides("difference() { " + ell + " square(); }") == 1);
}

TEST_CASE("prisms hold what the outline holds, at every height") {
    Random random(11);
    for (const double scale : {1.0, 0.5, 2.0, 0.0}) {
        for (const char* hole : {"", "square(center = true);", "circle(r = 1);"}) {
            const std::string text =
                "linear_extrude(height = 3, center = true, scale = " + std::to_string(scale) +
                ") { difference() { " + polygon(comb(4)) +
                "multmatrix([[1,0,0,1.7],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { " + hole +
                " square(size = 0.1); } } }";
            const Model model = read_csg(text);
            REQUIRE(polyhedron_of(model) != nullptr);
            CAPTURE(text);
            int wrong = 0;
            int inside = 0;
            for (int i = 0; i < 2000; ++i) {
                const Vec3 p = {14 * random.uniform() - 3, 5 * random.uniform() - 2.5,
                                3.4 * random.uniform() - 1.7};
                const double level = 1 + (scale - 1) * (p[2] + 1.5) / 3;
                const double x = p[0] / level;
                const double y = p[1] / level;
                bool expected = std::fabs(p[2]) <= 1.5 && y >= -1 && y <= 1 && x >= 0 && x <= 7;
                if (y > 0 && x > 0 && static_cast<int>(x) % 2 == 1) expected = false;
                if (x >= 1.7 && x <= 1.8 && y >= 0 && y <= 0.1) expected = false;
                if (*hole == 's' && std::fabs(x - 1.7) <= 0.5 && std::fabs(y) <= 0.5) expected = false;
                if (*hole == 'c' && std::hypot(x - 1.7, y) <= 1) expected = false;
                wrong += (region_at(model, p) == 1) != expected ? 1 : 0;
                inside += expected ? 1 : 0;
            }
            CHECK(wrong == 0);
            CHECK(inside > 50);
        }
    }
}
