// What each option of sizes does, on models whose answer is known.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "host/common/constants.hpp"
#include "tests/graded/parse_text.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"

namespace mortise::test {
namespace {

std::uint64_t leaves_at(const MeshReport& report, int level) {
    return static_cast<std::size_t>(level) < report.leaves.size()
               ? report.leaves[static_cast<std::size_t>(level)]
               : 0;
}

/// Longest edge of the elements with a node within `reach` of a point.
double longest_edge_near(const Mesh& mesh, const Vec3& at, double reach) {
    const auto point = [&](NodeId node) {
        return Vec3{mesh.points[3 * std::size_t{node}], mesh.points[3 * std::size_t{node} + 1],
                    mesh.points[3 * std::size_t{node} + 2]};
    };
    const auto distance = [](const Vec3& a, const Vec3& b) {
        return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                         (a[2] - b[2]) * (a[2] - b[2]));
    };
    double longest = 0;
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const auto& nodes = mesh.block(type).nodes;
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        for (std::size_t i = 0; i < nodes.size(); i += size) {
            bool near = false;
            for (std::size_t k = 0; k < size; ++k) near = near || distance(point(nodes[i + k]), at) < reach;
            if (!near) continue;
            const LocalFaces faces = local_faces(type);
            for (int f = 0; f < faces.count; ++f) {
                const LocalFace& face = faces.faces[f];
                const std::size_t corners = corner_count(face);
                for (std::size_t k = 0; k < corners; ++k) {
                    const auto a = static_cast<std::size_t>(face[k]);
                    const auto b = static_cast<std::size_t>(face[(k + 1) % corners]);
                    longest = std::max(longest, distance(point(nodes[i + a]), point(nodes[i + b])));
                }
            }
        }
    }
    return longest;
}

}  // namespace

TEST_CASE("a coarse interior leaves the boundary of the uniform mesh as it is") {
    const Model model = parse_text("sphere(r = 10);", "csg");
    MeshOptions options;
    options.level = 6;
    options.improve = false;
    const Meshed uniform = mesh_and_check(model, options);
    options.interior_coarsening = 4;
    const Meshed coarse = mesh_and_check(model, options);
    CHECK(coarse.defects == "");
    CHECK(coarse.mesh.facets.size() == uniform.mesh.facets.size());
    CHECK(coarse.check.boundary_area == doctest::Approx(uniform.check.boundary_area).epsilon(1e-12));
    CHECK(coarse.check.volume == doctest::Approx(uniform.check.volume).epsilon(1e-10));
    CHECK(coarse.check.min_scaled_jacobian[0] >= 0.8);
    CHECK(coarse.mesh.block(ElementType::kHexahedron).size() <
          uniform.mesh.block(ElementType::kHexahedron).size() / 4);
    // Nothing is larger than 2^4 cells, and neighbours differ by one level.
    CHECK(leaves_at(coarse.report, 1) == 0);
    CHECK(leaves_at(coarse.report, 6) > 0);
    CHECK(leaves_at(coarse.report, 5) > 0);
    CHECK(coarse.report.finest_level == 6);
}

TEST_CASE("a coin in an air box a thousand times larger") {
    const Model model = parse_text(R"(algebraic3d
solid coin = cylinder(0,0,-1;0,0,1;10) and plane(0,0,-0.5;0,0,-1) and plane(0,0,0.5;0,0,1) -maxh=2;
solid air = orthobrick(-10000,-10000,-10000;10000,10000,10000) and not coin;
tlo coin;
tlo air;
)",
                                   "geo");
    MeshOptions options;
    options.level = 4;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    REQUIRE(meshed.check.region_volume.size() == 2);
    CHECK(meshed.check.region_volume[0] == doctest::Approx(100 * kPi).epsilon(0.01));
    CHECK(meshed.check.region_volume[1] == doctest::Approx(8e12).epsilon(1e-9));
    // Its surface, once, between the two.
    CHECK(facet_area(meshed.mesh, 1, 2) == doctest::Approx(2 * kPi * 100 + 2 * kPi * 10).epsilon(0.01));
    CHECK(facet_area(meshed.mesh, 0, 1) == 0);
    CHECK(facet_area(meshed.mesh, 0, 2) == doctest::Approx(6 * 4e8).epsilon(1e-9));
    // A uniform mesh with these cells would have 2^(3 finest) of them.
    CHECK(std::ldexp(1.0, 3 * meshed.report.finest_level) / static_cast<double>(meshed.mesh.element_count()) >
          1e6);
}

