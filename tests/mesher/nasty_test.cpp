// Special positions by name: what breaks meshers.
//
// `kUnit` blocks are laid out so that whole coordinates are planes of the grid at level 5: the root box has
// one cell of margin on each side of the longest extent.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "tests/mesher/membership_scan.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr int kNastyLevel = 5;

NodeIndex grid_block(Model& m) { return add_box(m, {0, 0, 0}, {30, 30, 30}); }

/// Valid, and no sample further than half a cell from the model's boundary is wrong.
Meshed mesh_soundly(const Model& model) {
    const Meshed result = mesh_and_check(model, kNastyLevel);
    CHECK(result.defects == "");
    const ScanResult scan =
        scan_membership(model, result.mesh, result.report.root, result.report.cell_size, 32);
    CAPTURE(scan.first_far);
    CHECK(scan.wrong_far == 0);
    return result;
}

std::string refusal_of(const Model& model) {
    try {
        generate_mesh(model);
    } catch (const Error& error) {
        return std::to_string(static_cast<int>(error.code())) + " " + error.what();
    }
    return "no error";
}

/// The part of the box [-1, 1]³ where a formula is not positive.
Meshed mesh_formula(const std::string& formula, int level = kNastyLevel) {
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = formula;
    const Meshed result = mesh_and_check(
        one_solid([&](Model& m) {
            return intersect(m, {m.add_primitive(primitive), add_box(m, {-1, -1, -1}, {1, 1, 1})});
        }),
        level);
    CHECK(result.defects == "");
    return result;
}

}  // namespace

TEST_CASE("faces on grid planes and next to them") {
    for (const double off : {0.0, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3}) {
        CAPTURE(off);
        const Meshed result = mesh_soundly(one_solid([&](Model& m) {
            return subtract(m, {grid_block(m), add_box(m, {5 + off, 5, 5}, {10 + off, 10 + off, 10}),
                                add_box(m, {20 - off, 20, 20 + off}, {31, 31, 31})});
        }));
        const double expected = 27000 - 125 * (1 + off / 5) - (10 + off) * 10 * (10 - off);
        CHECK(result.check.volume == doctest::Approx(expected).epsilon(1e-6));
        CHECK(result.check.euler_characteristic == 4);
    }
}

TEST_CASE("coplanar faces of a difference leave nothing behind") {
    const Affine turn = rotation({1, 2, 3}, 0.7);
    for (const Affine& map : {kIdentity, turn}) {
        const Meshed slab = mesh_soundly(one_solid([&](Model& m) {
            const NodeIndex a = m.add_transform(map, add_box(m, {0, 0, 0}, {3, 3, 3}));
            return subtract(m, {a, m.add_transform(map, add_box(m, {0, 0, 1}, {3, 3, 3}))});
        }));
        CHECK(slab.check.volume == doctest::Approx(9).epsilon(1e-6));
        CHECK(slab.check.components == 1);
        CHECK(refusal_of(one_solid([&](Model& m) {
                  const NodeIndex a = m.add_transform(map, add_box(m, {0, 0, 0}, {3, 3, 3}));
                  return subtract(m, {a, m.add_transform(map, add_box(m, {0, 0, 0}, {3, 3, 3}))});
              })).substr(0, 2) == "2 ");
    }
}

