// Formulas of single leaves in which surfaces touch each other.
#include <doctest/doctest.h>

#include "host/octree/tangent.hpp"
#include "host/tape/compile.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/rounded_solids.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

using octree::LeafBox;
using octree::LeafFormula;
using octree::LeafJoint;

// Two inner walls of a slot: y < 1 where x < 0, and the cylinder of radius 3 that touches it at x = 0.
constexpr std::uint32_t kChooser = 0;
constexpr std::uint32_t kPlane = 1;
constexpr std::uint32_t kCylinder = 2;

std::uint32_t literal(std::uint32_t surface, bool negated = false) {
    return make_literal(surface, negated ? 1 : 0);
}
std::uint32_t both() { return make_operation(kTapeAnd, 0, 0); }
std::uint32_t either() { return make_operation(kTapeOr, 0, 0); }
std::uint32_t region() { return make_operation(kTapeSelectConst, 1, 0); }

Surface plane(double x, double y, double offset) {
    Surface s{};
    s.kind = kSurfacePlane;
    s.map[0] = x;
    s.map[1] = y;
    s.map[3] = -offset;
    return s;
}

/// Axis along z through (0, y).
Surface cylinder(double y, double radius) {
    Surface s{};
    s.kind = kSurfaceQuadric;
    s.map[0] = 1;
    s.map[5] = 1;
    s.map[7] = -y;
    s.form[0] = s.form[1] = 1;
    s.form[3] = -radius * radius;
    return s;
}

tape::BoundModel walls(double lift = 0) {
    tape::BoundModel model;
    model.surfaces = {plane(1, 0, 0), plane(0, 1, 1), cylinder(-2 + lift, 3)};
    return model;
}

struct Joined {
    bool changed;
    std::vector<std::uint32_t> tape;
    LeafJoint joint;
};

Joined join(const tape::BoundModel& model, const LeafBox& leaf, std::vector<std::uint32_t> tape) {
    LeafFormula formula;
    REQUIRE(formula.load(std::move(tape)));
    Joined result;
    result.changed = join_tangent(model, leaf, formula, result.joint);
    result.tape = formula.tape();
    return result;
}

/// (x < 0 and y < 1) or the cylinder.
std::vector<std::uint32_t> slot() {
    return {literal(kChooser), literal(kPlane), both(), literal(kCylinder), either(), region()};
}

}  // namespace

TEST_CASE("where a plane ends inside a cylinder that it touches, both are one surface") {
    const LeafBox leaf = {{0.1, 1.05, 0}, 0.5};
    const Joined result = join(walls(), leaf, slot());
    REQUIRE(result.changed);
    // Either side of the chooser is cut by its own surface alone.
    CHECK(result.tape == std::vector<std::uint32_t>{literal(kChooser), literal(kPlane), both(),
                                                    literal(kChooser, true), literal(kCylinder), both(),
                                                    either(), region()});
    CHECK(result.joint.tape == std::vector<std::uint32_t>{literal(octree::kJointSurface), region()});
    CHECK(result.joint.joint == octree::Joint{kChooser, kPlane, kCylinder, false});
}

TEST_CASE("a surface that lies inside another changes nothing in their union") {
    const LeafBox leaf = {{-1, 1.05, 0}, 0.5};
    const Joined result = join(walls(), leaf, {literal(kPlane), literal(kCylinder), either(), region()});
    REQUIRE(result.changed);
    CHECK(result.joint.tape.empty());
    for (const std::uint32_t word : result.tape) {
        if (tape_operation(word) == kTapeLiteral) CHECK(word == literal(kPlane));
    }
    // In their intersection it is the other one, and what is left is a void in a difference.
    const Joined common = join(walls(), leaf, {literal(kPlane), literal(kCylinder), both(), region()});
    for (const std::uint32_t word : common.tape) {
        if (tape_operation(word) == kTapeLiteral) CHECK(word == literal(kCylinder));
    }
}

TEST_CASE("surfaces that do not touch, or cross, stay as they are") {
    const LeafBox leaf = {{0.1, 1.05, 0}, 0.5};
    CHECK_FALSE(join(walls(-1e-3), leaf, slot()).changed);  // a step
    CHECK_FALSE(join(walls(1e-3), leaf, slot()).changed);   // they cross
    // Both sides of the plane are kept: the film between is part of neither.
    CHECK_FALSE(join(walls(), leaf, {literal(kPlane), literal(kCylinder, true), both(), region()}).changed);
}