TEST_CASE("refinement finds a coin in a box a thousand times larger by itself") {
    const Model model = parse_text(R"(algebraic3d
solid coin = cylinder(0,0,-1;0,0,1;10) and plane(0,0,-0.5;0,0,-1) and plane(0,0,0.5;0,0,1);
solid air = orthobrick(-10000,-10000,-10000;10000,10000,10000) and not coin;
tlo coin;
tlo air;
)",
                                   "geo");
    MeshOptions options;
    options.level = 3;
    options.refine = 13;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.finest_level >= 13);
    CHECK(meshed.report.transition_cells > 0);
    CHECK(meshed.mesh.element_count() < 200000);
    REQUIRE(meshed.check.region_volume.size() == 2);
    CHECK(meshed.check.region_volume[0] == doctest::Approx(100 * kPi).epsilon(0.03));
}

TEST_CASE("sizes around a point, at least and at most") {
    const Model model = parse_text("cube([10, 10, 10]);", "csg");
    MeshOptions options;
    options.level = 4;
    options.sizes.push_back({{0, 0, 0}, 0.1, 0.5});
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.check.volume == doctest::Approx(1000).epsilon(1e-9));
    // An edge across a cell's face is √2 of the cell, and one improvement may add a little.
    CHECK(longest_edge_near(meshed.mesh, {0, 0, 0}, 0.05) <= 0.1 * 1.8);
    CHECK(longest_edge_near(meshed.mesh, {10, 10, 10}, 0.05) > 0.3);

    options.size_min = 0.3;
    const Meshed limited = mesh_and_check(model, options);
    CHECK(std::ldexp(limited.report.cell_size, 4 - limited.report.finest_level) >= 0.3);
    CHECK(limited.mesh.element_count() < meshed.mesh.element_count());

    MeshOptions most;
    most.level = 3;
    most.size_max = 0.7;
    const Meshed small = mesh_and_check(model, most);
    CHECK(small.defects == "");
    CHECK(std::ldexp(small.report.cell_size, 3 - small.report.finest_level) <= 0.7);
    CHECK(leaves_at(small.report, small.report.finest_level) ==
          std::accumulate(small.report.leaves.begin(), small.report.leaves.end(), std::uint64_t{0}));
}

TEST_CASE("sizes of surfaces and regions by name, and by a formula") {
    const std::string text =
        "algebraic3d\n"
        "solid ball = sphere(0,0,0;1);\n"
        "solid box = orthobrick(-3,-3,-3;3,3,3) and not ball;\n"
        "tlo ball;\ntlo box;\n";
    const Model model = parse_text(text, "geo");
    MeshOptions options;
    options.level = 4;
    const Meshed plain = mesh_and_check(model, options);
    options.named_sizes = {{"ball", 0.1}};
    const Meshed named = mesh_and_check(model, options);
    CHECK(named.defects == "");
    CHECK(longest_edge_near(named.mesh, {0, 0, 0}, 0.9) <= 0.1 * 1.8);
    CHECK(longest_edge_near(named.mesh, {3, 3, 3}, 0.1) > 0.2);
    const double error = std::fabs(named.check.region_volume[0] - 4 * kPi / 3);
    CHECK(error < std::fabs(plain.check.region_volume[0] - 4 * kPi / 3) / 4);
    options.named_sizes = {{"bal", 0.1}};
    CHECK_THROWS_WITH_AS(generate(model, options), doctest::Contains("'bal'"), Error);

    MeshOptions formula;
    formula.level = 4;
    formula.size_formula = "0.11 + 0.5 * (x + 3)";
    const Meshed graded = mesh_and_check(model, formula);
    CHECK(graded.defects == "");
    CHECK(longest_edge_near(graded.mesh, {-3, -3, -3}, 0.05) <= 0.15 * 1.8);
    CHECK(longest_edge_near(graded.mesh, {3, 3, 3}, 0.05) > 0.3);
    formula.size_formula = "x";
    CHECK_THROWS_WITH_AS(generate(model, formula), doctest::Contains("size-min"), Error);
    formula.size_formula = "x +";
    CHECK_THROWS_AS(generate(model, formula), Error);
}

