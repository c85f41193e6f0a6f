// hull() and minkowski(): membership against support functions, volumes against closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "host/model/solids/tangent_hull.hpp"
#include "tests/model/built_hull.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/support_functions.hpp"

using namespace mortise;
using test::at;
using test::ball;
using test::ball_at;
using test::box_of;
using test::build;
using test::Built;
using test::compare;
using test::exact;
using test::frustum;
using test::hull_of;
using test::outside;
using test::rod_at;
using test::rotated_x;
using test::sum_of;
using test::Support;

namespace {

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

TEST_CASE("hull of polytopes is one polytope with merged faces") {
    const Built box = build("cube(1);" + at(1, 1, 1, "cube(1);"));
    REQUIRE(box.error.empty());
    const CsgNode& node = box.model.nodes[box.node];
    REQUIRE(node.op == CsgNode::Op::kPrimitive);
    CHECK(node.primitive.planes.size() == 12);
    CHECK(node.name == "hull1");
    CHECK(node.primitive.planes[0].name == "side1");
    compare(box, hull_of({box_of({0, 0, 0}, {1, 1, 1}), box_of({1, 1, 1}, {2, 2, 2})}), 3);

    const Built cube = build("cube(1);" + at(0.25, 0.25, 1, "cube(0.5);") + at(2, 0, 0, "cube(1);"));
    compare(cube, hull_of({box_of({0, 0, 0}, {3, 1, 1}), box_of({0.25, 0.25, 1}, {0.75, 0.75, 1.5})}), 3.5);
    // A hexagonal prism and a point above: a cylinder of six fragments and a tiny cube.
    const Built prism = build("cylinder($fn = 6, h = 1, r1 = 2, r2 = 2);");
    CHECK(prism.model.nodes[prism.node].primitive.planes.size() == 8);
}

TEST_CASE("hull of a rotated box has the faces of a box, in spite of six digits") {
    const Built box = build(
        "multmatrix([[0.866025,-0.5,0,1],[0.433013,0.75,-0.5,2],[0.25,0.433013,0.866025,3],[0,0,0,1]])"
        "{cube([3, 2, 1]);}");
    CHECK(box.model.nodes[box.node].primitive.planes.size() == 6);
}

TEST_CASE("hull of spheres of one radius") {
    const Support two = hull_of({ball({-1, 0, 0}, 0.5), ball({1, 1, 0.5}, 0.5)});
    const Built capsule = build(ball_at(-1, 0, 0, 0.5) + ball_at(1, 1, 0.5, 0.5));
    CHECK(exact(capsule));
    compare(capsule, two, 2);

    const Built triangle = build(ball_at(-1, 0, 0, 0.5) + ball_at(1, 0, 0, 0.5) + ball_at(0, 1.5, 1, 0.5));
    CHECK(exact(triangle));
    compare(triangle, hull_of({ball({-1, 0, 0}, 0.5), ball({1, 0, 0}, 0.5), ball({0, 1.5, 1}, 0.5)}), 2);

    std::string corners;
    for (int i = 0; i < 8; ++i) corners += ball_at((i & 1) * 2 - 1, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5, 0.4);
    const Built rounded = build(corners);
    CHECK(exact(rounded));
    compare(rounded, sum_of(box_of({-1, -0.5, -0.5}, {1, 0.5, 0.5}), ball({0, 0, 0}, 0.4)), 2);

    const Built tetrahedron =
        build(ball_at(0, 0, 0, 0.5) + ball_at(2, 0, 0, 0.5) + ball_at(0.5, 1.8, 0, 0.5) +
              ball_at(0.8, 0.5, 1.7, 0.5) + ball_at(0.8, 0.5, 0.2, 0.5));
    CHECK(exact(tetrahedron));
    compare(tetrahedron,
            hull_of({ball({0, 0, 0}, 0.5), ball({2, 0, 0}, 0.5), ball({0.5, 1.8, 0}, 0.5),
                     ball({0.8, 0.5, 1.7}, 0.5)}),
            3);
    // Inside another: does not count. All in a line: the ends count.
    const Built one = build(ball_at(0, 0, 0, 1) + ball_at(0.2, 0, 0, 0.5));
    CHECK(exact(one));
    compare(one, ball({0, 0, 0}, 1), 1.5);
    const Built line = build(ball_at(0, 0, -1, 0.7) + ball_at(0, 0, 0.3, 0.7) + ball_at(0, 0, 1, 0.7));
    CHECK(exact(line));
    compare(line, hull_of({ball({0, 0, -1}, 0.7), ball({0, 0, 1}, 0.7)}), 2);
    // A square of four spheres: its diagonals are no edges.
    const Built square = build(ball_at(-1, -1, 0, 0.5) + ball_at(1, -1, 0, 0.5) + ball_at(1, 1, 0, 0.5) +
                               ball_at(-1, 1, 0, 0.5) + ball_at(0, 0, 0, 0.5));
    CHECK(exact(square));
    compare(square, sum_of(box_of({-1, -1, 0}, {1, 1, 0}), ball({0, 0, 0}, 0.5)), 2);
}

TEST_CASE("hull of two spheres is a rounded cone") {
    const Built cone = build(ball_at(-0.5, 0, 0.3, 1) + ball_at(1.2, 0.4, 0, 0.4));
    CHECK(exact(cone));
    compare(cone, hull_of({ball({-0.5, 0, 0.3}, 1), ball({1.2, 0.4, 0}, 0.4)}), 2);
    const Built reversed = build(ball_at(1.2, 0.4, 0, 0.4) + ball_at(-0.5, 0, 0.3, 1));
    compare(reversed, hull_of({ball({-0.5, 0, 0.3}, 1), ball({1.2, 0.4, 0}, 0.4)}), 2);
}

TEST_CASE("hull of cylinders of one height") {
    const Built slot = build(rod_at(-1, 0, 0, 1, 0.5, 0.5) + rod_at(1, 0.5, 0, 1, 0.5, 0.5));
    CHECK(exact(slot));
    compare(slot, hull_of({frustum(-1, 0, 0, 1, 0.5, 0.5), frustum(1, 0.5, 0, 1, 0.5, 0.5)}), 2);
    const Built drop = build(rod_at(-1, 0, 0, 1, 1, 1) + rod_at(1, 0, 0, 1, 0.25, 0.25));
    CHECK(exact(drop));
    compare(drop, hull_of({frustum(-1, 0, 0, 1, 1, 1), frustum(1, 0, 0, 1, 0.25, 0.25)}), 2.1);
    const Built plate = build(rod_at(-1, -1, -0.5, 1, 0.5, 0.5) + rod_at(1, -1, -0.5, 1, 0.3, 0.3) +
                              rod_at(1, 1, -0.5, 1, 0.5, 0.5) + rod_at(-1, 1, -0.5, 1, 0.2, 0.2) +
                              rod_at(0, 0, -0.5, 1, 0.2, 0.2));
    CHECK(exact(plate));
    compare(plate,
            hull_of({frustum(-1, -1, -0.5, 0.5, 0.5, 0.5), frustum(1, -1, -0.5, 0.5, 0.3, 0.3),
                     frustum(1, 1, -0.5, 0.5, 0.5, 0.5), frustum(-1, 1, -0.5, 0.5, 0.2, 0.2)}),
            2);
    // Two small discs beside a large one: the large one's arc is in two parts.
    const Built flower =
        build(rod_at(0, 0, 0, 1, 1, 1) + rod_at(1.4, 0, 0, 1, 0.2, 0.2) + rod_at(-1.4, 0, 0, 1, 0.2, 0.2));
    CHECK(exact(flower));
    compare(flower,
            hull_of({frustum(0, 0, 0, 1, 1, 1), frustum(1.4, 0, 0, 1, 0.2, 0.2),
                     frustum(-1.4, 0, 0, 1, 0.2, 0.2)}),
            2);
    // With a box of the same height.
    const Built eye = build(at(-1, -0.5, 0, "cube([1, 1, 1]);") + rod_at(1, 0, 0, 1, 0.5, 0.5));
    CHECK(exact(eye));
    compare(eye, hull_of({box_of({-1, -0.5, 0}, {0, 0.5, 1}), frustum(1, 0, 0, 1, 0.5, 0.5)}), 2);
    // Lying along y, and scaled.
    const Built lying = build("multmatrix([[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]) {" +
                              rod_at(-1, 0, -1, 2, 0.5, 0.5) + rod_at(1, 0.5, -1, 2, 0.5, 0.5) + "}");
    CHECK(exact(lying));
    compare(lying, rotated_x(hull_of({frustum(-1, 0, -1, 1, 0.5, 0.5), frustum(1, 0.5, -1, 1, 0.5, 0.5)})),
            2);
    // A stack about one axis: the widest disc is not at both ends.
    const Built stack = build(rod_at(0, 0, 0, 1, 0.5, 0.5) + rod_at(0, 0, 0, 0.5, 1, 1));
    CHECK_FALSE(exact(stack));
    compare(stack, hull_of({frustum(0, 0, 0, 1, 0.5, 0.5), frustum(0, 0, 0, 0.5, 1, 1)}), 1.5, 0.02);
}

TEST_CASE("the hull of extruded outlines with curves is smooth where these are") {
    const auto outline = [](int r) {
        return "linear_extrude(height = 1) { offset(r = " + std::to_string(r) +
               ") { difference() { square(size = 9, center = true); square(5); } } }";
    };
    const std::string foot = outline(1);
    const std::string head = at(0, 0, 5, outline(2));
    // With the warnings of the reader, which knows the outlines.
    const auto angle_of = [](const std::string& text) {
        const Model model = parse_model("hull() {" + text + "}", "csg", "m.csg");
        CHECK(model.warnings.empty());
        double angle = -1;
        for (const CsgNode& node : model.nodes) {
            if (node.name == "hull1" && node.primitive.triangles) angle = node.primitive.sharp_angle;
        }
        return angle;
    };
    CHECK(angle_of(foot + head) == 25);
    CHECK(angle_of("linear_extrude(height = 1) { square(size = 9, center = true); }" +
                   at(0, 0, 5, "linear_extrude(height = 1) { square(size = 5, center = true); }")) < 5);
}

TEST_CASE("minkowski of an extruded rounded outline, which is a polyhedron between two planes") {
    const std::string plate =
        "linear_extrude(height = 1) { offset(r = 0.5) { square(size = 2, center = true); } }";
    const Built sum = build(plate + "cube(size = 0.5, center = true);", true);
    const Support rounded = hull_of({frustum(-1, -1, 0, 1, 0.5, 0.5), frustum(1, -1, 0, 1, 0.5, 0.5),
                                     frustum(1, 1, 0, 1, 0.5, 0.5), frustum(-1, 1, 0, 1, 0.5, 0.5)});
    compare(sum, sum_of(rounded, box_of({-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25})), 2.2);
    const Built refused = build(
        "linear_extrude(height = 1) { difference() { offset(r = 0.5) { square(); } square(); } } cube();",
        true);
    CHECK(refused.error.find("m.csg:3:4: 'minkowski': ") == 0);
}

TEST_CASE("hull of other curved solids is facetted, with a warning") {
    const Built mixed = build(ball_at(0, 0, 1, 0.5) + "cube([1, 1, 0.5], center = true);");
    REQUIRE(mixed.model.warnings.size() == 1);
    CHECK(mixed.model.warnings[0].find("m.csg:3:4: 'hull' of these curved solids is approximated") == 0);
    compare(mixed, hull_of({ball({0, 0, 1}, 0.5), box_of({-0.5, -0.5, -0.25}, {0.5, 0.5, 0.25})}), 1.6, 0.02);
    const std::string rounded_off = "hull() { sphere(r = 1); " + at(0, 0, 2, "cube(0.5);") + " }\n";
    const Model many = parse_model(rounded_off + rounded_off + rounded_off, "csg", "many.csg");
    REQUIRE(many.warnings.size() == 1);
    CHECK(many.warnings[0].find("many.csg:1:1: 'hull' of these") == 0);
    const Built cones = build(rod_at(0, 0, 0, 1, 1, 0) + rod_at(1, 0, 0, 1, 0.2, 0.6));
    compare(cones, hull_of({frustum(0, 0, 0, 1, 1, 0), frustum(1, 0, 0, 1, 0.2, 0.6)}), 2, 0.02);
    // Half a sphere: an intersection.
    const Built half = build("intersection() { sphere(r = 1); " + at(-2, -2, 0, "cube(4);") + "}");
    compare(
        half, [](const Vec3& u) { return u[2] > 0 ? std::sqrt(dot(u, u)) : std::hypot(u[0], u[1]); }, 1.3,
        0.02);
    // One cone alone is itself.
    const Built cone = build(rod_at(0, 0, 0, 1, 1, 0));
    CHECK(exact(cone));
    compare(cone, frustum(0, 0, 0, 1, 1, 0), 1.2);
}

TEST_CASE("planes that touch round parts of a hull in one point each are exact") {
    // Points of the planes, 1e-7 to either side of them.
    const auto is_plane = [](const Built& built, const Vec3& normal, double offset, const Vec3& near) {
        const double size = std::sqrt(dot(normal, normal));
        for (const double beside : {-1e-7, 1e-7}) {
            Vec3 p = near;
            const double by = (offset + beside * size - dot(normal, near)) / (size * size);
            for (std::size_t k = 0; k < 3; ++k) p[k] += by * normal[k];
            CAPTURE(beside);
            CHECK(test::holds(built.model, built.node, p) == (beside < 0));
        }
    };
    // A cylinder of radius 4 and a plate of another height: the sides touch its circles and the edges
    // x = 20, y = ±0.01.
    const Built plate =
        build(rod_at(0, 0, 0, 30, 4, 4) + at(10, 0, 1, "cube([20, 0.02, 32], center = true);"));
    // Normal (a, b): 20 a + 0.01 b = 4.
    const double t = 0.01 / 20;
    const double b = (0.2 * t + std::sqrt(1 + t * t - 0.04)) / (1 + t * t);
    const double a = 0.2 - t * b;
    REQUIRE(a * a + b * b == doctest::Approx(1).epsilon(1e-12));
    is_plane(plate, {a, b, 0}, 4, {10, 2, 10});
    is_plane(plate, {a, -b, 0}, 4, {10, -2, 3});
    // Three balls of different sizes and a point below: the plane on top of the balls, and one at their side.
    const Built balls =
        build(ball_at(0, 0, 0, 1) + ball_at(10, 0, 0, 2) + ball_at(0, 10, 0, 3) + at(3, 3, -4, "cube(0.1);"));
    // Normal (x, y, z): 1 = 10 x + 2 = 10 y + 3.
    is_plane(balls, {-0.1, -0.2, std::sqrt(0.95)}, 1, {3, 3, 1.5});
    // A slanted cone over a disc.
    model_reader::ConvexPiece disc;
    disc.kind = model_reader::ConvexPiece::Kind::kDisc;
    disc.b = {0, 0, 1};
    disc.ra = 3;
    model_reader::ConvexPiece tip;
    tip.points = {{5, 0, 6}};
    const auto cone = model_reader::tangent_hull({disc, tip});
    REQUIRE(cone);
    CHECK(model_reader::volume_of(*cone) == doctest::Approx(18 * 3.14159265358979).epsilon(3e-4));
    CHECK_FALSE(model_reader::tangent_hull({disc}));
}

TEST_CASE("minkowski sums") {
    const Built rounded = build("cube([2, 1, 1]);" + ball_at(0, 0, 0, 0.5), true);
    CHECK(exact(rounded));
    compare(rounded, sum_of(box_of({0, 0, 0}, {2, 1, 1}), ball({0, 0, 0}, 0.5)), 3);
    const Built plate = build("cube([2, 1, 1]);" + rod_at(0, 0, 0, 1, 0.5, 0.5), true);
    CHECK(exact(plate));
    compare(plate, sum_of(box_of({0, 0, 0}, {2, 1, 1}), frustum(0, 0, 0, 1, 0.5, 0.5)), 3);
    const Built reversed = build(rod_at(0, 0, 0, 1, 0.5, 0.5) + "cube([2, 1, 1]);", true);
    CHECK(exact(reversed));
    compare(reversed, sum_of(box_of({0, 0, 0}, {2, 1, 1}), frustum(0, 0, 0, 1, 0.5, 0.5)), 3);
    const Built boxes = build("cube([2, 1, 1]);" + at(0.5, 0, 0, "cube([1, 2, 0.5], center = true);"), true);
    CHECK(exact(boxes));
    CHECK(boxes.model.nodes[boxes.node].primitive.planes.size() == 6);
    compare(boxes, box_of({0, -1, -0.25}, {3, 2, 1.25}), 3.5);
    const Built balls = build(ball_at(1, 0, 0, 0.5) + ball_at(0, 1, 0, 0.25), true);
    CHECK(exact(balls));
    compare(balls, ball({1, 1, 0}, 0.75), 2);
    const Built rods = build(rod_at(1, 0, 0, 1, 0.5, 0.5) + rod_at(0, 0, -1, 1, 0.3, 0.3), true);
    CHECK(exact(rods));
    compare(rods, frustum(1, 0, -1, 1, 0.8, 0.8), 2);
    const Built three = build("cube([2, 1, 1]);" + ball_at(0, 0, 0, 0.25) + ball_at(0, 0, 0, 0.25), true);
    CHECK(exact(three));
    compare(three, sum_of(box_of({0, 0, 0}, {2, 1, 1}), ball({0, 0, 0}, 0.5)), 3);
    const Built mixed = build("multmatrix([[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]) {" +
                                  rod_at(0, 0, 0, 1, 0.5, 0.5) + "}" + rod_at(0, 0, 0, 1, 0.5, 0.5),
                              true);
    CHECK_FALSE(exact(mixed));
    compare(mixed, sum_of(rotated_x(frustum(0, 0, 0, 1, 0.5, 0.5)), frustum(0, 0, 0, 1, 0.5, 0.5)), 2, 0.02);

    // A union: an L of two boxes, rounded.
    const Built ell =
        build("union() { cube([2, 1, 1]); cube([1, 2, 1]); group(); }" + ball_at(0, 0, 0, 0.25), true);
    REQUIRE(ell.error.empty());
    CHECK(exact(ell));
    const Support one = sum_of(box_of({0, 0, 0}, {2, 1, 1}), ball({0, 0, 0}, 0.25));
    const Support two = sum_of(box_of({0, 0, 0}, {1, 2, 1}), ball({0, 0, 0}, 0.25));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> coordinate(-0.5, 2.5);
    int wrong = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3 p = {coordinate(random), coordinate(random), coordinate(random)};
        const double depth = std::min(outside(one, p, random), outside(two, p, random));
        if (std::fabs(depth) > 0.01) wrong += test::holds(ell.model, ell.node, p) != (depth < 0);
    }
    CHECK(wrong == 0);
    // One child alone is itself, none is empty.
    CHECK(test::holds(build("cube();", true).model, build("cube();", true).node, {0.5, 0.5, 0.5}));
    const Built nothing = build("group();", true);
    CHECK(nothing.error.empty());
    CHECK_FALSE(test::holds(nothing.model, nothing.node, {0, 0, 0}));
}

