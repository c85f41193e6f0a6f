// Rods that meet in a ball of their radius, as people build lattices: each rod ends in a disc that halves the
// ball, and where two of them meet, both and the ball touch in one point.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr double kLength = 10;

/// To six significant figures, which is what OpenSCAD writes.
Affine rounded(Affine map) {
    for (double& x : map) {
        if (x == 0) continue;
        const double unit = std::pow(10, std::floor(std::log10(std::fabs(x))) - 5);
        x = std::round(x / unit) * unit;
    }
    return map;
}

/// From the origin along a direction, then posed.
NodeIndex add_rod(Model& m, const Affine& pose, const Vec3& direction, double radius, bool is_rounded) {
    const double length = std::hypot(direction[0], direction[1], direction[2]);
    const double tilt = std::acos(direction[2] / length);
    const Vec3 axis = {-direction[1], direction[0], 0};
    const Affine turn = std::hypot(axis[0], axis[1]) > 0 ? rotation(axis, tilt)
                        : tilt < 1                       ? kIdentity
                                                         : rotation({1, 0, 0}, kPi);
    const Affine map = compose(pose, turn);
    return m.add_transform(is_rounded ? rounded(map) : map, add_cylinder(m, radius, 0, kLength));
}

struct Joint {
    const char* name;
    std::vector<Vec3> directions;
};

const std::vector<Joint>& joints() {
    static const std::vector<Joint> all = {
        {"elbow", {{1, 0, 0}, {0, 1, 0}}},
        {"corner of a cube", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
        {"middle of a cubic lattice", {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}},
        {"diamond", {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}},
        {"corner, face centred", {{1, 1, 0}, {1, 0, 1}, {0, 1, 1}}},
        {"two rods, body centred", {{-1, 1, -1}, {-1, -1, -1}}},
        {"truncated octahedron", {{0, 1, 1}, {1, -1, 0}, {-1, -1, 0}, {0, 1, -1}}},
    };
    return all;
}

}  // namespace

/// How the rods of a joint are given: each is a cylinder and a ball at its end, and there is one in the
/// middle; or it is the hull of two balls.
enum class Form { kCylinders, kHulls };

Model make_joint(const Joint& joint, const Affine& pose, double radius, bool is_rounded, Form form) {
    return one_solid([&](Model& m) {
        std::vector<NodeIndex> parts;
        const Vec3 middle = test::apply(pose, {0, 0, 0});
        for (const Vec3& direction : joint.directions) {
            const double length = std::hypot(direction[0], direction[1], direction[2]);
            Vec3 end;
            for (std::size_t j = 0; j < 3; ++j) end[j] = kLength / length * direction[j];
            end = test::apply(pose, end);
            if (form == Form::kHulls) {
                RoundedSolid rod;
                rod.balls = {{middle, radius}, {end, radius}};
                parts.push_back(m.add_primitive(mortise::rounded(rod)));
                continue;
            }
            parts.push_back(add_rod(m, pose, direction, radius, is_rounded));
            parts.push_back(add_ball(m, end, radius));
        }
        if (form == Form::kCylinders) parts.push_back(add_ball(m, middle, radius));
        return unite(m, parts);
    });
}

void check_joint(const Model& model, const MeshOptions& options) {
    const Meshed m = mesh_and_check(model, options);
    CHECK(m.defects == "");
    CHECK(m.check.euler_characteristic == 2);
    CHECK(m.report.hinge_edges + m.report.hinge_nodes == 0);
    CHECK(m.report.dropped_features == 0);
    CHECK(*std::min_element(m.check.min_scaled_jacobian.begin(), m.check.min_scaled_jacobian.end()) >= 0.15);
}

