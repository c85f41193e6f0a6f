// Features smaller than a cell: found where they are, kept with their topology or reported as lost; and no
// alarm where a surface only passes by.
//
// The frame of every model spans 30 units, so that at level 5 cells have unit size and their vertices are
// whole coordinates.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <string>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

constexpr int kProbedLevel = 5;

/// Two slabs, with a hollow of 20 units between them in which features float.
NodeIndex frame(Model& m) {
    return unite(m, {add_box(m, {0, 0, 0}, {30, 30, 10}), add_box(m, {0, 0, 0}, {10, 30, 30})});
}

Model beside_frame(const std::function<NodeIndex(Model&)>& feature) {
    return one_solid([&](Model& m) {
        const NodeIndex slabs = frame(m);
        return unite(m, {slabs, feature(m)});
    });
}

Model cut_from_block(const std::function<NodeIndex(Model&)>& feature) {
    return one_solid([&](Model& m) {
        const NodeIndex block = add_box(m, {0, 0, 0}, {30, 30, 30});
        return subtract(m, {block, feature(m)});
    });
}

double distance(const Vec3& a, const Vec3& b) {
    return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                     (a[2] - b[2]) * (a[2] - b[2]));
}

Meshed mesh_valid(const Model& model, MeshOptions options = {}) {
    if (options.level == 0) options.level = kProbedLevel;
    const Meshed result = mesh_and_check(model, options);
    CHECK(result.defects == "");
    CHECK(result.check.nonmanifold_edges == 0);
    return result;
}

std::string strict_refusal(const Model& model) {
    MeshOptions options;
    options.level = kProbedLevel;
    options.strict = true;
    try {
        generate(model, options);
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kMeshing);
        return error.what();
    }
    return "";
}

constexpr double kFrameVolume = 30.0 * 30 * 10 + 10.0 * 30 * 20;

}  // namespace

TEST_CASE("a small ball inside a cell is found and kept as a ball") {
    // Away from the cell's centre by more than the radius: no sample of the grid lies in it.
    const struct {
        Vec3 centre;
        double radius;
    } balls[] = {{{20.32, 20.32, 20.32}, 0.3},  {{20.66, 20.34, 20.7}, 0.29},  {{20.3, 20.6, 20.35}, 0.2},
                 {{20.21, 20.7, 20.64}, 0.1},   {{20.8, 20.13, 20.4}, 0.055},  {{20.4, 20.45, 20.42}, 0.03},
                 {{20.31, 20.71, 20.62}, 0.01}, {{20.77, 20.77, 20.77}, 0.001}};
    for (const auto& ball : balls) {
        CAPTURE(ball.radius);
        const double volume = 4.0 / 3 * kPi * std::pow(ball.radius, 3);
        for (const bool improve : {false, true}) {
            CAPTURE(improve);
            MeshOptions options;
            options.improve = improve;
            const auto check_feature = [&](const Meshed& result, bool material) {
                REQUIRE(result.report.missed.size() == 1);
                const MissedFeature& feature = result.report.missed[0];
                CHECK(feature.material == material);
                CHECK(feature.kept);
                CHECK(distance(feature.position, ball.centre) < ball.radius);
                CHECK(feature.thickness <= 2 * ball.radius * 1.01);
                CHECK(feature.thickness >= 0.5 * ball.radius);
                CHECK(feature.size >= 0.5 * ball.radius);
                CHECK(feature.size <= 2 * ball.radius + 0.25);
                REQUIRE(result.report.warnings.size() == 1);
                CHECK(result.report.warnings[0].find("1 feature between the vertices") == 0);
            };
            const Meshed solid = mesh_valid(
                beside_frame([&](Model& m) { return add_ball(m, ball.centre, ball.radius); }), options);
            check_feature(solid, true);
            CHECK(solid.check.components == 2);
            CHECK(solid.check.euler_characteristic == 4);
            // A tetrahedron in a ball is 12 % of it; collapses may leave no more.
            if (ball.radius > 0.02) {
                const double kept = (solid.check.volume - kFrameVolume) / volume;
                CHECK(kept > (improve ? 0.05 : 0.2));
                CHECK(kept < 1.001);
            }
            const Meshed hollow = mesh_valid(
                cut_from_block([&](Model& m) { return add_ball(m, ball.centre, ball.radius); }), options);
            check_feature(hollow, false);
            CHECK(hollow.check.components == 1);
            CHECK(hollow.check.euler_characteristic == 4);
            if (ball.radius > 0.02) {
                const double kept = (27000 - hollow.check.volume) / volume;
                CHECK(kept > (improve ? 0.05 : 0.2));
                CHECK(kept < 1.001);
            }
        }
        CHECK(strict_refusal(beside_frame([&](Model& m) { return add_ball(m, ball.centre, ball.radius); })) ==
              "");
    }
}