TEST_CASE("hull and minkowski: what is refused") {
    const auto hull = [](const std::string& text) { return build(text).error; };
    const auto minkowski = [](const std::string& text) { return build(text, true).error; };
    for (const char* const round :
         {"difference() { sphere(2); cube(1); } cube(1);", "difference() { cube(2); sphere(1); } cube(1);"}) {
        CHECK(hull(round).find("m.csg:3:4: 'hull': a difference of round solids among its children is not "
                               "supported") == 0);
        CHECK(minkowski(round).find("m.csg:3:4: 'minkowski': a difference of round solids") == 0);
    }
    CHECK(hull("difference() { cube(2); difference() { cube(1); cube(0.5); } } cube(1);")
              .find("a difference among its children") != std::string::npos);
    std::string scattered = "difference() { cube(99);";
    for (int i = 0; i < 60; ++i) scattered += at(i + 1, i * 7 % 61 + 1, i * 13 % 61 + 1, "cube(1);");
    CHECK(minkowski(scattered + " } cube(1);").find("more than 256 convex parts") != std::string::npos);
    CHECK(hull("intersection() { cube(2); union() { cube(1); sphere(1); } } cube(1);")
              .find("an intersection with a union") != std::string::npos);
    // Nothing in common: empty, neutral.
    const Built apart = build("intersection() { cube(1); " + at(5, 0, 0, "cube(1);") + "} cube(1);");
    compare(apart, box_of({0, 0, 0}, {1, 1, 1}), 2);

    Model model;
    model.source = "m.csg";
    const std::uint32_t side = model.add_primitive(half_space({0, 0, 0}, {0, 0, 1}));
    const std::uint32_t torus_node = model.add_primitive(torus(2, 0.5));
    const auto refusal = [&](std::uint32_t node, bool sum) -> std::string {
        try {
            sum ? model_reader::add_minkowski(model, {node, node}, "a", {1, 1})
                : model_reader::add_hull(model, {node}, "a", {1, 1});
        } catch (const Error& error) {
            return error.what();
        }
        return {};
    };
    CHECK(refusal(side, false).find("m.csg:1:1: 'hull': a child is not bounded") == 0);
    CHECK(refusal(torus_node, true).find("m.csg:1:1: 'minkowski': a torus is not supported") == 0);
    CHECK(refusal(torus_node, false).empty());

    // A polyhedron that is not convex: its hull is, its sum is refused.
    TriangleSurface dented;
    dented.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {0.3, 0.3, 0.3}};
    dented.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 4}, {2, 3, 4}, {3, 1, 4}};
    const std::uint32_t dent = model.add_primitive(polyhedron(dented));
    CHECK(refusal(dent, true).find("'minkowski': a polyhedron is not supported") != std::string::npos);
    CHECK(refusal(dent, false).empty());
}

