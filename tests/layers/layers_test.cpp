// Layers on meshes of models: valid, and the solid and its names as without them.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <doctest/doctest.h>

#include "host/common/vec3.hpp"
#include "mortise/error.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"

namespace mortise::test {
namespace {

MeshOptions with_layers(int level, int count, double first = 0, double growth = 1.2) {
    MeshOptions options;
    options.level = level;
    options.layers.count = count;
    options.layers.first = first;
    options.layers.growth = growth;
    return options;
}

MeshOptions without_layers(MeshOptions options) {
    options.layers = {};
    return options;
}

/// Area of the facets of each name.
std::map<std::string, double> areas(const Mesh& mesh) {
    std::map<std::string, double> area;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        std::array<Vec3, 4> p;
        for (std::size_t k = 0; k < 4; ++k) {
            const double* const at = mesh.points.data() + 3 * std::size_t{mesh.facets.nodes[4 * f + k]};
            p[k] = {at[0], at[1], at[2]};
        }
        area[mesh.surface_names[mesh.facets.surface[f]]] +=
            0.5 * length(cross(difference(p[2], p[0]), difference(p[3], p[1])));
    }
    return area;
}

/// A pipe cut by two planes and a cylinder across it.
const char* const kChannel =
    "algebraic3d\n"
    "solid inlet = plane (0,0,0; -1,0,0) -bcname=inlet;\n"
    "solid outlet = plane (4,0,0; 1,0,0.2) -bcname=outlet;\n"
    "solid pipe = cylinder(-1,0,0; 6,0,0; 1) -bcname=pipe;\n"
    "solid rod = cylinder(2,-5,0; 2,5,0; 0.3) -bcname=rod;\n"
    "solid fluid = pipe and inlet and outlet and not rod;\n"
    "tlo fluid;\n";

double depth_in_ball(const Mesh& mesh, NodeId node) {
    const double* const p = mesh.points.data() + 3 * std::size_t{node};
    return 1 - std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
}

}  // namespace

TEST_CASE("a ball: layers as high as asked, all around") {
    const Model model = one_solid([](Model& m) { return add_ball(m, {0, 0, 0}, 1); });
    const MeshOptions options = with_layers(5, 4, 0.005, 1.5);
    const Meshed bare = mesh_and_check(model, without_layers(options));
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects.empty());
    const LayerFigures& layers = meshed.report.layers;
    CHECK(layers.facets == bare.mesh.facets.size());
    CHECK(layers.lower + layers.bare == 0);
    CHECK(layers.elements == 4 * layers.facets);
    CHECK(meshed.check.volume == doctest::Approx(bare.check.volume).epsilon(1e-12));
    CHECK(worst(meshed) > 0.19);
    const ElementBlock& wedges = meshed.mesh.block(ElementType::kWedge);
    std::size_t seen = 0;
    for (std::size_t i = 0; i < wedges.size(); ++i) {
        if (wedges.kind[i] != static_cast<std::uint8_t>(ElementKind::kLayer)) continue;
        const NodeId* const node = wedges.nodes.data() + 6 * i;
        // From the wall inward, 4 wedges a facet.
        constexpr std::array<double, 5> kDepths = {0, 0.005, 0.0125, 0.02375, 0.040625};
        const std::size_t layer = seen++ % 4;
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(depth_in_ball(meshed.mesh, node[3 + k]) == doctest::Approx(kDepths[layer]).epsilon(0.02));
            CHECK(depth_in_ball(meshed.mesh, node[k]) == doctest::Approx(kDepths[layer + 1]).epsilon(0.02));
        }
    }
    CHECK(seen > 1000);
}