TEST_CASE("the tip of a cone, narrower than a cell, hangs on more than a node") {
    // Side and height of a box, diameter and height of the cone on it.
    const double parts[][4] = {{17.8, 11.4, 8, 7.4},  {10.2, 6.2, 3.9, 11.3}, {12.2, 4.7, 4.3, 8.8},
                               {22, 12.6, 3.4, 11.6}, {11.4, 7.4, 5.3, 11.3}, {15.1, 13.2, 6.3, 6.5},
                               {19.5, 11.9, 3.9, 7.5}};
    for (const auto& [side, low, diameter, high] : parts) {
        CAPTURE(side);
        const std::string text = "cube(size = [" + std::to_string(side) + ", " + std::to_string(side) + ", " +
                                 std::to_string(low) + "]); multmatrix([[1,0,0," + std::to_string(side / 2) +
                                 "],[0,1,0," + std::to_string(side / 2) + "],[0,0,1," + std::to_string(low) +
                                 "],[0,0,0,1]]) { cylinder(h = " + std::to_string(high) +
                                 ", r1 = " + std::to_string(diameter / 2) + ", r2 = 0); }";
        const Meshed result = mesh_and_check(parse_model(text, "csg", "cone.csg"), 5);
        CHECK(result.defects == "");
        CHECK(result.check.components == 1);
        CHECK(result.check.euler_characteristic == 2);
    }
}

TEST_CASE("tangent surfaces") {
    const Affine across = rotation({1, 0, 0}, kPi / 2);
    SUBCASE("ball on a plane") {
        const Meshed result = mesh_soundly(one_solid([](Model& m) {
            return unite(m, {add_box(m, {-12, -12, -12}, {12, 12, 0}), add_ball(m, {0.3, 0.2, 6}, 6)});
        }));
        CHECK(result.check.volume == doctest::Approx(24 * 24 * 12 + 288 * kPi).epsilon(0.01));
    }
    SUBCASE("ball touching the top of a block from inside, as a void") {
        mesh_soundly(one_solid([](Model& m) {
            return subtract(m, {add_box(m, {-12, -12, -12}, {12, 12, 0}), add_ball(m, {0.3, 0.2, -5}, 5)});
        }));
    }
    SUBCASE("parallel cylinders touching along a line") {
        mesh_soundly(one_solid([](Model& m) {
            return unite(m, {add_cylinder(m, 4, -10, 10),
                             m.add_transform(translation({7, 0, 0}), add_cylinder(m, 3, -10, 10))});
        }));
    }
    SUBCASE("crossing cylinders of one radius") {
        mesh_soundly(one_solid([&](Model& m) {
            return unite(m,
                         {add_cylinder(m, 4, -12, 12), m.add_transform(across, add_cylinder(m, 4, -12, 12))});
        }));
    }
    SUBCASE("Steinmetz solid") {
        const Meshed result = mesh_soundly(one_solid([&](Model& m) {
            const NodeIndex one = m.add_primitive(infinite_cylinder(1));
            return intersect(m, {one, m.add_transform(across, one)});
        }));
        CHECK(result.check.volume == doctest::Approx(16.0 / 3).epsilon(0.01));
        CHECK(result.check.euler_characteristic == 2);
    }
    SUBCASE("spindle torus") {
        mesh_soundly(one_solid([](Model& m) { return add_torus(m, 2, 5); }));
    }
}

TEST_CASE("many planes through one point, and apexes at and near grid vertices") {
    for (const double off : {0.0, 1e-9, 1e-4, 0.3}) {
        CAPTURE(off);
        const Meshed pyramid = mesh_soundly(one_solid([&](Model& m) {
            Primitive convex = box({0, 0, 0}, {30, 30, 15 + off});
            for (int i = 0; i < 8; ++i) {
                const Vec3 normal = {std::cos(i * kPi / 4), std::sin(i * kPi / 4), 1};
                convex.planes.push_back({normal, normal[0] * 15 + normal[1] * 15 + 15 + off, ""});
            }
            return m.add_primitive(convex);
        }));
        const double height = 15 + off;
        // A regular octagon of inradius r has area 8 tan(π/8) r²; the box cuts off what lies beyond 15.
        if (off == 0) {
            const double volume = 8 * std::tan(kPi / 8) * height * height * height / 3;
            CHECK(pyramid.check.volume == doctest::Approx(volume).epsilon(1e-6));
        }
        mesh_soundly(one_solid([&](Model& m) {
            const NodeIndex cone =
                m.add_transform(translation({15 + off, 15, 15}), add_frustum(m, 6, 0, -6, 0));
            return subtract(m, {grid_block(m), cone});
        }));
    }
}