TEST_CASE("rods that meet in a ball of their radius") {
    RandomSource random(environment_number("MORTISE_RANDOM_SEED", 7));
    const int count = static_cast<int>(environment_number("MORTISE_RODS", 4));
    for (const Joint& joint : joints()) {
        for (int i = 0; i < count; ++i) {
            CAPTURE(joint.name);
            CAPTURE(i);
            const double radius = random.uniform(0.6, 1.4);
            const bool turned = i % 4 > 1;
            const Vec3 axis = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            const Vec3 by = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            Affine pose = translation(by);
            if (turned) pose = compose(pose, rotation(axis, random.uniform(0, 2 * kPi)));
            MeshOptions options;
            options.size = random.uniform(0.28, 0.4) * radius;
            for (const Form form : {Form::kCylinders, Form::kHulls})
                check_joint(make_joint(joint, pose, radius, i % 2 == 1, form), options);
        }
    }
}

TEST_CASE("struts of a cubic lattice, cut at its own box, stay apart where they leave their joints") {
    // At one joint of this pose, two facets at a node that went, and two at the node that it became, met.
    const Model model = one_solid([](Model& m) {
        const NodeIndex strut = add_cylinder(m, 0.15, -60, 60);
        std::vector<NodeIndex> struts;
        for (const double a : {0, 9, 10}) {
            for (const double b : {0, 9, 10}) {
                struts.push_back(m.add_transform({1, 0, 0, a, 0, 1, 0, b, 0, 0, 1, 0}, strut));
                struts.push_back(m.add_transform({0, 0, 1, 0, 1, 0, 0, a, 0, 1, 0, b}, strut));
                struts.push_back(m.add_transform({0, 1, 0, b, 0, 0, 1, 0, 1, 0, 0, a}, strut));
            }
        }
        return intersect(m, {unite(m, struts), add_box(m, {-0.5, -0.5, -0.5}, {10.5, 10.5, 10.5})});
    });
    const Meshed m = mesh_and_check(model, 7);
    CHECK(m.defects == "");
    CHECK(m.report.hinge_edges + m.report.hinge_nodes == 0);
    CHECK(m.check.euler_characteristic == 2 * (27 - 54));  // joints and the struts between them
}

TEST_CASE("springs, chains of hulls or of rods with balls, are smooth outside their bends") {
    const auto text_of = [](Form form) {
        std::ostringstream text;  // six figures
        for (int i = 0; i < 12; ++i) {
            const auto ball = [](int at) {
                std::ostringstream out;
                out << "multmatrix([[1,0,0," << 2 * std::cos(kPi / 12 * at) << "],[0,1,0,"
                    << 2 * std::sin(kPi / 12 * at) << "],[0,0,1," << 0.12 * at
                    << "],[0,0,0,1]]) { sphere(r = 0.35); }\n";
                return out.str();
            };
            if (form == Form::kHulls) {
                text << "hull() {\n" << ball(i) << ball(i + 1) << "}\n";
                continue;
            }
            const double middle = kPi / 12 * (i + 0.5);
            const double chord = 4 * std::sin(kPi / 24);
            const double length = std::hypot(chord, 0.12);
            const Vec3 z = {-std::sin(middle) * chord / length, std::cos(middle) * chord / length,
                            0.12 / length};
            const Vec3 x = {std::cos(middle), std::sin(middle), 0};
            const Vec3 y = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
            const Vec3 at = {2 * std::cos(kPi / 12 * i), 2 * std::sin(kPi / 12 * i), 0.12 * i};
            text << ball(i) << "multmatrix([";
            for (std::size_t j = 0; j < 3; ++j)
                text << "[" << x[j] << "," << y[j] << "," << z[j] << "," << at[j] << "],";
            text << "[0,0,0,1]]) { cylinder(h = " << length << ", r1 = 0.35, r2 = 0.35); }\n" << ball(i + 1);
        }
        return text.str();
    };
    for (const Form form : {Form::kHulls, Form::kCylinders}) {
        for (const double size : {0.16, 0.08}) {
            CAPTURE(size);
            MeshOptions options;
            options.size = size;
            check_joint(parse_model(text_of(form), "csg", "spring.csg"), options);
        }
    }
}

}  // namespace mortise::test
