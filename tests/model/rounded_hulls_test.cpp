// Hulls and sums that are one smooth surface: exact, in space and in the plane.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/rounded_facets.hpp"
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
using test::rod_at;
using test::rotated_x;
using test::sum_of;
using test::Support;

namespace {

/// The only rounded solid of a model.
const RoundedSolid& rounded_of(const Built& built) {
    const RoundedSolid* solid = nullptr;
    for (const CsgNode& node : built.model.nodes) {
        if (node.primitive.rounded) solid = node.primitive.rounded.get();
    }
    REQUIRE((solid != nullptr));
    return *solid;
}

}  // namespace

TEST_CASE("rounded solids as facets: volumes against closed forms, few triangles") {
    const double pi = std::acos(-1.0);
    const auto check = [](RoundedSolid solid, double volume, double most, std::size_t triangles) {
        const TriangleSurface facets = model_reader::facets_of(solid);
        CHECK(facets.triangles.size() < triangles);
        const auto hull = model_reader::convex_hull(facets.points);
        REQUIRE(hull);
        const double error = model_reader::volume_of(*hull) / volume - 1;
        CAPTURE(error);
        CHECK(error < 0);
        CHECK(error > -most);
    };
    // A box of 4 by 3 by 2 with a ball of 1/2: Steiner's formula.
    const double r = 0.5;
    const double box = 24 + 52 * r + pi * 9 * r * r + 4 * pi / 3 * r * r * r;
    check(rounded_of(build("cube([4, 3, 2], center = true);" + ball_at(0, 0, 0, r), true)), box, 1.2e-4,
          12000);
    const Built turned = build(
        "multmatrix([[0.866025,-0.5,0,1],[0.433013,0.75,-0.5,2],[0.25,0.433013,0.866025,3],[0,0,0,1]])"
        "{cube([4, 3, 2]);}" +
            ball_at(0, 0, 0, r),
        true);
    check(rounded_of(turned), box, 1.5e-4, 14000);
    // A slot, of height 1, and rounded by a ball; a rounded cylinder and cone.
    const double flat = pi * r * r + 2 * 2 * r;
    RoundedSolid slot = rounded_of(build(rod_at(-1, 0, 0, 1, r, r) + rod_at(1, 0, 0, 1, r, r)));
    CHECK(slot.shape == RoundedSolid::Shape::kColumn);
    slot.high = 1;
    check(slot, flat, 4e-4, 500);
    slot.shape = RoundedSolid::Shape::kPlate;
    slot.rounding = 0.25;
    const double rim = 2 * pi * r + 4;
    check(slot,
          flat + 2 * flat * 0.25 + rim * 0.25 + rim * pi / 2 * 0.0625 + pi * 0.0625 +
              4 * pi / 3 * 0.25 * 0.0625,
          1e-3, 14000);
    RoundedSolid pill;
    pill.shape = RoundedSolid::Shape::kRevolution;
    pill.balls = {{{0, 0, 0}, 0.5}, {{0, 2, 0}, 0.5}};
    check(pill, pi * 0.25 * 2 + pi / 6, 2e-3, 14000);
}

TEST_CASE("bounds of rounded solids keep their faces on the planes of the grid") {
    for (const Built& built : {build(rod_at(-1, 0, 0, 1, 0.5, 0.5) + rod_at(1, 0, 0, 1, 0.5, 0.5)),
                               build("cube([2, 1, 1]);" + ball_at(0, 0, 0, 0.5), true)}) {
        const auto& bounds = built.model.nodes[built.node].bounds;
        REQUIRE((bounds.has_value()));
        const bool prism = bounds->min[2] > -0.25;
        const Vec3 low = prism ? Vec3{-1.5, -0.5, 0} : Vec3{-0.5, -0.5, -0.5};
        const Vec3 high = prism ? Vec3{1.5, 0.5, 1} : Vec3{2.5, 1.5, 1.5};
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(bounds->min[k] <= low[k]);
            CHECK(bounds->max[k] >= high[k]);
            CHECK(std::fabs(bounds->min[k] - low[k]) < 1e-8);
            CHECK(std::fabs(bounds->max[k] - high[k]) < 1e-8);
        }
    }
}

