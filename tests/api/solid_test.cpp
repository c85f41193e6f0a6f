// Solids built in code: closed forms, names, sizes, sharing, trees of any depth, errors.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "mortise/solid.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Meshed meshed(const Solid& solid, int level = 5) { return mesh_and_check(make_model(solid), level); }

double volume(const Solid& solid, int level = 5) {
    const Meshed m = meshed(solid, level);
    CHECK(m.defects == "");
    return m.check.volume;
}

/// Bounds of a mesh's nodes.
Box3 extent(const Mesh& mesh) {
    Box3 box{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        box.min[i % 3] = std::min(box.min[i % 3], mesh.points[i]);
        box.max[i % 3] = std::max(box.max[i % 3], mesh.points[i]);
    }
    return box;
}

std::string message_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kInput);
        return error.what();
    }
    FAIL("no error");
    return {};
}

}  // namespace

TEST_CASE("volumes of what operations make") {
    const Solid cube = box({0, 0, 0}, {2, 2, 2});
    const Solid slab = box({1, -1, -1}, {3, 3, 3});
    CHECK(volume(cube | slab) == doctest::Approx(8 + 32 - 4));
    CHECK(volume(cube & slab) == doctest::Approx(4));
    CHECK(volume(cube - slab) == doctest::Approx(4));
    CHECK(volume(cube & ~slab) == doctest::Approx(4));
    CHECK(volume(mortise::unite({cube, slab, cube})) == doctest::Approx(36));
    CHECK(volume(mortise::intersect({cube, slab, box({0, 0, 0}, {9, 1, 9})})) == doctest::Approx(2));
    CHECK(volume(cube & mortise::intersect({})) == doctest::Approx(8));
    CHECK(volume(cube | Solid()) == doctest::Approx(8));
    // a - b - c and a | b | c, whichever way they are put together.
    const Solid hole = cylinder(0.3, 2);
    const double ring = kPi * 0.09 * 2;
    CHECK(volume(cube - hole.translated({0.5, 0.5, 0}) - hole.translated({1.5, 1.5, 0})) ==
          doctest::Approx(8 - 2 * ring).epsilon(0.01));
    CHECK(volume(cube - (hole.translated({0.5, 0.5, 0}) | hole.translated({1.5, 1.5, 0}))) ==
          doctest::Approx(8 - 2 * ring).epsilon(0.01));
}

TEST_CASE("ready-made solids") {
    CHECK(volume(cylinder(1, 3)) == doctest::Approx(3 * kPi).epsilon(0.02));
    CHECK(volume(frustum(1, 0.5, 3)) == doctest::Approx(kPi * (1 + 0.5 + 0.25)).epsilon(0.02));
    CHECK(volume(frustum(0.5, 1, 3)) == doctest::Approx(kPi * (1 + 0.5 + 0.25)).epsilon(0.02));
    for (const Solid& cone : {frustum(1, 0, 3), frustum(0, 1, 3)}) {
        const Meshed m = meshed(cone, 6);
        CHECK(m.check.volume == doctest::Approx(kPi).epsilon(0.02));
        CHECK(extent(m.mesh).min[2] == doctest::Approx(0));
        CHECK(extent(m.mesh).max[2] == doctest::Approx(3).epsilon(1e-6));
    }
    CHECK(volume(implicit("x^2 + y^2 + z^2 - 1")) == doctest::Approx(4 * kPi / 3).epsilon(0.02));
    const Meshed half = meshed(implicit("x^2 + y^2 + z^2 - 1", Box3{{0, -2, -2}, {2, 2, 2}}));
    CHECK(half.check.volume == doctest::Approx(2 * kPi / 3).epsilon(0.02));
}