TEST_CASE("where the chooser shows, there is no joint") {
    // The plane ends at x = 0.1, where the cylinder has left it already: a step.
    tape::BoundModel model = walls();
    model.surfaces[kChooser] = plane(1, 0, 0.4);
    const LeafBox leaf = {{0.4, 1.0, 0}, 0.5};
    CHECK(join(model, leaf, slot()).joint.tape.empty());
}

namespace {

/// Pipes of radius 1: straight, along y at x = 3, where y < overlap; bent, around the z axis, where y > 0.
/// The bent one's surface crosses the straight one's on its top and bottom.
tape::BoundModel bend(double overlap) {
    tape::BoundModel model;
    Surface straight{};
    straight.kind = kSurfaceQuadric;
    straight.map[0] = 1;
    straight.map[3] = -3;
    straight.map[6] = 1;
    straight.form[0] = straight.form[1] = 1;
    straight.form[3] = -1;
    Surface bent{};
    bent.kind = kSurfaceTorus;
    bent.map[0] = bent.map[5] = bent.map[10] = 1;
    bent.form[0] = 3;
    bent.form[3] = -1;
    model.surfaces = {plane(0, 1, 0), plane(0, 1, overlap), straight, bent};
    return model;
}

}  // namespace

TEST_CASE("a bent pipe goes on from a straight one, also where neither is inside the other") {
    const std::vector<std::uint32_t> tape = {literal(0, true), literal(3), both(),   literal(0),
                                             literal(2),       both(),     either(), region()};
    const std::vector<std::uint32_t> joined = {literal(octree::kJointSurface), region()};
    for (const Vec3& centre : {Vec3{3.02, 0.03, 1.01}, Vec3{2.97, -0.04, -0.98}, Vec3{3.7, 0.02, 0.7}}) {
        const Joined result = join(bend(0), {centre, 0.1}, tape);
        CHECK(result.changed);
        CHECK(result.joint.tape == joined);
        CHECK(result.joint.joint == octree::Joint{0, 2, 3, false});
    }
}

TEST_CASE("parts that overlap by a little are one surface, but for steps") {
    const std::vector<std::uint32_t> tape = {literal(0, true), literal(3), both(),   literal(1),
                                             literal(2),       both(),     either(), region()};
    const std::vector<std::uint32_t> joined = {literal(octree::kJointSurface), region()};
    // On the top, outside, where the straight pipe sticks out, and inside: leaves drop the same plane.
    std::vector<octree::Joint> joints;
    for (const Vec3& centre : {Vec3{3.02, 0.03, 1.01}, Vec3{3.7, 0.02, 0.7}, Vec3{2.3, 0.03, 0.7}}) {
        const Joined result = join(bend(0.01), {centre, 0.1}, tape);
        CHECK(result.joint.tape == joined);
        joints.push_back(result.joint.joint);
    }
    CHECK(joints[0] == joints[1]);
    CHECK(joints[0] == joints[2]);
    // By half a leaf and more the step at the end counts.
    CHECK(join(bend(0.06), {{3.7, 0.06, 0.7}, 0.1}, tape).joint.tape.empty());
}

TEST_CASE("two cylinders of one radius: neither is inside the other around their poles") {
    tape::BoundModel model;
    model.surfaces = {cylinder(0, 2), cylinder(0, 2)};
    // The second along x.
    model.surfaces[1].map[0] = 0;
    model.surfaces[1].map[2] = 1;
    const std::vector<std::uint32_t> tape = {literal(0), literal(1), either(), region()};
    CHECK_FALSE(join(model, {{0.1, 2, 0.2}, 0.5}, tape).changed);
    // Far from the planes that part them one is, but not where a leaf beside still sees the other.
    CHECK(join(model, {{0.1, 1.8, 1.2}, 0.25}, tape).changed);
    CHECK_FALSE(join(model, {{0.5, 1.9, 0.8}, 0.25}, tape).changed);
}

}  // namespace mortise::test