/// Balls of 1/18 of a cell at `count` places in a cell: each is reported, or in the mesh because a sample
/// lies in it.
void check_tiny_balls(int count, const std::function<NodeIndex(Model&, const Vec3&)>& add) {
    for (int k = 0; k < count; ++k) {
        const Vec3 centre = {20 + std::fmod(0.07 + 0.6180339887 * k, 1),
                             20 + std::fmod(0.31 + 0.7548776662 * k, 1),
                             20 + std::fmod(0.83 + 0.5698402910 * k, 1)};
        CAPTURE(k);
        MeshOptions options;
        options.level = kProbedLevel;
        options.improve = false;
        MeshReport report;
        const Mesh mesh = generate(beside_frame([&](Model& m) { return add(m, centre); }), options, &report);
        if (report.missed.empty())
            CHECK(nearest_node(mesh, centre) < 0.1);
        else
            CHECK(distance(report.missed[0].position, centre) < 1.0 / 18);
    }
}

TEST_CASE("a ball of 1/18 of a cell is found wherever it lies") {
    check_tiny_balls(40, [](Model& m, const Vec3& centre) { return add_ball(m, centre, 1.0 / 18); });
}

// Bounds of its polynomial are loose, so that gradients and samples must tell.
TEST_CASE("a ball of 1/18 of a cell is found where a formula of degree 8 makes it") {
    check_tiny_balls(20, [](Model& m, const Vec3& centre) {
        Primitive ball;
        ball.kind = Primitive::Kind::kExpression;
        ball.expression = "s = (x-" + std::to_string(centre[0]) + ")^2 + (y-" + std::to_string(centre[1]) +
                          ")^2 + (z-" + std::to_string(centre[2]) +
                          ")^2; 8*s^4 - 20*s^3 + 18*s^2 + 12*s - 12/18^2";
        return intersect(m, {m.add_primitive(ball), add_box(m, {15, 15, 15}, {25, 25, 25})});
    });
}

TEST_CASE("what passes through cells between their vertices is reported as lost") {
    const struct {
        const char* name;
        Model model;
        bool material;
        double length;
        double thickness;
        Vec3 on_axis;  ///< distance of the place reported from this line is below the thickness
        Vec3 direction;
    } cases[] = {
        {"free rod",
         beside_frame([](Model& m) {
             return m.add_transform(translation({20.4, 20.45, 0}), add_cylinder(m, 0.1, 17.3, 23.6));
         }),
         true,
         6.3,
         0.2,
         {20.4, 20.45, 0},
         {0, 0, 1}},
        {"rod on the frame",
         beside_frame([](Model& m) {
             return m.add_transform(translation({20.35, 20.3, 0}), add_cylinder(m, 0.1, 5, 22.2));
         }),
         true,
         12.2,
         0.2,
         {20.35, 20.3, 0},
         {0, 0, 1}},
        {"bore",
         cut_from_block([](Model& m) {
             return m.add_transform(translation({20.4, 20.45, 0}), add_cylinder(m, 0.1, -1, 31));
         }),
         false,
         30,
         0.2,
         {20.4, 20.45, 0},
         {0, 0, 1}},
    };
    for (const auto& test : cases) {
        CAPTURE(test.name);
        const Meshed result = mesh_valid(test.model);
        REQUIRE(result.report.missed.size() == 1);
        const MissedFeature& feature = result.report.missed[0];
        CHECK(feature.material == test.material);
        CHECK_FALSE(feature.kept);
        CHECK(feature.size == doctest::Approx(test.length).epsilon(0.05));
        CHECK(feature.thickness == doctest::Approx(test.thickness).epsilon(0.1));
        Vec3 off = {feature.position[0] - test.on_axis[0], feature.position[1] - test.on_axis[1], 0};
        CHECK(distance(off, {0, 0, 0}) < 0.1);
        const std::string refusal = strict_refusal(test.model);
        CHECK(refusal.find("strict: 1 feature between the vertices of the grid, 1 of them lost") !=
              std::string::npos);
    }
}