TEST_CASE("rods and lattices") {
    // A cylinder and two half balls; tapered: between balls that touch the cone along circles.
    CHECK(volume(rod({0, 0, 0}, {0, 3, 4}, 1)) == doctest::Approx(kPi * (5 + 4.0 / 3)).epsilon(0.02));
    const double sine = 0.5 / 4, cosine = std::sqrt(1 - sine * sine);
    const auto cap = [](double r, double h) { return kPi * h * h * (r - h / 3); };
    const double between = kPi * 4 * cosine * cosine / 3 * cosine * cosine * (1 + 0.5 + 0.25);
    const double expected = cap(1, 1 + sine) + between + cap(0.5, 0.5 * (1 - sine));
    CHECK(volume(rod({0, 0, 0}, {4, 0, 0}, 1, 0.5), 6) == doctest::Approx(expected).epsilon(0.01));
    CHECK(volume(rod({0, 0, 0}, {4, 0, 0}, 0.5, 1), 6) == doctest::Approx(expected).epsilon(0.01));
    CHECK(volume(rod({0, 0, 0}, {0.2, 0, 0}, 1, 0.5)) == doctest::Approx(4 * kPi / 3).epsilon(0.02));
    CHECK(volume(rod({0, 0, 0}, {0, 0, 0}, 1)) == doctest::Approx(4 * kPi / 3).epsilon(0.02));

    const std::vector<Vec3> corners = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
    const Meshed frame = meshed(lattice(corners, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {2, 3}, {3, 1}}, 0.5), 6);
    CHECK(frame.defects == "");
    CHECK(frame.check.components == 1);
    CHECK(frame.check.euler_characteristic == 2 - 2 * 3);  // a graph of 6 edges on 4 nodes has 3 loops
    CHECK(message_of([] { rod({0, 0, 0}, {1, 0, 0}, 0); }).find("rod: the radius is 0") != std::string::npos);
    CHECK(message_of([] { rod({0, 0, 0}, {1, 0, HUGE_VAL}, 1); }).find("not finite") != std::string::npos);
    CHECK(message_of([&] {
              lattice(corners, {{0, 1}, {1, 4}}, 1);
          }) == "lattice: edge 1 ends at point 4; there are 4 points");
    CHECK(message_of([&] {
              lattice(corners, {{0, 1}, {1, 1}}, 1);
          }) == "lattice: edge 1 begins and ends at point 1");
    CHECK(message_of([&] {
              lattice(corners, {{0, 1}, {1, 2}}, {1, 0});
          }).find("edge 1: the radius is 0") != std::string::npos);
    CHECK(message_of([&] {
              lattice(corners, {{0, 1}, {1, 2}}, std::vector<double>{1});
          }) == "lattice: 1 radii of 2 edges; expected one for each");
    CHECK(message_of([] {
              lattice({{0, 0, 0}, {NAN, 0, 0}}, {{0, 1}}, 1);
          }).find("point 1, which is not") != std::string::npos);
}

TEST_CASE("transforms: where they put things") {
    const Solid bar = box({1, 0, 0}, {3, 1, 0.5});
    const auto is_at = [](const Solid& solid, const Box3& expected) {
        const Box3 found = extent(meshed(solid, 4).mesh);
        for (std::size_t j = 0; j < 3; ++j) {
            CHECK(found.min[j] == doctest::Approx(expected.min[j]).epsilon(1e-9));
            CHECK(found.max[j] == doctest::Approx(expected.max[j]).epsilon(1e-9));
        }
    };
    is_at(bar.translated({1, 2, 3}), {{2, 2, 3}, {4, 3, 3.5}});
    is_at(bar.rotated(90), {{-1, 1, 0}, {0, 3, 0.5}});
    is_at(bar.rotated(-270), {{-1, 1, 0}, {0, 3, 0.5}});
    is_at(bar.rotated(180), {{-3, -1, 0}, {-1, 0, 0.5}});
    is_at(bar.rotated(90, {0, 2, 0}), {{0, 0, -3}, {0.5, 1, -1}});
    is_at(bar.rotated(120, {1, 1, 1}), {{0, 1, 0}, {0.5, 3, 1}});
    is_at(bar.scaled({2, 1, -1}), {{2, 0, -0.5}, {6, 1, 0}});
    is_at(bar.mirrored({3, 0, 0}), {{-3, 0, 0}, {-1, 1, 0.5}});
    is_at(bar.mirrored({1, -1, 0}), {{0, 1, 0}, {1, 3, 0.5}});
    is_at(bar.transformed({0, 1, 0, 5, 1, 0, 0, 0, 0, 0, 1, 0}), {{5, 1, 0}, {6, 3, 0.5}});
}

TEST_CASE("the innermost name is a surface's") {
    const Solid plate = Solid(box({0, 0, 0}, {4, 4, 1})).named("plate");
    const Solid pin = cylinder(1, 1).translated({2, 2, 0});
    const Meshed m = meshed((plate - pin.named("bore")).named("part"));
    std::vector<std::string> names = m.mesh.surface_names;
    std::sort(names.begin(), names.end());
    CHECK(names == std::vector<std::string>{"bore", "plate_xmax", "plate_xmin", "plate_ymax", "plate_ymin",
                                            "plate_zmax", "plate_zmin"});
    const Meshed outer = meshed((plate - pin).named("part"));
    CHECK(std::count(outer.mesh.surface_names.begin(), outer.mesh.surface_names.end(), "part") == 1);
}