TEST_CASE("dihedrals of one degree, added and removed") {
    const double slope = std::tan(kPi / 180);
    const auto blade = [&](Model& m) {
        Primitive convex = box({0, 0, 10}, {30, 30, 29});
        convex.planes.push_back({{-slope, 0, 1}, 10, ""});
        return m.add_primitive(convex);
    };
    const double volume = 0.5 * 30 * 30 * slope * 30;
    CHECK(mesh_soundly(one_solid(blade)).check.volume == doctest::Approx(volume).epsilon(1e-5));
    const Meshed rest = mesh_soundly(one_solid([&](Model& m) {
        return subtract(m, {grid_block(m), blade(m)});
    }));
    CHECK(rest.check.volume == doctest::Approx(27000 - volume).epsilon(1e-6));
}

TEST_CASE("plates and gaps far thinner than a cell") {
    for (const Affine& map : {kIdentity, rotation({1, 2, 3}, 0.7)}) {
        for (const double wall : {0.3, 0.01}) {
            CAPTURE(wall);
            const Meshed plate = mesh_soundly(one_solid([&](Model& m) {
                return m.add_transform(map, add_box(m, {0, 0, 7.4}, {30, 30, 7.4 + wall}));
            }));
            CHECK(plate.check.volume == doctest::Approx(900 * wall).epsilon(1e-5));
            CHECK(plate.check.components == 1);
            const Meshed gap = mesh_soundly(one_solid([&](Model& m) {
                return m.add_transform(
                    map, subtract(m, {grid_block(m), add_box(m, {-1, -1, 7.4}, {31, 31, 7.4 + wall})}));
            }));
            CHECK(gap.check.volume == doctest::Approx(27000 - 900 * wall).epsilon(1e-6));
            CHECK(gap.check.components == 2);
        }
    }
}

TEST_CASE("features of one surface smaller than a cell") {
    const auto drilled = [](const Vec3& at, double radius) {
        return one_solid([=](Model& m) { return subtract(m, {grid_block(m), add_ball(m, at, radius)}); });
    };
    mesh_soundly(drilled({10.5, 10.5, 10.5}, 0.3));
    mesh_soundly(drilled({10.5, 10.5, 10.9}, 0.3));
    mesh_soundly(drilled({10, 10.5, 10.9}, 0.3));
    mesh_soundly(drilled({15, 15, 30}, 0.3));
    mesh_soundly(one_solid([](Model& m) {
        const NodeIndex needle = m.add_transform(translation({10.5, 10.5, 0}), add_cylinder(m, 0.3, -1, 31));
        return subtract(m, {grid_block(m), needle});
    }));
}

TEST_CASE("saddles, corners and waves of formulas") {
    // Odd under a symmetry of the box: half of its volume.
    CHECK(mesh_formula("z - x*y").check.volume == doctest::Approx(4).epsilon(0.01));
    CHECK(mesh_formula("x*y*z").check.volume == doctest::Approx(4).epsilon(0.01));
    CHECK(mesh_formula("z - 0.2*sin(9*x)*sin(9*y)").check.volume == doctest::Approx(4).epsilon(0.02));
    // ∫∫ (sqrt|x| + 0.5) dx dy over the box, up to z = 1: z <= sqrt|x| - 0.5.
    CHECK(mesh_formula("z - sqrt(abs(x)) + 0.5").check.volume ==
          doctest::Approx(2 * (2 * 2.0 / 3 + 2 * 0.5)).epsilon(0.01));
    mesh_formula("sin(40*x)*sin(37*y) - z", 4);
}