TEST_CASE("a thin torus and a ball across an edge of the grid are reported with their size") {
    const Meshed ring = mesh_valid(beside_frame([](Model& m) {
        return m.add_transform(translation({20.5, 20.5, 20.3}), add_torus(m, 2.25, 0.08));
    }));
    REQUIRE(!ring.report.missed.empty());
    for (const MissedFeature& feature : ring.report.missed) {
        const double radius = std::hypot(feature.position[0] - 20.5, feature.position[1] - 20.5);
        CHECK(radius == doctest::Approx(2.25).epsilon(0.04));
        CHECK(feature.thickness == doctest::Approx(0.16).epsilon(0.15));
    }
    const Meshed ball = mesh_valid(beside_frame([](Model& m) {
        return add_ball(m, {20.05, 20.05, 20.42}, 0.3);
    }));
    REQUIRE(ball.report.missed.size() == 1);
    CHECK_FALSE(ball.report.missed[0].kept);
    CHECK(ball.report.missed[0].size == doctest::Approx(0.6).epsilon(0.25));
}

TEST_CASE(
    "a round slot narrower than a cell, bridged where edges of the grid cross it, is reported as lost") {
    // A row of slots of 0.7 cells, each between two planes of the grid: one surface each.
    const auto slots = [](double width) {
        std::string text = "difference() { cube([30, 30, 1]); ";
        for (int i = 0; i < 5; ++i)
            text += "implicit(\"hypot(x - " + std::to_string(4.55 + 5 * i) + ", max(abs(y - 15) - 9, 0)) - " +
                    std::to_string(width / 2) + "\"); ";
        return parse_model(text + "}", "csg", "slots.csg");
    };
    const Model narrow = slots(0.7);
    const Meshed m = mesh_valid(narrow);
    CHECK(m.check.euler_characteristic != 2 - 2 * 5);
    CHECK(m.report.missed.size() == 5);
    for (const MissedFeature& feature : m.report.missed) {
        CHECK_FALSE(feature.kept);
        CHECK_FALSE(feature.material);
        CHECK(feature.size > 16);
        CHECK(feature.size < 20);
    }
    CHECK(strict_refusal(narrow).find("a hole") != std::string::npos);
    const Model wide = slots(1.6);
    CHECK(mesh_valid(wide).check.euler_characteristic == 2 - 2 * 5);
    CHECK(strict_refusal(wide) == "");
}

TEST_CASE("round slots that OpenSCAD's hull makes have a surface on each side, and stay open") {
    std::string text = "difference() { cube([30, 30, 1]); ";
    for (int i = 0; i < 5; ++i)
        text += "translate([" + std::to_string(4.55 + 5 * i) +
                ", 6, -1]) linear_extrude(height = 3) hull() { circle(d = 0.7); translate([0, 18]) circle(d "
                "= 0.7); } ";
    const Model model = parse_model(text + "}", "csg", "slots.csg");
    CHECK(mesh_valid(model).check.euler_characteristic == 2 - 2 * 5);
    CHECK(strict_refusal(model) == "");
}

TEST_CASE("two features of one cell: one is kept, the other reported as lost") {
    const Model model = beside_frame([](Model& m) {
        return unite(m, {add_ball(m, {20.25, 20.25, 20.25}, 0.15), add_ball(m, {20.75, 20.7, 20.75}, 0.1)});
    });
    const Meshed result = mesh_valid(model);
    REQUIRE(result.report.missed.size() == 2);
    CHECK(result.report.missed[0].kept);
    CHECK_FALSE(result.report.missed[1].kept);
    CHECK(distance(result.report.missed[1].position, {20.75, 20.7, 20.75}) < 0.1);
    CHECK(result.check.components == 2);
    CHECK(strict_refusal(model).find("2 features between the vertices of the grid, 1 of them lost") !=
          std::string::npos);
}