TEST_CASE("sizes ask for small cells") {
    const Solid ball = Solid(sphere(0.2)).translated({1, 1, 1});
    const Solid block = box({0, 0, 0}, {4, 4, 4});
    const auto finest = [](const Solid& solid) {
        MeshOptions options;
        options.level = 4;
        return mesh_and_check(make_model(solid), options).report.finest_level;
    };
    CHECK(finest(block - ball) == 4);
    CHECK(finest(block - ball.sized(0.1)) == 6);
    CHECK(finest(block - ball.surface_sized(0.05)) == 7);
}

TEST_CASE("regions: the first has what overlaps") {
    const Solid steel = box({0, 0, 0}, {2, 2, 2}), resin = box({1, 0, 0}, {4, 2, 2});
    MeshOptions options;
    options.level = 4;
    const Meshed m = mesh_and_check(make_model({{"steel", steel}, {"resin", resin}}), options);
    CHECK(m.mesh.region_names == std::vector<std::string>{"steel", "resin"});
    REQUIRE(m.check.region_volume.size() == 2);
    CHECK(m.check.region_volume[0] == doctest::Approx(8));
    CHECK(m.check.region_volume[1] == doctest::Approx(8));
    CHECK(make_model(steel, "body").regions[0].name == "body");
}

TEST_CASE("what is used several times is stored once") {
    Solid part = sphere(1);
    for (int i = 0; i < 12; ++i) part = part | part.translated({3, 0, 0});
    CHECK(make_model(part).nodes.size() < 40);
}

TEST_CASE("trees of any depth, and long chains") {
    Solid deep = box({0, 0, 0}, {1, 1, 1});
    for (int i = 0; i < 200000; ++i) deep = (deep & Solid(box({0, 0, 0}, {1, 1, 1}))).named("block");
    CHECK(make_model(deep).nodes.size() > 200000);
    deep = Solid();
    Solid chain;
    for (int i = 0; i < 10000; ++i) chain = chain | Solid(sphere(0.1)).translated({1.0 * i, 0, 0});
    CHECK(make_model(chain).nodes.size() < 20010);
}

TEST_CASE("a file's solids can be built on") {
    const std::string text =
        "difference() { cube([4, 2, 1]); translate([2, 1, 0]) cylinder(h = 1, r = 0.5, $fn = 90); }";
    const Model read = parse_model(text, "csg", "plate.csg");
    const auto solids = solids_of(read);
    REQUIRE(solids.size() == 1);
    Model again = make_model(solids);
    again.source = read.source;
    const Mesh a = generate(read), b = generate(again);
    CHECK(is_same_mesh(a, b));
    const Solid both = solids[0].second | solids[0].second.translated({0, 0, 1});
    CHECK(volume(both) == doctest::Approx(2 * (8 - kPi / 4)).epsilon(0.01));
    // The box of a .geo file is part of its solids.
    const Model cut = parse_model(
        "algebraic3d boundingbox(0,0,0;1,1,1); solid a = plane(0,0,0.5;0,0,1); tlo a;", "geo", "a.geo");
    CHECK(volume(solids_of(cut)[0].second, 4) == doctest::Approx(0.5));
}

TEST_CASE("numbers that make no solid are told") {
    CHECK(message_of([] { cylinder(-1, 1); }) ==
          "cylinder: the radius is -1; expected a positive, finite number");
    CHECK(message_of([] { cylinder(1, 0); }).find("the height is 0") != std::string::npos);
    CHECK(message_of([] { frustum(1, -2, 1); }).find("the radius at the top is -2") != std::string::npos);
    CHECK(message_of([] { frustum(0, 0, 1); }).find("frustum: the radius at the bottom is 0") !=
          std::string::npos);
    const Solid ball = sphere(1);
    CHECK(message_of([&] { ball.sized(0); }).find("the size is 0") != std::string::npos);
    CHECK(message_of([&] { ball.scaled({1, 0, 1}); }).find("singular") != std::string::npos);
    CHECK(message_of([&] {
              ball.rotated(10, {0, 0, 0});
          }).find("the axis is no direction") != std::string::npos);
    CHECK(message_of([&] { ball.rotated(HUGE_VAL); }).find("the angle is not finite") != std::string::npos);
    CHECK(message_of([&] { ball.translated({NAN, 0, 0}); }).find("finite") != std::string::npos);
    CHECK(message_of([] { implicit("x^2 + "); }).find("implicit") == 0);
    CHECK(message_of([] { implicit("x^2 + q"); }).find("'q'") != std::string::npos);
    CHECK(message_of([] { implicit(""); }).find("the formula is empty") != std::string::npos);
    CHECK(message_of([] { generate(make_model(Solid())); }).find("empty") != std::string::npos);
}

}  // namespace mortise::test