TEST_CASE("walls by name: an inlet without layers goes on to the wall") {
    const Model model = parse_model(kChannel, "geo", "channel.geo");
    MeshOptions options = with_layers(5, 3);
    const Meshed bare = mesh_and_check(model, without_layers(options));
    for (const bool tetrahedra : {false, true}) {
        options.tetrahedra = tetrahedra;
        options.layers.on = {"pipe", "rod"};
        const Meshed meshed = mesh_and_check(model, options);
        CHECK(meshed.defects.empty());
        CHECK(meshed.report.layers.bare == 0);
        // Nodes have come nearer to curved faces' middles, so areas may differ by facets, not by layers.
        const auto expected = areas(bare.mesh), found = areas(meshed.mesh);
        REQUIRE(expected.size() == 4);
        REQUIRE(found.size() == 4);
        for (const auto& [name, area] : expected) {
            CAPTURE(name);
            CHECK(found.at(name) == doctest::Approx(area).epsilon(tetrahedra ? 1e-2 : 1e-9));
        }
        CHECK(meshed.report.features.curves.size() == bare.report.features.curves.size());
        // Layers show on inlet and outlet.
        CHECK(meshed.mesh.facets.size() > bare.mesh.facets.size());
    }
    options.tetrahedra = false;
    options.layers.on = {"inlet"};
    const Meshed at_inlet = mesh_and_check(model, options);
    CHECK(at_inlet.defects.empty());
    CHECK(at_inlet.report.layers.bare == 0);
    const auto expected = areas(bare.mesh), found = areas(at_inlet.mesh);
    for (const auto& [name, area] : expected) CHECK(found.at(name) == doctest::Approx(area).epsilon(2e-3));
}

TEST_CASE("convex and concave creases, and tips") {
    const Model plate = one_solid([](Model& m) {
        return subtract(
            m, {unite(m, {add_box(m, {-2, -2, -0.4}, {2, 2, 0.5}), add_box(m, {-1, -1, 0}, {0.3, 1, 2})}),
                add_cylinder(m, 0.8, -1, 3)});
    });
    const Model star = one_solid([](Model& m) {
        return unite(m, {add_ball(m, {0, 0, 0}, 1), add_frustum(m, 0.9, 0, 0, 2.5)});
    });
    for (const Model* model : {&plate, &star}) {
        for (const double first : {0.0, 1e-4}) {
            const MeshOptions options = with_layers(5, 5, first, 1.3);
            const Meshed bare = mesh_and_check(*model, without_layers(options));
            const Meshed meshed = mesh_and_check(*model, options);
            CHECK(meshed.defects.empty());
            CHECK(meshed.check.volume == doctest::Approx(bare.check.volume).epsilon(1e-12));
            CHECK(meshed.check.boundary_area == doctest::Approx(bare.check.boundary_area).epsilon(1e-12));
            CHECK(meshed.check.euler_characteristic == bare.check.euler_characteristic);
            CHECK(meshed.report.layers.bare <= meshed.report.layers.facets / 50);
            if (first > 0 && model == &plate) CHECK(meshed.report.layers.lower == 0);
        }
    }
}

TEST_CASE("where a wall ends at a re-entrant edge, layers end too") {
    // Found with the area of each surface: the sides of the stacks stood in the fluid, as a crack.
    const char* const kSteps[] = {
        "difference(){ cube([4,2,2]); multmatrix([[1,0,0,-1],[0,1,0,-1],[0,0,1,-1],[0,0,0,1]]) "
        "cube([3,4,2]); }",
        "union(){ multmatrix([[0,0,1,0],[0,1,0,0],[-1,0,0,0],[0,0,0,1]]) cylinder(r1=1,r2=1,h=4,center=true);"
        " cylinder(r1=0.5,r2=0.5,h=3); }"};
    for (const char* const text : kSteps) {
        const Model model = parse_model(text, "csg", "step.csg");
        MeshOptions options = with_layers(5, 3, 0.02);
        const Meshed bare = mesh_and_check(model, without_layers(options));
        const auto expected = areas(bare.mesh);
        for (const std::string& name : bare.mesh.surface_names) {
            CAPTURE(name);
            options.layers.on = {name};
            const Meshed meshed = mesh_and_check(model, options);
            CHECK(meshed.defects.empty());
            CHECK(meshed.check.nonmanifold_edges == 0);
            CHECK(meshed.report.layers.elements > 0);
            const auto found = areas(meshed.mesh);
            for (const auto& [other, area] : expected)
                CHECK(found.at(other) == doctest::Approx(area).epsilon(3e-3));
        }
    }
}