TEST_CASE("where a formula is no number is outside") {
    // The edge of the domain is no root that could be found: it is met to within a cell.
    const Meshed result = mesh_formula("sqrt(x) - 0.5");
    CHECK(std::fabs(result.check.volume - 0.25 * 4) <= 4 * result.report.cell_size);
}

/// A prism on the triangle of three points, counter-clockwise, in the plane z = 0; the first and the last one
/// span its bounds.
Model prism(const std::array<Vec3, 3>& corner, double height) {
    return one_solid([&](Model& m) {
        Primitive solid = box({-5, -5, 0}, {20, 20, height});
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& a = corner[i];
            const Vec3& b = corner[(i + 1) % 3];
            const Vec3 normal = {b[1] - a[1], a[0] - b[0], 0};
            solid.planes.push_back({normal, normal[0] * a[0] + normal[1] * a[1], ""});
        }
        const NodeIndex node = m.add_primitive(solid);
        m.nodes[node].bounds = Box3{{corner[0][0], corner[0][1], 0}, {corner[2][0], corner[2][1], height}};
        return node;
    });
}

TEST_CASE("acute wedges whose edges lie in faces of cells keep every feature") {
    // At level 6 the edge of the first one lies in a plane of the grid, and ends between two vertices.
    struct Wedge {
        std::array<Vec3, 3> corner;
        double height, area;
    };
    for (const Wedge& wedge : {Wedge{{{{0, 0, 0}, {10, 0, 0}, {10, 5.7735, 0}}}, 4, 28.8675},
                               Wedge{{{{0, 0, 0}, {10.1, 2.5, 0}, {11.1, 8.9, 0}}}, 4.1, 31.07}}) {
        for (const int level : {5, 6, 7}) {
            CAPTURE(level);
            MeshOptions options;
            options.level = level;
            options.strict = true;
            const Meshed result = mesh_and_check(prism(wedge.corner, wedge.height), options);
            CHECK(result.defects == "");
            CHECK(result.report.warnings.empty());
            CHECK(result.check.volume == doctest::Approx(wedge.area * wedge.height).epsilon(1e-6));
            CHECK(result.report.features.corners.size() == 6);
        }
    }
}

TEST_CASE("far from the origin") {
    const Model model =
        transformed(one_solid([](Model& m) {
                        return subtract(m, {add_box(m, {0, 0, 0}, {3, 3, 3}), add_ball(m, {3, 3, 3}, 1.5)});
                    }),
                    translation({1e6, -1e6, 1e6}));
    const Meshed result = mesh_soundly(model);
    CHECK(result.check.volume == doctest::Approx(27 - kPi / 6 * 3.375).epsilon(0.01));
}

TEST_CASE("a thousand surfaces in one cell") {
    const Model model = one_solid([](Model& m) {
        Primitive convex = box({0, 0, 0}, {30, 30, 2});
        for (int i = 0; i < 1000; ++i) {
            const Vec3 normal = {std::cos(i * kPi / 2000), std::sin(i * kPi / 2000), 0};
            convex.planes.push_back({normal, 10.5 * (normal[0] + normal[1]) + 0.3, ""});
        }
        return m.add_primitive(convex);
    });
    const Meshed result = mesh_and_check(model, 4);
    CHECK(result.defects == "");
    // A square with one rounded corner, all of whose planes lie in one column of cells. Such cells show only
    // where they are in and out along edges; the report must say so.
    const double volume = 2 * (10.8 * 10.8 - 0.09 * (1 - kPi / 4));
    const double cell = result.report.cell_size;
    CHECK(std::fabs(result.check.volume - volume) <= 2 * 0.35 * cell * cell);
    CHECK((result.report.dropped_features == 0) == result.report.warnings.empty());
    REQUIRE(result.report.first_dropped.has_value() == (result.report.dropped_features > 0));
    if (result.report.first_dropped) {
        // Planes of the rounding pass through cells along both sides that meet in it.
        const Vec3& at = *result.report.first_dropped;
        CHECK(std::fabs(std::max(at[0], at[1]) - 10.8) < 2 * cell);
        CHECK(std::fabs(at[2] - 1) < 2 * cell);
    }
    if (std::fabs(result.check.volume / volume - 1) > 1e-4) CHECK(result.report.dropped_features > 0);
}

