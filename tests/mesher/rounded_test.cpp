// Parts that meet tangentially: one smooth surface without false creases, and no film between the parts.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "host/common/constants.hpp"
#include "mortise/solid.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/rounded_solids.hpp"

namespace mortise::test {
namespace {

struct Shape {
    const char* name;
    NodeIndex (*add)(Model&);
    double volume;
    double crease_length;
    std::size_t corners;
    bool pairwise = true;  ///< nowhere do more than two surfaces go on from each other within a cell
};

/// Sizes are not in any simple ratio to a cell.
const Shape kShapes[] = {
    {"stadium", [](Model& m) { return add_stadium(m, 4.35, 16.023, -3.1, 3.2); },
     6.3 * (kPi * 4.35 * 4.35 + 2 * 4.35 * 16.023), 4 * (kPi * 4.35 + 16.023), 0},
    {"capsule", [](Model& m) { return add_capsule(m, 4.2, 13.7); },
     kPi * 4.2 * 4.2 * 13.7 + 4 / 3.0 * kPi * 4.2 * 4.2 * 4.2, 0, 0},
    {"rounded plate",
     [](Model& m) {
         return add_rounded_plate(m, {15.3, 10.9, 2.65}, 4.4);
     },
     5.3 * (4 * 15.3 * 10.9 - (4 - kPi) * 4.4 * 4.4), 2 * (4 * (10.9 + 6.5) + 2 * kPi * 4.4), 0},
    {"rounded box",
     [](Model& m) {
         return add_rounded_box(m, {12.3, 9.1, 7.7}, 3.4);
     },
     8 * 8.9 * 5.7 * 4.3 + 8 * 3.4 * (8.9 * 5.7 + 5.7 * 4.3 + 4.3 * 8.9) +
         2 * kPi * 3.4 * 3.4 * (8.9 + 5.7 + 4.3) + 4 / 3.0 * kPi * 3.4 * 3.4 * 3.4,
     0, 0, false},
    {"rounded disc", [](Model& m) { return add_rounded_disc(m, 10.1, 3.3); },
     2 * 3.3 * kPi * 10.1 * 10.1 + kPi* kPi * 3.3 * 3.3 * 10.1 + 4 / 3.0 * kPi * 3.3 * 3.3 * 3.3, 0, 0},
    {"teardrop", [](Model& m) { return add_teardrop(m, 5.2, -7.1, 6.4); },
     13.5 * (0.75 * kPi + 1) * 5.2 * 5.2, 2 * (1.5 * kPi + 2) * 5.2 + 13.5, 2},
    {"filleted box",
     [](Model& m) {
         return add_filleted_box(m, {20.3, 15.7, 9.1}, 4.2);
     },
     9.1 * (20.3 * 15.7 - (1 - kPi / 4) * 4.2 * 4.2),
     2 * (2 * (20.3 + 15.7) - 2 * 4.2 + kPi / 2 * 4.2) + 3 * 9.1, 6},
};

}  // namespace

TEST_CASE("parts that meet tangentially are one smooth surface") {
    for (const Shape& shape : kShapes) {
        for (const Affine& pose : {kIdentity, rotation({0, 0, 1}, kPi / 6), rotation({1, 2, 3}, 0.7)}) {
            CAPTURE(std::string(shape.name));
            CAPTURE(pose[1]);
            const Meshed result =
                mesh_and_check(one_solid([&](Model& m) { return m.add_transform(pose, shape.add(m)); }), 6);
            CHECK(result.defects == "");
            CHECK(result.check.volume == doctest::Approx(shape.volume).epsilon(0.0025));
            if (!shape.pairwise) continue;
            double length = 0;
            for (const FeatureCurve& curve : result.report.features.curves) length += curve.length;
            CHECK(length == doctest::Approx(shape.crease_length).epsilon(0.002));
            CHECK(result.report.features.corners.size() == shape.corners);
            // No film between the parts: nothing was kept flat or given up, and next to nothing merged.
            CHECK(result.report.refused_splits == 0);
            CHECK(result.report.unresolved == 0);
            CHECK(result.report.merged_nodes <= 1);
            const auto& jacobians = result.report.scaled_jacobians;
            CHECK(*std::min_element(jacobians.begin(), jacobians.end()) > 0.19f);
        }
    }
}

TEST_CASE("a bent pipe and the straight ones at its ends are one smooth surface") {
    const auto leg = [](const char* pose, double overlap) {
        return "multmatrix(" + std::string(pose) + ") { multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1," +
               std::to_string(-overlap) + "],[0,0,0,1]]) { cylinder(h = " + std::to_string(25 + overlap) +
               ", r1 = 10, r2 = 10); } }";
    };
    // Ends that meet; that overlap by a hundredth and a tenth of a cell, as people make them to be sure.
    for (const double overlap : {0.0, 0.01, 0.1}) {
        const std::string pipe =
            "rotate_extrude(angle = 90) { multmatrix([[1,0,0,30],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) "
            "{ circle(r = 10); } }" +
            leg("[[1,0,0,30],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]", overlap) +
            leg("[[0,0,-1,0],[0,1,0,30],[1,0,0,0],[0,0,0,1]]", overlap);
        for (const char* pose : {"[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]",
                                 "[[0.8,-0.6,0,1],[0.48,0.64,-0.6,2],[0.36,0.48,0.8,3],[0,0,0,1]]"}) {
            CAPTURE(overlap);
            CAPTURE(pose);
            const Meshed result = mesh_and_check(
                parse_model("multmatrix(" + std::string(pose) + ") { " + pipe + " }", "csg", "bend.csg"), 6);
            CHECK(result.defects == "");
            CHECK(result.check.volume == doctest::Approx(100 * kPi * (15 * kPi + 50)).epsilon(0.006));
            double length = 0;
            for (const FeatureCurve& curve : result.report.features.curves) length += curve.length;
            CHECK(length == doctest::Approx(2 * 20 * kPi).epsilon(0.002));
            CHECK(result.report.features.corners.empty());
            CHECK(result.report.warnings.empty());
            CHECK(result.report.merged_nodes <= 1);
            const auto& jacobians = result.report.scaled_jacobians;
            CHECK(*std::min_element(jacobians.begin(), jacobians.end()) > 0.19f);
        }
    }
}

TEST_CASE("the hull of two balls is exact and smooth") {
    const auto ball_at = [](double x, double y, double z, double r) {
        return "multmatrix([[1,0,0," + std::to_string(x) + "],[0,1,0," + std::to_string(y) + "],[0,0,1," +
               std::to_string(z) + "],[0,0,0,1]]) { sphere(r = " + std::to_string(r) + "); }";
    };
    // A capsule, aslant; a rounded cone: cap, frustum between the circles of contact, cap.
    const double apart = std::sqrt(16.0 * 16 + 5 * 5 + 7 * 7);
    const double sine = (6.2 - 3.7) / apart;
    const double cosine = std::sqrt(1 - sine * sine);
    const auto cap = [&](double radius, double height) {
        return kPi * height * height * (radius - height / 3);
    };
    const double a = 6.2 * cosine;
    const double b = 3.7 * cosine;
    const double frustum = kPi * (apart - (6.2 - 3.7) * sine) / 3 * (a * a + a * b + b * b);
    const double cone = cap(6.2, 6.2 * (1 + sine)) + cap(3.7, 3.7 * (1 - sine)) + frustum;
    const double capsule = kPi * 4 * 4 * (apart + 4 * 4 / 3.0);
    for (const auto& [text, volume] :
         {std::pair{"hull() {" + ball_at(1, 2, 3, 4) + ball_at(17, 7, 10, 4) + "}", capsule},
          std::pair{"hull() {" + ball_at(1, 2, 3, 6.2) + ball_at(17, 7, 10, 3.7) + "}", cone}}) {
        CAPTURE(text);
        const Meshed result = mesh_and_check(parse_model(text, "csg", "hull.csg"), 6);
        CHECK(result.defects == "");
        CHECK(result.check.euler_characteristic == 2);
        CHECK(result.check.volume == doctest::Approx(volume).epsilon(4e-3));
        CHECK(result.report.features.curves.empty());
        CHECK(result.report.warnings.empty());
        float worst = 1;
        for (const float quality : result.report.scaled_jacobians) worst = std::min(worst, quality);
        CHECK(worst > 0.18f);
    }
}

TEST_CASE("rounded solids are one smooth surface, whose volume converges at order 2") {
    using Kind = RoundedSolid::Shape;
    RoundedSolid box;  // Steiner's formula: 8 by 6 by 4 and a ball of 2.3
    for (int i = 0; i < 8; ++i)
        box.balls.push_back({{(i & 1) * 8.0, (i >> 1 & 1) * 6.0, (i >> 2) * 4.0}, 2.3});
    const double box_volume = 192 + 208 * 2.3 + kPi * 18 * 2.3 * 2.3 + 4 / 3.0 * kPi * 2.3 * 2.3 * 2.3;
    RoundedSolid slot;
    slot.shape = Kind::kPlate;
    slot.balls = {{{-5, 1, 0}, 3}, {{6, 2, 0}, 3}};
    slot.high = 2;
    slot.rounding = 1.7;
    const double apart = std::hypot(11.0, 1.0);
    const double area = 9 * kPi + 6 * apart;
    const double rim = 6 * kPi + 2 * apart;
    const double slot_volume = 2 * (area + 1.7 * rim + kPi * 1.7 * 1.7) + 2 * area * 1.7 +
                               rim * kPi / 2 * 1.7 * 1.7 + 4 / 3.0 * kPi * 1.7 * 1.7 * 1.7;
    RoundedSolid pill;
    pill.shape = Kind::kRevolution;
    pill.balls = {{{5, 0, 0}, 1.9}, {{5, 3, 0}, 1.9}};
    const double pill_volume = 3 * kPi * 6.9 * 6.9 + 2 * 1.9 * kPi * 25 + kPi * kPi * 1.9 * 1.9 * 5 +
                               4 / 3.0 * kPi * 1.9 * 1.9 * 1.9;
    RoundedSolid tyre;  // Pappus: the profile's centre is at 7
    tyre.shape = Kind::kRing;
    tyre.balls = {{{6, 0, 0}, 2}, {{8, 3, 0}, 2}};
    const double tyre_volume = 2 * kPi * 7 * (4 * kPi + 4 * std::hypot(2.0, 3.0));
    const auto turn = rotation({1, 2, 3}, 0.7);
    for (const auto& [solid, volume] : {std::pair{box, box_volume}, std::pair{slot, slot_volume},
                                        std::pair{pill, pill_volume}, std::pair{tyre, tyre_volume}}) {
        CAPTURE(static_cast<int>(solid.shape));
        double errors[2];
        for (const int level : {5, 6}) {
            const Meshed result =
                mesh_and_check(one_solid([&, &solid = solid](Model& m) {
                                   return m.add_transform(turn, m.add_primitive(rounded(solid)));
                               }),
                               level);
            CHECK(result.defects == "");
            CHECK(result.check.euler_characteristic == (solid.shape == Kind::kRing ? 0 : 2));
            CHECK(result.report.features.curves.empty());
            CHECK(result.report.warnings.empty());
            const auto& jacobians = result.report.scaled_jacobians;
            CHECK(*std::min_element(jacobians.begin(), jacobians.end()) > 0.19f);
            errors[level - 5] = std::fabs(result.check.volume / volume - 1);
        }
        CHECK(errors[0] < 0.02);
        CHECK(errors[1] < errors[0] / 3);
    }
}

TEST_CASE("plates with round rims about a cell thick stay whole") {
    struct Plate {
        const char* name;
        RoundedSolid solid;
        double volume;
        double tolerance;
    };
    // A rectangle rounded in its plane, upright; the same between two heights, and rounded there; balls at
    // the corners of a rectangle; a lens.
    const double a = 4, b = 13.6, r = 0.16;
    const std::vector<Ball> corners = {{{0, 0, 0}, r}, {{a, 0, 0}, r}, {{a, b, 0}, r}, {{0, b, 0}, r}};
    RoundedSolid column, plate, pillow, lens;
    column.shape = RoundedSolid::Shape::kColumn;
    column.balls = {{{0, 0, 0}, 0.05}, {{0.2, 0, 0}, 0.05}, {{0.2, b, 0}, 0.05}, {{0, b, 0}, 0.05}};
    plate.shape = RoundedSolid::Shape::kPlate;
    plate.balls = corners;
    plate.high = 0.25;
    plate.rounding = 0.05;
    pillow.balls = corners;
    lens.shape = RoundedSolid::Shape::kRevolution;
    lens.balls = {{{0, 0, 0}, 0.2}, {{5, 0, 0}, 0.1}};
    const double corner = kPi * r * r;
    const double outline = 2 * (a + b), area = a * b + outline * r + corner;
    const double turn = outline + 2 * kPi * r;  // length of the plate's outline
    const Plate plates[] = {
        {"column", column, 3 * ((0.2 + 0.1) * (b + 0.1) - (4 - kPi) * 0.05 * 0.05), 0.03},
        {"plate", plate, (0.25 + 0.1) * area + turn * (0.05 * 0.25 + kPi * 0.05 * 0.05 / 2), 0.03},
        {"pillow", pillow, 2 * r * a * b + corner * (a + b) + 4 * r * corner / 3, 0.03},
        {"lens", lens, 0, 0},  // no closed form: against a mesh of small cells
    };
    RandomSource random(17);
    for (const Plate& p : plates) {
        CAPTURE(std::string(p.name));
        for (int pose = 0; pose < 3; ++pose) {
            CAPTURE(pose);
            Solid solid = rounded(p.solid);
            if (p.solid.shape == RoundedSolid::Shape::kColumn)
                solid = solid & Solid(box({-9, -9, 0}, {99, 99, 3}));
            if (pose > 0)
                solid =
                    solid.rotated(random.uniform(0, 360), {random.uniform(-1, 1), random.uniform(-1, 1), 1});
            MeshOptions options;
            options.size = 0.3;
            const Meshed m = mesh_and_check(make_model(solid), options);
            CHECK(m.defects == "");
            CHECK(m.check.components == 1);
            CHECK(m.check.euler_characteristic == 2);
            CHECK(m.check.nonmanifold_edges == 0);
            CHECK(m.check.nonmanifold_nodes == 0);
            double volume = p.volume;
            if (volume == 0) {
                options.size = 0.08;
                volume = mesh_and_check(make_model(solid), options).check.volume;
            }
            CHECK(m.check.volume == doctest::Approx(volume).epsilon(0.04));
        }
    }
}

}  // namespace mortise::test