TEST_CASE("layers in a region of tetrahedra, whichever is named first") {
    // The facets between have the region behind or in front of them.
    for (const char* const order : {"tlo a; tlo b;", "tlo b; tlo a;"}) {
        const Model model = parse_model(
            "algebraic3d\nsolid box = orthobrick(0,0,0;4,2,2);\n"
            "solid p = plane(0,0,1;0,0.1,1);\nsolid a = box and p;\n"
            "solid b = box and not p;\n" +
                std::string(order) + "\n",
            "geo", "two.geo");
        MeshOptions options = with_layers(4, 3, 0.01);
        options.layers.on = {"a"};
        const Meshed meshed = mesh_and_check(model, options);
        CHECK(meshed.defects.empty());
        CHECK(meshed.report.layers.bare == 0);
        CHECK(meshed.report.layers.lower == 0);
    }
}

TEST_CASE("a cut facet does not fold onto its neighbour") {
    // Two facets of the mesh share two edges: a triangle of the one would have three nodes of the other.
    const Model model = parse_model(
        "algebraic3d\n"
        "solid A0 = orthobrick(0,0,0; 4,2,2);\n"
        "solid c0 = sphere(1.9131060095594337,1.124043903940472,0.9191593617737066; 0.4335805902855404);\n"
        "solid c1 = orthobrick(3.042349992994145,1.5027532577692033,0.39315403094648604;"
        " 3.875151804192786,1.6423708067565395,0.6383716424966068);\n"
        "solid b = sphere(2.0870319383844027,-0.42780764646297265,0.6662545125406572; 0.7995064078789137);\n"
        "solid fluid = A0 and not b and not c0 and not c1;\n"
        "solid core = b and A0 and not c0 and not c1;\n"
        "tlo fluid;\ntlo core;\n",
        "geo", "thin.geo");
    MeshOptions options = with_layers(4, 2, 0, 1.9081429095762288);
    options.layers.on = {"fluid"};
    CHECK(mesh_and_check(model, options).defects.empty());
}

TEST_CASE("thin layers do not lean, but at creases") {
    const Model model = parse_model("cube([4,3,2]);", "csg", "box.csg");
    const Mesh mesh = generate(model, with_layers(5, 1, 0.002));
    const ElementBlock& block = mesh.block(ElementType::kHexahedron);
    double worst = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (block.kind[i] != static_cast<std::uint8_t>(ElementKind::kLayer)) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            const double* const inner = mesh.points.data() + 3 * std::size_t{block.nodes[8 * i + k]};
            const double* const outer = mesh.points.data() + 3 * std::size_t{block.nodes[8 * i + 4 + k]};
            const std::array<double, 6> depths = {outer[0],     4 - outer[0], outer[1],
                                                  3 - outer[1], outer[2],     2 - outer[2]};
            std::array<double, 6> sorted = depths;
            std::sort(sorted.begin(), sorted.end());
            if (sorted[1] < 0.25) continue;  // two cells from an edge
            const Vec3 lean = difference({inner[0], inner[1], inner[2]}, {outer[0], outer[1], outer[2]});
            worst = std::max(worst, length(lean) / 0.002);
        }
    }
    CHECK(worst > 0.99);
    CHECK(worst < 1.02);  // 11 degrees
}

TEST_CASE("much too high layers are as high as there is room, and told of") {
    const Model plate = parse_model("cube([4,4,0.1]);", "csg", "plate.csg");
    for (const double first : {0.0, 0.1, 10.0, 1e300}) {
        CAPTURE(first);
        const Meshed meshed = mesh_and_check(plate, with_layers(4, 3, first));
        CHECK(meshed.defects.empty());
        CHECK(meshed.report.layers.bare < meshed.report.layers.facets / 10);
        REQUIRE(!meshed.report.warnings.empty());
        CHECK(meshed.report.warnings.front().find(
                  "where elements behind them would be too flat: as asked they are") != std::string::npos);
    }
}

TEST_CASE("names without walls are told") {
    const Model model = parse_model(
        "algebraic3d\nsolid c = sphere(0,0,0;1) -bcname=core;\n"
        "solid b = orthobrick(-2,-2,-2;2,2,2) and not c;\ntlo c;\ntlo b;\n",
        "geo", "core.geo");
    MeshOptions options = with_layers(4, 2);
    options.layers.on = {"core"};
    MeshReport report;
    generate(model, options, &report);
    REQUIRE(report.warnings.size() == 1);
    CHECK(report.warnings.front().find("no layers on 'core'") != std::string::npos);
    options.layers.on = {"core", "b"};
    generate(model, options, &report);
    CHECK(report.layers.facets > 100);
    CHECK(report.layers.unused.empty());
}