TEST_CASE("hulls and sums that are one smooth surface") {
    // Spheres of any radii, nested, scaled alike, mirrored.
    const auto three = hull_of({ball({-1, 0, 0}, 0.5), ball({1, 0, 0}, 0.8), ball({0, 1, 0}, 0.3)});
    const std::string text = ball_at(-1, 0, 0, 0.5) + ball_at(1, 0, 0, 0.8) + ball_at(0, 1, 0, 0.3);
    const Built uneven = build(text);
    CHECK(exact(uneven));
    compare(uneven, three, 2);
    const Built nested = build("hull() {" + text + "}" + ball_at(0, 0, 1.5, 0.2));
    CHECK(exact(nested));
    CHECK(rounded_of(nested).balls.size() == 4);
    compare(nested, hull_of({three, ball({0, 0, 1.5}, 0.2)}), 2);
    const Built mirrored = build("multmatrix([[-0.5,0,0,0],[0,0.5,0,0],[0,0,0.5,0],[0,0,0,1]]) { hull() {" +
                                 text + "} }" + ball_at(0, 0, 1.5, 0.2));
    CHECK(exact(mirrored));
    compare(mirrored,
            hull_of({ball({0.5, 0, 0}, 0.25), ball({-0.5, 0, 0}, 0.4), ball({0, 0.5, 0}, 0.15),
                     ball({0, 0, 1.5}, 0.2)}),
            2);
    // A large ball between small ones hides their edge on one side only, or all around.
    for (const double y : {0.3, 0.0}) {
        const Built middle =
            build(ball_at(-1.5, 0, 0, 0.2) + ball_at(1.5, 0, 0, 0.2) + ball_at(0, y, 0, 0.9));
        CHECK(exact(middle));
        compare(middle, hull_of({ball({-1.5, 0, 0}, 0.2), ball({1.5, 0, 0}, 0.2), ball({0, y, 0}, 0.9)}), 2);
    }

    const Built pill = build(ball_at(0, 0, 0.5, 0.5) + rod_at(0, 0, 0, 1, 0.5, 0.5), true);
    CHECK(exact(pill));
    compare(pill, sum_of(ball({0, 0, 0.5}, 0.5), frustum(0, 0, 0, 1, 0.5, 0.5)), 2);
    const Built cone = build(rod_at(0, 0, 0, 1, 0.9, 0.2) + ball_at(0, 0, 0, 0.3), true);
    CHECK(exact(cone));
    compare(cone, sum_of(frustum(0, 0, 0, 1, 0.9, 0.2), ball({0, 0, 0}, 0.3)), 2);
    const Built tip = build(rod_at(0, 0, 0, 1, 0.9, 0) + ball_at(0, 0, 0, 0.3), true);
    CHECK(exact(tip));
    compare(tip, sum_of(frustum(0, 0, 0, 1, 0.9, 0), ball({0, 0, 0}, 0.3)), 2);

    // A prism over discs with a ball, a cylinder, a box; and all three, lying.
    const std::string prism =
        "hull() {" + rod_at(-1, 0, 0, 0.5, 0.5, 0.5) + rod_at(1, 0.5, 0, 0.5, 0.3, 0.3) + "}";
    const Support plate = hull_of({frustum(-1, 0, 0, 0.5, 0.5, 0.5), frustum(1, 0.5, 0, 0.5, 0.3, 0.3)});
    const Built round = build(prism + ball_at(0, 0, 0, 0.25), true);
    CHECK(exact(round));
    compare(round, sum_of(plate, ball({0, 0, 0}, 0.25)), 2);
    const Built wide = build(rod_at(0, 0, -1, 1, 0.25, 0.25) + prism, true);
    CHECK(exact(wide));
    compare(wide, sum_of(plate, frustum(0, 0, -1, 0, 0.25, 0.25)), 2);
    const Built boxed = build("cube([0.4, 0.3, 0.2]);" + prism, true);
    CHECK(exact(boxed));
    compare(boxed, sum_of(plate, box_of({0, 0, 0}, {0.4, 0.3, 0.2})), 2);
    const std::string lie = "multmatrix([[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]) {";
    const Built lying =
        build(lie + prism + "}" + ball_at(0, 0, 0, 0.25) + lie + rod_at(0, 0, 0, 0.5, 0.2, 0.2) + "}", true);
    CHECK_FALSE(exact(lying));  // after the ball it is no prism
    const Built lying_prism =
        build(lie + prism + "}" + lie + rod_at(0, 0, 0, 0.5, 0.2, 0.2) + "}" + ball_at(0, 0, 0, 0.25), true);
    CHECK(exact(lying_prism));
    compare(lying_prism,
            rotated_x(sum_of(sum_of(plate, frustum(0, 0, 0, 0.5, 0.2, 0.2)), ball({0, 0, 0}, 0.25))), 2.2);
    // Scaled unevenly it is facetted; the hull of rounded solids is, too.
    CHECK_FALSE(exact(build("multmatrix([[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { hull() {" + text +
                            "} }" + ball_at(0, 0, 1.5, 0.2))));
}

