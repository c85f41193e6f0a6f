// Extruded outlines with a single corner, as teardrops: the smooth wall meets itself there.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr double kTipRadius = 3;
constexpr double kHeight = 3;

struct Extrusion {
    const char* name;
    std::string text;
    Vec3 corner;  ///< and kHeight above it
    double volume;
    int euler;
};

/// Three quarters of a circle and its tangents, which meet at a right angle.
std::string teardrop() {
    constexpr int kEdges = 48;
    std::ostringstream text;
    text.precision(12);
    text << "polygon(points = [";
    for (int i = 0; i <= kEdges; ++i) {
        const double angle = kPi * (0.75 + 1.5 * i / kEdges);
        text << "[" << kTipRadius * std::cos(angle) << "," << kTipRadius * std::sin(angle) << "],";
    }
    text << "[0," << kTipRadius * std::sqrt(2) << "]]);";
    return text.str();
}

std::string extruded(double height, const std::string& outline) {
    std::ostringstream text;
    text << "linear_extrude(height = " << height << ") { " << outline << " }\n";
    return text.str();
}

std::vector<Extrusion> solids() {
    const double area = kTipRadius * kTipRadius * (0.75 * kPi + 1);
    const Vec3 tip = {0, kTipRadius * std::sqrt(2), 0};
    return {
        {"teardrop", extruded(kHeight, teardrop()), tip, area * kHeight, 2},
        {"plate with a teardrop",
         "difference() { multmatrix([[1,0,0,-5],[0,1,0,-5],[0,0,1,0],[0,0,0,1]]) { cube(size = [10, 10, 3]); "
         "} "
         "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,-1],[0,0,0,1]]) { " +
             extruded(kHeight + 2, teardrop()) + " } }",
         tip, (100 - area) * kHeight, 0},
        {"L with round corners",
         extruded(kHeight, "offset(r = 1) { polygon(points = [[0,0],[8,0],[8,2],[2,2],[2,6],[0,6]]); }"),
         {3, 3, 0},
         (24 + 28 - 1 + 5 * kPi / 4) * kHeight,
         2},
    };
}

}  // namespace

TEST_CASE("outlines with a single corner are sharp there, in any pose") {
    RandomSource random(environment_number("MORTISE_RANDOM_SEED", 11));
    const int poses = static_cast<int>(environment_number("MORTISE_TEARDROPS", 10));
    for (const Extrusion& solid : solids()) {
        for (int i = 0; i < poses; ++i) {
            CAPTURE(std::string(solid.name));
            CAPTURE(i);
            const Vec3 axis = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            const Affine pose = rotation(axis, random.uniform(0, 2 * kPi));
            std::ostringstream text;
            text.precision(17);
            text << "multmatrix([";
            for (std::size_t k = 0; k < 12; ++k)
                text << (k % 4 == 0 ? "[" : "") << pose[k] << (k % 4 == 3 ? "]," : ",");
            text << "[0,0,0,1]]) { " << solid.text << " }";
            const Meshed m = mesh_and_check(parse_model(text.str(), "csg", "part.csg"), 5);
            CHECK(m.defects == "");
            CHECK(m.check.volume == doctest::Approx(solid.volume).epsilon(0.01));
            CHECK(m.check.euler_characteristic == solid.euler);
            CHECK(m.report.hinge_edges + m.report.hinge_nodes == 0);
            CHECK(m.report.dropped_features == 0);
            CHECK(*std::min_element(m.check.min_scaled_jacobian.begin(), m.check.min_scaled_jacobian.end()) >=
                  0.15);
            const Vec3 above = {solid.corner[0], solid.corner[1], kHeight};
            CHECK(nearest_node(m.mesh, apply(pose, solid.corner)) < 1e-6);
            CHECK(nearest_node(m.mesh, apply(pose, above)) < 1e-6);
        }
    }
}

TEST_CASE("profiles with a single corner are sharp there, along a path and around an axis") {
    const double area = kTipRadius * kTipRadius * (0.75 * kPi + 1);
    const double distance = 3 * kTipRadius;  // of the circle's centre from the axis
    const double moment = area * distance + kTipRadius * kTipRadius * kTipRadius * std::sqrt(2) / 6;
    const auto profile = [](double above) {
        std::ostringstream text;
        text.precision(12);
        const double h = std::sqrt(0.5), s = std::sqrt(2);
        const double points[8][2] = {{0, s}, {h, h}, {s, 0}, {h, -h}, {0, -s}, {-h, -h}, {-s, 0}, {-h, h}};
        text << "curve2d profile = (8;";
        for (const auto& p : points) text << kTipRadius * p[0] << "," << kTipRadius * p[1] + above << ";";
        text << "5; 2,1,2; 3,2,3,4; 3,4,5,6; 3,6,7,8; 2,8,1);\n";
        return text.str();
    };
    RandomSource random(environment_number("MORTISE_RANDOM_SEED", 3));
    for (int i = 0; i < 4; ++i) {
        CAPTURE(i);
        std::ostringstream way;
        way << random.uniform(1, 3) << "," << random.uniform(1, 3) << "," << random.uniform(1, 3);
        const auto meshed = [&](double above, const std::string& solid) {
            return mesh_and_check(
                parse_model("algebraic3d\n" + profile(above) + solid + "tlo s;\n", "geo", "part.geo"), 5);
        };
        const Meshed bar = meshed(0, "curve3d path = (2; 0,0,0; " + way.str() +
                                         "; 1; 2,1,2);\nsolid s = extrusion(path; profile; 1,-2,0.5);\n");
        const Meshed ring = meshed(distance, "solid s = revolution(0,0,0; " + way.str() + "; profile);\n");
        for (const Meshed* m : {&bar, &ring}) {
            const bool is_ring = m == &ring;
            CAPTURE(is_ring);
            CHECK(m->defects == "");
            CHECK(m->report.hinge_edges + m->report.hinge_nodes == 0);
            CHECK(m->check.euler_characteristic == (is_ring ? 0 : 2));
            CHECK(m->report.features.curves.size() == (is_ring ? 1 : 3));
            CHECK(*std::min_element(m->check.min_scaled_jacobian.begin(),
                                    m->check.min_scaled_jacobian.end()) >= 0.15);
        }
        CHECK(ring.check.volume == doctest::Approx(2 * kPi * moment).epsilon(0.01));
        CHECK(ring.mesh.surface_names.size() == 1);
    }
}

}  // namespace mortise::test