TEST_CASE("hull: differences of solids with flat faces") {
    // Half of each edge at a corner is gone: a triangle instead of the corner.
    const Built cut =
        build("difference() { cube(4); " + at(2, 2, 2, "cube(9);") + " } " + at(1, 1, 1, "cube(1);"));
    CHECK(cut.error.empty());
    const auto holds = [&](const Vec3& p) { return test::holds(cut.model, cut.node, p); };
    CHECK(holds({3.3, 3.3, 3.3}));
    CHECK_FALSE(holds({3.4, 3.4, 3.4}));
    CHECK(holds({3.99, 3.99, 1.99}));
    CHECK_FALSE(holds({3.99, 3.99, 2.1}));
    // Nothing is left: neutral. A union, and a difference of a difference, below.
    compare(build("difference() { cube(1); " + at(-1, -1, -1, "cube(9);") + " } cube([1, 2, 3]);"),
            box_of({0, 0, 0}, {1, 2, 3}), 2);
    compare(
        build("difference() { union() { difference() { cube(4); " + at(2, -1, -1, "cube(9);") + " } " +
              at(0, 3, 0, "cube([8, 1, 1]);") + " } " + at(1, -1, -1, "cube([9, 9, 9]);") + " } cube(0.1);"),
        box_of({0, 0, 0}, {1, 4, 4}), 2);
    std::string deep = "cube(1);";
    for (int i = 0; i < 2000; ++i) deep = "difference() { " + deep + " cube(0.5); }";
    CHECK(build(deep + "cube(0.1);").error.empty());
}
