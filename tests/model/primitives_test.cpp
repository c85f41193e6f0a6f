// Ready-made primitives and the checks of the model arena.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "host/common/constants.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;

namespace {

bool inside(const Primitive& primitive, const Vec3& point) {
    Model model;
    return test::holds(model, model.add_primitive(primitive), point);
}

const double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("each primitive holds the points of its definition") {
    const Primitive half = half_space({1, 2, 3}, {0, 0, 2});
    CHECK(inside(half, {9, 9, 2.9}));
    CHECK_FALSE(inside(half, {9, 9, 3.1}));

    const Primitive brick = box({-1, 0, 2}, {1, 3, 4});
    CHECK(inside(brick, {0.9, 2.9, 2.1}));
    for (const Vec3& outside :
         {Vec3{-1.1, 1, 3}, {1.1, 1, 3}, {0, -0.1, 3}, {0, 3.1, 3}, {0, 1, 1.9}, {0, 1, 4.1}}) {
        CHECK_FALSE(inside(brick, outside));
    }
    const char* names[] = {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};
    REQUIRE(brick.planes.size() == 6);
    for (std::size_t k = 0; k < 6; ++k) CHECK(brick.planes[k].name == names[k]);

    const Primitive prism = wedge(4, 2, 1);
    CHECK(prism.planes.size() == 5);
    CHECK(inside(prism, {1.9, 0.95, 0.5}));
    CHECK_FALSE(inside(prism, {2.1, 1.05, 0.5}));
    CHECK_FALSE(inside(prism, {-0.1, 0.5, 0.5}));
    CHECK_FALSE(inside(prism, {1, 0.5, 1.1}));

    CHECK(inside(sphere(2), {1.1, 1.1, 1.1}));
    CHECK_FALSE(inside(sphere(2), {1.2, 1.2, 1.2}));
    CHECK(inside(infinite_cylinder(1), {0.7, 0.7, 1e6}));
    CHECK_FALSE(inside(infinite_cylinder(1), {0.8, 0.7, 0}));

    const Primitive single = cone(1, -0.5);  // apex at z = 2
    CHECK(inside(single, {0.45, 0, 1}));
    CHECK_FALSE(inside(single, {0.55, 0, 1}));
    CHECK(inside(single, {2.9, 0, -4}));
    CHECK_FALSE(inside(single, {0, 0, 2.1}));
    const Primitive twin = double_cone(1, -0.5);
    CHECK(inside(twin, {0.45, 0, 1}));
    CHECK(inside(twin, {0.45, 0, 3}));
    CHECK_FALSE(inside(twin, {0.55, 0, 3}));

    const Primitive ring = torus(3, 1);
    CHECK(inside(ring, {0, 3.9, 0}));
    CHECK(inside(ring, {3, 0, 0.9}));
    CHECK_FALSE(inside(ring, {0, 0, 0}));
    CHECK_FALSE(inside(ring, {3, 0, 1.1}));
}

TEST_CASE("sizes that are not positive and finite are refused") {
    for (const double bad : {0.0, -1.0, kInfinity, -kInfinity, kNan}) {
        CAPTURE(bad);
        CHECK_THROWS_AS(sphere(bad), Error);
        CHECK_THROWS_AS(infinite_cylinder(bad), Error);
        CHECK_THROWS_AS(cone(bad, 1), Error);
        CHECK_THROWS_AS(double_cone(bad, 1), Error);
        CHECK_THROWS_AS(torus(bad, 1), Error);
        CHECK_THROWS_AS(torus(1, bad), Error);
        CHECK_THROWS_AS(wedge(bad, 1, 1), Error);
        CHECK_THROWS_AS(wedge(1, bad, 1), Error);
        CHECK_THROWS_AS(wedge(1, 1, bad), Error);
        CHECK_THROWS_AS(box({0, 0, 0}, {1, bad, 1}), Error);
    }
    CHECK_THROWS_AS(half_space({0, 0, 0}, {0, 0, 0}), Error);
    CHECK_THROWS_AS(half_space({kNan, 0, 0}, {0, 0, 1}), Error);
    CHECK_THROWS_AS(cone(1, kNan), Error);
    CHECK_THROWS_AS(double_cone(1, kInfinity), Error);
    CHECK_THROWS_WITH(sphere(-1), "sphere: radius is -1; expected a positive, finite number");
}

TEST_CASE("the arena accepts only whole nodes with earlier children") {
    Model model;
    const std::uint32_t ball = model.add_primitive(sphere(1), "ball", {3, 4});
    CHECK(model.nodes[ball].name == "ball");
    CHECK(model.nodes[ball].where.column == 4);
    CHECK_THROWS_AS(model.add_operation(CsgNode::Op::kUnion, {1}), Error);
    CHECK_THROWS_AS(model.add_operation(CsgNode::Op::kComplement, {}), Error);
    CHECK_THROWS_AS(model.add_operation(CsgNode::Op::kComplement, {0, 0}), Error);
    CHECK_THROWS_AS(model.add_primitive(Primitive{}), Error);
    Primitive formula;
    formula.kind = Primitive::Kind::kExpression;
    CHECK_THROWS_AS(model.add_primitive(formula), Error);
    formula.expression = "x^2 + y^2 - 1";
    CHECK(model.add_primitive(formula) == 1);
    CsgNode with_child;
    with_child.primitive = sphere(1);
    with_child.children = {0};
    CHECK_THROWS_AS(model.add(with_child), Error);
    CHECK(model.nodes.size() == 2);
}

TEST_CASE("transforms map local to parent space and must be regular") {
    Model model;
    const std::uint32_t brick = model.add_primitive(box({0, 0, 0}, {1, 2, 3}));
    // A mirror in x with a shear and a shift: (x, y, z) -> (-x + 5, y + x, z).
    const std::uint32_t moved = model.add_transform({-1, 0, 0, 5, 1, 1, 0, 0, 0, 0, 1, 0}, brick);
    CHECK(test::holds(model, moved, {4.1, 0.95, 1}));
    CHECK_FALSE(test::holds(model, moved, {4.1, 0.85, 1}));
    CHECK_FALSE(test::holds(model, moved, {0.5, 1, 1}));
    // Small and unequal scales are regular, flattening ones are not.
    CHECK_NOTHROW(model.add_transform({1e-9, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e9, 0}, brick));
    CHECK_THROWS_AS(model.add_transform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}, brick), Error);
    CHECK_THROWS_AS(model.add_transform({1, 2, 0, 0, 2, 4, 0, 0, 0, 0, 1, 0}, brick), Error);
    CHECK_THROWS_AS(model.add_transform({1, 0, 0, kNan, 0, 1, 0, 0, 0, 0, 1, 0}, brick), Error);
}