TEST_CASE("empty and unbounded solids are refused") {
    CHECK(refusal_of(one_solid([](Model& m) { return unite(m, {}); })).substr(0, 2) == "2 ");
    CHECK(refusal_of(one_solid([](Model& m) { return intersect(m, {}); })).substr(0, 2) == "2 ");
    CHECK(refusal_of(one_solid([](Model& m) {
              return intersect(m, {add_ball(m, {0, 0, 0}, 1), add_ball(m, {3, 0, 0}, 1)});
          })).substr(0, 2) == "2 ");
    CHECK(refusal_of(one_solid([](Model& m) {
              return m.add_primitive(half_space({0, 0, 0}, {0, 0, 1}));
          })).substr(0, 2) == "2 ");
}

TEST_CASE("faces that pass just beside the centres of cells make no slivers") {
    // An angle with a hole: along y the faces lie 1e-4 of a cell beside the middle planes of cells.
    const Model model = one_solid([](Model& m) {
        const NodeIndex angle = unite(m, {add_box(m, {0, 0, 0}, {2.0964, 1.6073, 0.4535}),
                                          add_box(m, {0, 0, 0}, {0.4535, 1.6073, 1.4675})});
        const NodeIndex hole =
            m.add_transform(translation({1.4675, 0.8037, 0}), add_cylinder(m, 0.4632, -1, 2));
        return subtract(m, {angle, hole});
    });
    const Meshed meshed = mesh_and_check(model, 5);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.refused_splits == 0);
    CHECK(meshed.report.unresolved == 0);
    CHECK(meshed.check.min_scaled_jacobian[3] > 0.15);
    const double volume =
        1.6073 * (2.0964 * 0.4535 + 0.4535 * (1.4675 - 0.4535)) - kPi * 0.4632 * 0.4632 * 0.4535;
    CHECK(meshed.check.volume == doctest::Approx(volume).epsilon(1e-3));
}

TEST_CASE("three surfaces through one curve make no slivers") {
    const auto worst = [](const Meshed& meshed) {
        double result = 1;
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            if (meshed.check.elements[t] > 0) result = std::min(result, meshed.check.min_scaled_jacobian[t]);
        }
        return result;
    };
    // A frustum on a cylinder of the same radius, narrowing (a convex rim) and widening (a concave one): the
    // plane between them passes through the rim and is no face of the solid.
    for (const double top : {4.5, 11.0}) {
        CAPTURE(top);
        const Model model = one_solid([&](Model& m) {
            const NodeIndex frustum = m.add_transform(translation({0, 0, 1}), add_frustum(m, 8, top, 0, 4));
            return unite(m, {frustum, add_cylinder(m, 8, 0, 1)});
        });
        for (const int level : {5, 6}) {
            CAPTURE(level);
            const Meshed meshed = mesh_and_check(model, level);
            CHECK(meshed.defects == "");
            CHECK(worst(meshed) > 0.1);
            const double volume = kPi * (64 + 4.0 / 3 * (64 + top * top + 8 * top));
            CHECK(meshed.check.volume == doctest::Approx(volume).epsilon(0.004));
            CHECK(meshed.check.euler_characteristic == 2);
        }
    }
    // Three planes through one line, turned so that none lies on the grid: a roof on a box with a plane
    // between.
    const Model roof = one_solid([](Model& m) {
        const NodeIndex box = add_box(m, {-3, -2, -2}, {3, 2, 0});
        const NodeIndex above = m.add_primitive(half_space({0, 0, 0}, {0, 0, -1}));
        const NodeIndex left = m.add_primitive(half_space({0, -2, 0}, {0, -1, 1}));
        const NodeIndex right = m.add_primitive(half_space({0, 2, 0}, {0, 1, 1}));
        const NodeIndex ends = add_box(m, {-3, -9, -9}, {3, 9, 9});
        const NodeIndex both = unite(m, {box, intersect(m, {above, left, right, ends})});
        return m.add_transform(rotation({0.3, 0.5, 0.8}, 0.7), both);
    });
    const Meshed meshed = mesh_and_check(roof, 5);
    CHECK(meshed.defects == "");
    CHECK(meshed.check.volume == doctest::Approx(6 * 4 * 2 + 6 * 4).epsilon(1e-9));
    CHECK(worst(meshed) > 0.05);
}