TEST_CASE("features: thin walls get small cells, plain creases and corners do not") {
    const Model thin = parse_text("union() { cube([10, 10, 0.2]); cube([10, 2, 10]); }", "csg");
    MeshOptions options;
    options.level = 4;
    options.refine = 3;
    const Meshed refined = mesh_and_check(thin, options);
    CHECK(refined.defects == "");
    CHECK(refined.check.volume == doctest::Approx(10 * 10 * 0.2 + 10 * 2 * 9.8).epsilon(1e-9));
    CHECK(refined.report.finest_level >= 6);
    CHECK(leaves_at(refined.report, 4) > 0);

    const Meshed cube = mesh_and_check(parse_text("cube([10, 10, 10]);", "csg"), options);
    CHECK(cube.report.finest_level == 4);
}

TEST_CASE("features: walls and gaps that a grid plane cuts are seen") {
    // A thin web in the middle of two end plates: the grid's middle plane runs through it.
    const Model web = parse_text(R"(union() {
        cube([40, 0.4, 40], center = true);
        multmatrix([[1,0,0,-20],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube([4, 40, 40], center = true); }
        multmatrix([[1,0,0,20],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube([4, 40, 40], center = true); }
    })",
                                 "csg");
    MeshOptions options;
    options.level = 4;
    options.refine = 4;
    const Meshed meshed = mesh_and_check(web, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.finest_level >= 6);
    CHECK(*std::min_element(meshed.check.min_scaled_jacobian.begin(),
                            meshed.check.min_scaled_jacobian.end()) > 0.15);
    // Two balls with a gap of a tenth of a cell between them.
    const Model balls = parse_text(R"(union() {
        sphere(r = 10);
        multmatrix([[1,0,0,20.3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { sphere(r = 10); }
    })",
                                   "csg");
    options.refine = 5;
    const Meshed gap = mesh_and_check(balls, options);
    CHECK(gap.defects == "");
    CHECK(gap.check.components == 2);
    CHECK(gap.report.finest_level >= 7);
    CHECK(leaves_at(gap.report, 4) > 0);
}

TEST_CASE("curvature: as many cells to a full turn as asked") {
    const Model model = parse_text("cylinder(r = 1, h = 10, $fn = 0);", "csg");
    MeshOptions options;
    options.level = 4;
    options.refine = 3;
    options.curvature_elements = 24;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(std::ldexp(meshed.report.cell_size, 4 - meshed.report.finest_level) <= 2 * kPi / 24 * 1.01);
}

TEST_CASE("a fitted box puts the faces of a model on grid planes") {
    const Model model = parse_text(R"(difference() {
        cube([12, 8, 5]);
        multmatrix([[1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 1, -1], [0, 0, 0, 1]]) { cube([4, 3, 7]); }
    })",
                                   "csg");
    MeshOptions options;
    options.level = 5;
    const Meshed plain = mesh_and_check(model, options);
    options.box_fit = true;
    const Meshed fitted = mesh_and_check(model, options);
    CHECK(fitted.defects == "");
    CHECK(fitted.check.volume == doctest::Approx(12 * 8 * 5 - 4 * 3 * 5).epsilon(1e-12));
    // All of it is hexahedra, cells being a divisor of a millimetre.
    CHECK(fitted.mesh.element_count() == fitted.mesh.block(ElementType::kHexahedron).size());
    CHECK(fitted.check.min_scaled_jacobian[0] == doctest::Approx(1));
    CHECK(plain.mesh.element_count() > plain.mesh.block(ElementType::kHexahedron).size());
}

/// Planes of boxes that lie on grid planes, or farther from these than vertices move, in a grid of such cells
/// from there.
int well_placed(const std::vector<double>& planes, double origin, double cell) {
    int count = 0;
    for (const double place : planes) {
        const double at = (place - origin) / cell;
        const double to_grid = std::fabs(at - std::round(at));
        if (to_grid < 1e-7 || to_grid > 0.3501) ++count;
    }
    return count;
}