TEST_CASE("layers too thin to tell their nodes apart are refused") {
    const Model model = one_solid([](Model& m) { return add_ball(m, {0, 0, 0}, 1); });
    for (const MeshOptions& options :
         {with_layers(3, 1, 1e-13), with_layers(3, 60, 0, 0.5), with_layers(3, 40, 0, 3)})
        CHECK_THROWS_WITH_AS(generate(model, options),
                             doctest::Contains("too little to tell its nodes apart"), Error);
    CHECK(mesh_and_check(model, with_layers(3, 1, 1e-8)).defects.empty());
}

TEST_CASE("random models with layers are valid") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 40);
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        const RandomModel random = make_random_model(seed);
        CAPTURE(seed);
        CAPTURE(random.style);
        MeshOptions options = with_layers(4, 1 + static_cast<int>(seed % 4), 0, seed % 2 == 0 ? 1.2 : 2);
        options.tetrahedra = seed % 3 == 0;
        options.refine = seed % 4 == 0 ? 1 : 0;
        options.improve = seed % 5 != 0;
        Mesh bare, mesh;
        try {
            bare = generate(random.model, without_layers(options));
            mesh = generate(random.model, options);
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);  // empty
            continue;
        }
        const CheckReport before = check_mesh(bare), after = check_mesh(mesh);
        for (const Defect& defect : after.defects) FAIL_CHECK(defect.what << ": " << defect.first);
        // A warped facet that is cut into two triangles bounds a little more or less; improvement leaves few.
        const double warped = options.improve ? 1e-6 : 1e-3;
        CHECK(after.boundary_area == doctest::Approx(before.boundary_area).epsilon(warped));
        CHECK(after.volume == doctest::Approx(before.volume).epsilon(warped));
        CHECK(after.nonmanifold_edges == before.nonmanifold_edges);
        CHECK(after.components == before.components);
    }
}

TEST_CASE("layers are the same bytes for any threads and pieces") {
    const Model model = one_solid([](Model& m) {
        return unite(m, {add_ball(m, {0, 0, 0}, 1), add_frustum(m, 0.9, 0, 0, 2.5),
                         add_box(m, {-1, -1, -2}, {0.2, 1, 0})});
    });
    MeshOptions options = with_layers(5, 3);
    MeshReport report;
    const Mesh whole = generate(model, options, &report);
    REQUIRE(report.layers.lower > 0);
    options.threads = 1;
    CHECK(is_same_mesh(whole, generate(model, options)));
    options.pieces = 5;
    CHECK(is_same_mesh(whole, generate(model, options)));
}

TEST_CASE("layers are refused where they cannot be") {
    const Model model = one_solid([](Model& m) { return add_ball(m, {0, 0, 0}, 1); });
    MeshOptions options = with_layers(3, 2);
    options.hanging = true;
    CHECK_THROWS_WITH_AS(generate(model, options),
                         doctest::Contains("layers need a mesh that conforms; leave one of the two out"),
                         Error);
    options.hanging = false;
    options.second_order = true;
    CHECK_THROWS_WITH_AS(generate(model, options),
                         doctest::Contains("layers are of first order; leave one of the two out"), Error);
    options.second_order = false;
    options.layers.on = {"wing"};
    CHECK_THROWS_WITH_AS(generate(model, options), doctest::Contains("no region or surface is called 'wing'"),
                         Error);
    options = with_layers(3, 101);
    CHECK_THROWS_WITH_AS(generate(model, options),
                         "count of layers (--layers) 101 is out of range; use 0 to 100", Error);
    options = with_layers(3, 2, -1);
    CHECK_THROWS_AS(generate(model, options), Error);
    options = with_layers(3, 2, 0, 5);
    CHECK_THROWS_WITH_AS(generate(model, options),
                         "growth of layers (--layer-growth) 5 is out of range; use 0.5 to 3", Error);
    const Model periodic = parse_model(
        "algebraic3d\n"
        "solid p = plane(0,0,0; -1,0,0); solid q = plane(1,0,0; 1,0,0);\n"
        "solid a = orthobrick(-1,0,0; 2,1,1) and p and q;\ntlo a;\nidentify periodic p q;\n",
        "geo", "periodic.geo");
    CHECK_THROWS_WITH_AS(generate(periodic, with_layers(3, 2)), doctest::Contains("periodic planes"), Error);
}

}  // namespace mortise::test