// The plane and an edge of the grid meet where the torus touches the edge: the node there had the sign of the
// edge's ends for the torus, and four cells were told to hold features too fine.
TEST_CASE("a surface that touches an edge of the grid at a node of another one is on it") {
    const Model model = one_solid([](Model& m) {
        const NodeIndex ring = add_torus(m, 10, 2);
        return intersect(m, {ring, m.add_primitive(half_space({0, 0, 0}, {0, -1, 0}))});
    });
    const Meshed meshed = mesh_and_check(model, 5);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.dropped_features == 0);
    CHECK(meshed.check.volume == doctest::Approx(kPi * kPi * 10 * 4).epsilon(0.05));
    CHECK(meshed.check.euler_characteristic == 2);
}

// To six figures, as OpenSCAD writes them, the cylinder misses the edge of the chamfer by 4e-5. What stays
// between them was no sliver to be merged: a wedge of 45 degrees counted as the rim of a thin plate.
TEST_CASE("a cylinder through the edge of a chamfer, but for rounding, leaves no sliver") {
    const Model model = one_solid([](Model& m) {
        Primitive foot = box({0, 0, 0}, {40, 40, 20});
        foot.planes.push_back({{1, 0, 1}, 40, ""});
        foot.planes.push_back({{0, 1, 1}, 40, ""});
        const Affine along = compose(translation({38.9393, 0, 1.06066}), rotation({1, 0, 0}, -kPi / 2));
        return unite(m, {m.add_primitive(foot), m.add_transform(along, add_cylinder(m, 1.5, 0, 30))});
    });
    const Meshed meshed = mesh_and_check(model, 5);
    CHECK(meshed.defects == "");
    CHECK(meshed.check.euler_characteristic == 2);
    CHECK(*std::min_element(meshed.check.min_scaled_jacobian.begin(),
                            meshed.check.min_scaled_jacobian.end()) > 0.15);
}

TEST_CASE("holes that are a little deeper than their plates leave no slivers") {
    // Some thousandths of a millimetre, so that the difference has no film. Where the bottom of the hole was
    // nearer to the centre of a cell than that of the plate, the cell's apex lay on it, below the plate.
    RandomSource random(7);
    for (int i = 0; i < 40; ++i) {
        const double deeper = std::pow(10, random.uniform(-4, -3));
        const Vec3 at = {random.uniform(6, 8), random.uniform(7.5, 9.5), 0};
        const double radius = random.uniform(2, 3);
        const Model model = one_solid([&](Model& m) {
            const NodeIndex hole = add_cylinder(m, radius, -deeper, 16 + deeper);
            return subtract(m, {add_box(m, {0, 0, 0}, {16, 18, 16}), m.add_transform(translation(at), hole)});
        });
        CAPTURE(deeper);
        CAPTURE(radius);
        const Meshed meshed = mesh_and_check(model, 4);
        CHECK(meshed.defects == "");
        CHECK(meshed.report.hinge_nodes + meshed.report.hinge_edges == 0);
        CHECK(*std::min_element(meshed.check.min_scaled_jacobian.begin(),
                                meshed.check.min_scaled_jacobian.end()) > 0.15);
    }
}

}  // namespace mortise::test