TEST_CASE("the grid is shifted so that planes lie well in it, cells keep their size") {
    RandomSource random(7);
    int placed = 0, centred = 0, best = 0, all = 0;
    for (int i = 0; i < 10; ++i) {
        Model model;
        std::vector<std::uint32_t> boxes;
        std::array<std::vector<double>, 3> planes;
        Vec3 low = {9, 9, 9}, high = {-9, -9, -9};
        for (int n = 0; n < 3; ++n) {
            Vec3 a{}, b{};
            for (std::size_t j = 0; j < 3; ++j) {
                a[j] = random.uniform(-1, 0);
                b[j] = a[j] + random.uniform(1, 2);
                planes[j].insert(planes[j].end(), {a[j], b[j]});
                low[j] = std::min(low[j], a[j]);
                high[j] = std::max(high[j], b[j]);
            }
            boxes.push_back(model.add_primitive(box(a, b)));
        }
        model.regions.push_back({"boxes", model.add_operation(CsgNode::Op::kUnion, boxes), 0, {}});
        MeshOptions options;
        options.size = 0.11;
        const Meshed meshed = mesh_and_check(model, options);
        CHECK(meshed.defects == "");
        CHECK(meshed.report.cell_size == doctest::Approx(options.size));
        const Box3& root = meshed.report.root;
        for (std::size_t j = 0; j < 3; ++j) {
            CHECK(root.min[j] <= low[j] - 0.999 * options.size);
            CHECK(root.max[j] >= high[j] + 0.999 * options.size);
            const double middle = 0.5 * (low[j] + high[j] + root.min[j] - root.max[j]);
            const int here = well_placed(planes[j], root.min[j], options.size);
            const int there = well_placed(planes[j], middle, options.size);
            int most = there;
            for (int shift = 0; shift < 1000; ++shift)
                most = std::max(most,
                                well_placed(planes[j], middle + 1e-3 * shift * options.size, options.size));
            CHECK(here >= there);
            placed += here;
            centred += there;
            best += most;
            all += static_cast<int>(planes[j].size());
        }
    }
    MESSAGE("of ", all, " planes well in the grid: ", centred, " in the middle, ", placed, " shifted, ", best,
            " by search");
    CHECK(placed >= 0.9 * best);
    CHECK(placed >= 1.5 * centred);
}

// With both faces far from grid planes, all cells of a thin plate had two surfaces.
TEST_CASE("a plate thinner than a cell has one face on a grid plane") {
    for (const double thickness : {0.2, 0.25}) {
        CAPTURE(thickness);
        Model model;
        const std::uint32_t plate = model.add_primitive(box({0, 0, 0.77}, {9, 9, 0.77 + thickness}));
        model.regions.push_back({"plate", plate, 0, {}});
        MeshOptions options;
        options.size = 1;
        const Meshed meshed = mesh_and_check(model, options);
        CHECK(meshed.defects == "");
        const double below = 0.77 - meshed.report.root.min[2];
        const double above = below + thickness;
        CHECK(std::min(std::fabs(below - std::round(below)), std::fabs(above - std::round(above))) < 1e-6);
    }
}

TEST_CASE("a graded tetrahedral mesh and one with a report are valid, too") {
    const Model model = parse_text("difference() { cube([4, 4, 4]); sphere(r = 1.5); }", "csg");
    MeshOptions options;
    options.level = 4;
    options.sizes.push_back({{1.5, 0, 0}, 0.05, 0.4});
    options.interior_coarsening = 1;
    options.tetrahedra = true;
    options.quality = true;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.mesh.element_count() == meshed.mesh.block(ElementType::kTetrahedron).size());
    REQUIRE(meshed.report.quality.has_value());
}

TEST_CASE("scaled Jacobians of tetrahedra are those of their nodes, however far away small cells are") {
    Model model;
    const auto block = model.add_primitive(box({3000, 2000, 1000}, {3001, 2001, 1001}));
    Region region;
    region.name = "block";
    region.root = block;
    model.regions.push_back(region);
    MeshOptions options;
    options.level = 4;
    options.tetrahedra = true;
    options.sizes = {{{3000.5, 2000.5, 1000.5}, 1.0 / 1000, 1.5}};
    MeshReport report;
    const Mesh mesh = generate(model, options, &report);
    CHECK(report.leaves.size() > 4 + 4);
    CHECK(mesh.block(ElementType::kTetrahedron).kind.size() > 1000);
    CHECK(report.scaled_jacobians == scaled_jacobians(mesh));
}

}  // namespace mortise::test