TEST_CASE("no alarm where surfaces only pass by") {
    const auto formula = [](Model& m, const char* text) {
        Primitive primitive;
        primitive.kind = Primitive::Kind::kExpression;
        primitive.expression = text;
        return intersect(m, {m.add_primitive(primitive), add_ball(m, {0, 0, 0}, 1)});
    };
    const Affine turn = rotation({1, 2, 3}, 0.7);
    const struct {
        std::string name;
        Model model;
    } models[] = {
        {"ball", one_solid([](Model& m) {
             return add_ball(m, {0.1, 0.2, 0.3}, 1);
         })},
        {"box", one_solid([&](Model& m) {
             return m.add_transform(turn, add_box(m, {0, 0, 0}, {1, 2, 3}));
         })},
        {"torus", one_solid([&](Model& m) { return m.add_transform(turn, add_torus(m, 1, 0.4)); })},
        {"cylinder", one_solid([&](Model& m) { return m.add_transform(turn, add_cylinder(m, 1, 0, 3)); })},
        {"frustum", one_solid([&](Model& m) { return m.add_transform(turn, add_frustum(m, 1, 0.4, 0, 2)); })},
        {"drilled", one_solid([&](Model& m) {
             return subtract(m,
                             {add_ball(m, {0, 0, 0}, 1), m.add_transform(turn, add_cylinder(m, 0.4, -2, 2)),
                              add_cylinder(m, 0.4, -2, 2)});
         })},
        {"gyroid", one_solid([&](Model& m) {
             return formula(m, "sin(5*x)*cos(5*y)+sin(5*y)*cos(5*z)+sin(5*z)*cos(5*x)");
         })},
        {"formula of a ball", one_solid([&](Model& m) { return formula(m, "sqrt(x*x+y*y+z*z)-0.8"); })},
    };
    for (const auto& test : models) {
        for (const int level : {4, 5, 6}) {
            CAPTURE(test.name);
            CAPTURE(level);
            MeshOptions options;
            options.level = level;
            options.improve = false;
            MeshReport report;
            generate(test.model, options, &report);
            CHECK(report.missed.empty());
        }
    }
}

TEST_CASE("no alarm where holes bulge by less than a quarter of a cell through edges of the grid") {
    // Cells of level 5 are 1 wide, with vertices at integers in x and y. 0.22 and 0.17 beyond y = 6.
    const double holes[][3] = {{5.569, 5.802, 0.415}, {5.5, 5.55, 0.62}};
    for (const auto& hole : holes) {
        CAPTURE(hole[2]);
        MeshOptions options;
        options.level = 5;
        MeshReport report;
        generate(one_solid([&](Model& m) {
                     const NodeIndex cylinder = add_cylinder(m, hole[2], -1, 5);
                     return subtract(m, {add_box(m, {0, 0, 0.3}, {30, 30, 3.1}),
                                         m.add_transform(translation({hole[0], hole[1], 0}), cylinder)});
                 }),
                 options, &report);
        CHECK(report.missed.empty());
    }
}

TEST_CASE("the same features and the same mesh for any threads, work-groups and pieces") {
    const Model model = one_solid([](Model& m) {
        std::vector<NodeIndex> parts = {frame(m)};
        for (int k = 0; k < 25; ++k) {
            parts.push_back(
                add_ball(m, {15 + 0.37 * k, 14 + std::fmod(5.17 * k, 11), 13 + std::fmod(7.31 * k, 12)},
                         0.1 + 0.01 * k));
        }
        return unite(m, parts);
    });
    MeshOptions options;
    options.level = kProbedLevel;
    options.threads = 1;
    const Meshed first = mesh_and_check(model, options);
    CHECK(first.defects == "");
    CHECK(first.report.missed.size() > 5);
    for (const int threads : {2, 5}) {
        options.threads = threads;
        options.pieces = threads;
        options.work_group_size = threads == 2 ? 0 : 7;
        const Meshed other = mesh_and_check(model, options);
        CHECK(is_same_mesh(first.mesh, other.mesh));
        REQUIRE(other.report.missed.size() == first.report.missed.size());
        for (std::size_t i = 0; i < first.report.missed.size(); ++i) {
            CHECK(other.report.missed[i].position == first.report.missed[i].position);
            CHECK(other.report.missed[i].size == first.report.missed[i].size);
            CHECK(other.report.missed[i].kept == first.report.missed[i].kept);
        }
    }
}