TEST_CASE("plane hulls, offsets and sums that are round all over are exact") {
    const auto compare_shape = [](const std::string& shape, RoundedSolid::Shape kind,
                                  const std::function<bool(double, double)>& holds) {
        const bool ring = kind == RoundedSolid::Shape::kRing;
        const Model model = parse_model(
            (ring ? "rotate_extrude() {" : "linear_extrude(height = 1) {") + shape + "}", "csg", "m.csg");
        CHECK(model.warnings.empty());
        const RoundedSolid* solid = nullptr;
        for (const CsgNode& node : model.nodes) {
            if (node.primitive.rounded) solid = node.primitive.rounded.get();
        }
        REQUIRE((solid != nullptr));
        CHECK(solid->shape == kind);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> coordinate(-4, 9);
        int wrong = 0;
        int inside = 0;
        for (int i = 0; i < 4000; ++i) {
            const double x = coordinate(random);
            const double y = coordinate(random);
            const bool expected = holds(ring ? std::fabs(x) : x, y);
            inside += expected;
            wrong +=
                test::holds(model, model.regions[0].root, ring ? Vec3{x, 0, y} : Vec3{x, y, 0.5}) != expected;
        }
        CHECK(wrong == 0);
        CHECK(inside > 100);
    };
    using Shape = RoundedSolid::Shape;
    const auto beside = [](double x, double y, double width, double height) {
        return std::hypot(std::max({0.0, -x, x - width}), std::max({0.0, -y, y - height}));
    };
    const auto square = [&](double r) { return [=](double x, double y) { return beside(x, y, 4, 3) <= r; }; };
    compare_shape("offset(r = 1) { square(size = [4, 3]); }", Shape::kColumn, square(1));
    compare_shape("offset(r = 1) { offset(r = 0.5) { square(size = [4, 3]); } }", Shape::kColumn,
                  square(1.5));
    compare_shape("minkowski() { square(size = [4, 3]); circle(r = 0.75); }", Shape::kColumn, square(0.75));
    const auto moved = [](double x, double y, const std::string& shape) { return at(x, y, 0, shape); };
    const std::string corners = "hull() {" + moved(2, 0, "circle(r = 1);") + moved(6, 0, "circle(r = 1);") +
                                moved(6, 3, "circle(r = 1);") + moved(2, 3, "circle(r = 1);") +
                                moved(4, 1, "square();") + "}";
    const auto moved_square = [&](double x, double y) { return beside(x - 2, y, 4, 3) <= 1; };
    compare_shape(corners, Shape::kColumn, moved_square);
    compare_shape(corners, Shape::kRing, moved_square);
    compare_shape("multmatrix([[0,-2,0,0],[2,0,0,0],[0,0,1,0],[0,0,0,1]]) { offset(r = 1) { square(); } }",
                  Shape::kColumn, [&](double x, double y) { return beside(x + 2, y, 2, 2) <= 2; });

    // Those with corners, deliberate polygons, ellipses and facets that are asked for stay polygons.
    for (const char* const shape :
         {"hull() { circle(r = 2); square(5); }", "offset(r = 1, $fn = 8) { square(4); }",
          "multmatrix([[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { offset(r = 1) { square(); } }",
          "offset(delta = 1) { square(4); }", "offset(r = -1) { square(4); }",
          "offset(r = 1) { difference() { square(4); circle(r = 1); } }"}) {
        CAPTURE(shape);
        for (const CsgNode& node :
             parse_model(std::string("linear_extrude(height = 1) {") + shape + "}", "csg", "m.csg").nodes)
            CHECK((node.primitive.rounded == nullptr));
    }
    ReadOptions exact_facets;
    exact_facets.facets = Facets::kExact;
    for (const CsgNode& node :
         parse_model("linear_extrude(height = 1) {" + corners + "}", "csg", "m.csg", exact_facets).nodes)
        CHECK((node.primitive.rounded == nullptr));
}
