// Rods that end in balls of their radius become hulls of two balls: the same solid.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/common/random.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;

namespace {

/// A node moved by a matrix of six figures, as OpenSCAD writes it.
std::string moved(const Affine& map, const std::string& child) {
    std::ostringstream text;  // six figures
    text << "multmatrix([";
    for (std::size_t row = 0; row < 3; ++row) {
        text << "[" << map[4 * row] << ", " << map[4 * row + 1] << ", " << map[4 * row + 2] << ", "
             << map[4 * row + 3] << "], ";
    }
    text << "[0, 0, 0, 1]]) { " << child << " }";
    return text.str();
}

std::string ball_text(const Vec3& at, double radius) {
    return moved({1, 0, 0, at[0], 0, 1, 0, at[1], 0, 0, 1, at[2]},
                 "sphere(r = " + std::to_string(radius) + ");");
}

/// From a to b, in a frame whose z axis points there.
std::string rod(const Vec3& a, const Vec3& b, double radius) {
    Vec3 z = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const double length = std::hypot(z[0], z[1], z[2]);
    for (double& x : z) x /= length;
    const double flat = std::hypot(z[0], z[1]);
    const Vec3 x = flat > 0 ? Vec3{-z[1] / flat, z[0] / flat, 0} : Vec3{1, 0, 0};
    const Vec3 y = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    return moved({x[0], y[0], z[0], a[0], x[1], y[1], z[1], a[1], x[2], y[2], z[2], a[2]},
                 "group() { cylinder(h = " + std::to_string(length) + ", r1 = " + std::to_string(radius) +
                     ", r2 = " + std::to_string(radius) + "); }");
}

std::size_t count(const Model& model, Primitive::Kind kind) {
    return static_cast<std::size_t>(
        std::count_if(model.nodes.begin(), model.nodes.end(), [kind](const CsgNode& node) {
            return node.op == CsgNode::Op::kPrimitive && node.primitive.kind == kind;
        }));
}

double distance(const Vec3& p, const Vec3& a, const Vec3& b) {
    double along = 0, length = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        along += (p[j] - a[j]) * (b[j] - a[j]);
        length += (b[j] - a[j]) * (b[j] - a[j]);
    }
    const double t = std::clamp(along / length, 0.0, 1.0);
    double squared = 0;
    for (std::size_t j = 0; j < 3; ++j) squared += std::pow(p[j] - a[j] - t * (b[j] - a[j]), 2);
    return std::sqrt(squared);
}

}  // namespace

TEST_CASE("rods with balls of their radius at both ends are hulls of two balls") {
    Random random(11);
    const double radius = 0.35;
    std::vector<Vec3> at;
    for (int i = 0; i < 12; ++i) at.push_back({2.2 * std::cos(0.5 * i), 2.2 * std::sin(0.5 * i), 0.31 * i});
    for (const bool are_balls_shared : {true, false}) {
        std::string text;
        for (std::size_t i = 0; i + 1 < at.size(); ++i) {
            text += "group() { " + rod(at[i], at[i + 1], radius) +
                    (are_balls_shared ? "" : ball_text(at[i], radius)) + " union() { " +
                    ball_text(at[i + 1], radius) + " } }\n";
        }
        if (are_balls_shared) text += ball_text(at[0], radius);
        const Model model = read_csg(text);
        CHECK(count(model, Primitive::Kind::kRounded) == at.size() - 1);
        CHECK(count(model, Primitive::Kind::kSphere) == 0);
        CHECK(count(model, Primitive::Kind::kCylinder) == 0);
        CHECK(count(model, Primitive::Kind::kConvex) == 0);
        CHECK(model.nodes[0].name == "cylinder1");
        for (int k = 0; k < 2000; ++k) {
            const Vec3 p = {5.4 * random.uniform() - 2.7, 5.4 * random.uniform() - 2.7,
                            4.4 * random.uniform() - 0.5};
            double nearest = HUGE_VAL;
            for (std::size_t i = 0; i + 1 < at.size(); ++i)
                nearest = std::min(nearest, distance(p, at[i], at[i + 1]));
            if (std::fabs(nearest - radius) < 1e-4) continue;
            REQUIRE(test::region_at(model, p) == (nearest < radius ? 1 : 0));
        }
    }
}

TEST_CASE("other rods and balls stay as they are") {
    const Vec3 a = {1, 2, 3};
    const Vec3 b = {4, 3, 1};
    const auto is_left_alone = [](const std::string& text) {
        const Model model = read_csg(text);
        return count(model, Primitive::Kind::kRounded) == 0 && count(model, Primitive::Kind::kCylinder) == 1;
    };
    CHECK_FALSE(is_left_alone(rod(a, b, 0.5) + ball_text(a, 0.5) + ball_text(b, 0.5)));
    CHECK(is_left_alone(rod(a, b, 0.5) + ball_text(a, 0.5)));
    CHECK(is_left_alone(rod(a, b, 0.5) + ball_text(a, 0.5) + ball_text(b, 0.501)));
    CHECK(is_left_alone(rod(a, b, 0.5) + ball_text(a, 0.5) + ball_text({4, 3, 1.01}, 0.5)));
    CHECK(is_left_alone("difference() { " + rod(a, b, 0.5) + " group() { " + ball_text(a, 0.5) +
                        ball_text(b, 0.5) + "} }"));
    // The rounded edge of a box; not one that a rod ends in.
    const Vec3 o = {0, 0, 0};
    const Vec3 x = {3, 0, 0};
    const std::string capped = rod(o, x, 0.5) + ball_text(o, 0.5) + ball_text(x, 0.5);
    CHECK(is_left_alone(capped + moved({1, 0, 0, 0, 0, 1, 0, -4, 0, 0, 1, -0.5}, "cube(size = [3, 4, 1]);")));
    CHECK(is_left_alone(capped + moved({3, 0, 0, 0, 0, 0, 4, -4, 0, 1, 0, -0.5}, "cube(size = [1, 1, 1]);")));
    CHECK_FALSE(
        is_left_alone(capped + moved({1, 0, 0, 3, 0, 1, 0, -4, 0, 0, 1, -4}, "cube(size = [3, 8, 8]);")));
    // A ball that two rods have, one of which ends flat, is part of the other.
    const Model mixed =
        read_csg(rod(a, b, 0.5) + rod(b, {7, 7, 7}, 0.5) + ball_text(a, 0.5) + ball_text(b, 0.5));
    CHECK(count(mixed, Primitive::Kind::kRounded) == 1);
    CHECK(count(mixed, Primitive::Kind::kCylinder) == 1);
    CHECK(count(mixed, Primitive::Kind::kSphere) == 0);
}