// Walls and gaps of 0.3 cells between different primitives: every surface is cut for itself.
TEST_CASE("a shell, a tube and a gap of 0.3 cells keep their topology") {
    constexpr double kCell = 1;
    int wrong_shells = 0;
    int wrong_tubes = 0;
    int wrong_gaps = 0;
    constexpr int kPoses = 6;
    for (int k = 0; k < kPoses; ++k) {
        const Affine turn =
            compose(translation({15.13 + 0.1 * k, 15.29, 15.41}), rotation({1, 2.0 + k, 3}, 0.3 + 0.37 * k));
        const auto placed = [&](Model& m, NodeIndex node) { return m.add_transform(turn, node); };
        MeshOptions options;
        options.size = kCell;
        options.improve = false;
        const auto shell = mesh_and_check(
            one_solid([&](Model& m) {
                return placed(m, subtract(m, {add_ball(m, {0, 0, 0}, 8), add_ball(m, {0, 0, 0}, 7.7)}));
            }),
            options);
        CHECK(shell.defects == "");
        if (shell.check.components != 1 || shell.check.euler_characteristic != 4) {
            ++wrong_shells;
            MESSAGE("shell ", k, ": components ", shell.check.components, ", Euler characteristic ",
                    shell.check.euler_characteristic, ", missed ", shell.report.missed.size());
        }
        const auto tube = mesh_and_check(
            one_solid([&](Model& m) {
                return placed(m, subtract(m, {add_cylinder(m, 5, -9, 9), add_cylinder(m, 4.7, -10, 10)}));
            }),
            options);
        CHECK(tube.defects == "");
        if (tube.check.components != 1 || tube.check.euler_characteristic != 0) {
            ++wrong_tubes;
            MESSAGE("tube ", k, ": components ", tube.check.components, ", Euler characteristic ",
                    tube.check.euler_characteristic, ", missed ", tube.report.missed.size());
        }
        const auto gap =
            mesh_and_check(one_solid([&](Model& m) {
                               return placed(m, unite(m, {add_box(m, {-6, -6, -6}, {6, 6, -0.15}),
                                                          add_box(m, {-6, -6, 0.15}, {6, 6, 6})}));
                           }),
                           options);
        CHECK(gap.defects == "");
        // Where a plane passes a vertex within 3e-4 of a cell, a refused split may leave a needle across.
        CHECK(gap.check.components == 2);
        if (gap.report.unresolved == 0 && gap.check.euler_characteristic != 4) {
            ++wrong_gaps;
            MESSAGE("gap ", k, ": components ", gap.check.components, ", non-manifold edges ",
                    gap.check.nonmanifold_edges, ", Euler characteristic ", gap.check.euler_characteristic,
                    ", missed ", gap.report.missed.size());
        }
    }
    CHECK(wrong_shells == 0);
    CHECK(wrong_tubes == 0);
    CHECK(wrong_gaps == 0);
}

namespace {

/// The frame with a rod that stands on its lower slab, its axis at (x, y), up to a height within a cell.
Model rod_at(double x, double y, double radius) {
    return beside_frame([&](Model& m) {
        return m.add_transform(translation({x, y, 0}), add_cylinder(m, radius, 9, 25.4));
    });
}

bool is_whole(const Meshed& m) { return m.check.components == 1 && m.check.euler_characteristic == 2; }

bool is_told(const Meshed& m) {
    bool lost = m.report.hinge_edges + m.report.hinge_nodes > 0;
    for (const MissedFeature& feature : m.report.missed) lost = lost || !feature.kept;
    return lost;
}

}  // namespace

TEST_CASE("a rod that holds an edge of the grid stays whole: its vertices do not snap away") {
    for (const double radius : {0.3, 0.45, 0.6, 0.8}) {
        for (const Vec3& off :
             {Vec3{0.0, 0.0, 0}, Vec3{0.2, 0.1, 0}, Vec3{-0.15, 0.17, 0}, Vec3{0.5, 0.0, 0}}) {
            if (std::hypot(off[0], off[1]) > radius - 0.02) continue;
            CAPTURE(radius);
            CAPTURE(off[0]);
            const Meshed result = mesh_valid(rod_at(20 + off[0], 20 + off[1], radius));
            CHECK(is_whole(result));
            CHECK(result.report.features.curves.size() > 0);
        }
    }
}

TEST_CASE("thin rods, wherever they stand, are whole or told of") {
    int whole = 0, told = 0;
    for (const double radius : {0.15, 0.3, 0.4, 0.5}) {
        for (const double x : {20.0, 20.15, 20.3, 20.5, 20.6}) {
            for (const double y : {20.0, 20.25, 20.4, 20.5}) {
                MeshOptions options;
                options.level = kProbedLevel;
                const Meshed result = mesh_and_check(rod_at(x, y, radius), options);
                CHECK(result.defects == "");
                CAPTURE(radius);
                CAPTURE(x);
                CAPTURE(y);
                CHECK((is_whole(result) || is_told(result)));
                whole += is_whole(result) ? 1 : 0;
                told += is_told(result) ? 1 : 0;
            }
        }
    }
    MESSAGE("80 rods of 0.3 to 1 cell: ", whole, " whole, ", told, " told of");
    CHECK(whole > 30);
}

}  // namespace mortise::test
