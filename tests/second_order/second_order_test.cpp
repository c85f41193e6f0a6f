// Meshes of second order: curved as the model, valid, and otherwise those of first order.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <doctest/doctest.h>

#include "host/common/constants.hpp"
#include "mortise/error.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"

namespace mortise::test {
namespace {

MeshOptions second_order(int level) {
    MeshOptions options;
    options.level = level;
    options.second_order = true;
    return options;
}

Model drilled_plate() {
    return one_solid([](Model& m) {
        return subtract(m, {add_box(m, {-2, -2, -0.4}, {2, 2, 0.5}), add_cylinder(m, 1, -1, 1)});
    });
}

Vec3 place(const Mesh& mesh, NodeId node) {
    const double* const p = mesh.points.data() + 3 * std::size_t{node};
    return {p[0], p[1], p[2]};
}

}  // namespace

TEST_CASE("volumes of round solids: thousands of times closer than with flat facets") {
    struct Case {
        const char* name;
        double volume;
        Model model;
    };
    const Case cases[] = {
        {"ball", 4 * kPi / 3, one_solid([](Model& m) {
             return add_ball(m, {0.1, 0.2, 0.3}, 1);
         })},
        {"torus", 2 * kPi * kPi * 2 * 0.5 * 0.5, one_solid([](Model& m) { return add_torus(m, 2, 0.5); })},
        {"drilled plate", 0.9 * (16 - kPi), drilled_plate()},
        {"cylinder", kPi * 2, one_solid([](Model& m) { return add_cylinder(m, 1, -1, 1); })},
        {"cone", kPi * 2 / 3, one_solid([](Model& m) { return add_frustum(m, 1, 0, 0, 2); })},
    };
    for (const Case& solid : cases) {
        CAPTURE(solid.name);
        for (const bool tetrahedra : {false, true}) {
            double error[2];
            for (const int order : {1, 2}) {
                MeshOptions options = second_order(5);
                options.second_order = order == 2;
                options.tetrahedra = tetrahedra;
                const Meshed meshed = mesh_and_check(solid.model, options);
                CHECK(meshed.defects.empty());
                error[order - 1] = std::fabs(meshed.check.volume / solid.volume - 1);
                CHECK(meshed.report.relaxed_edges <= 2);  // at the cone's apex
            }
            CHECK(error[0] > 2e-4);
            CHECK(error[1] < error[0] / 100);
            CHECK(error[1] < 1e-4);  // the torus; the others 2e-5
        }
    }
}

TEST_CASE("areas of round solids") {
    const Meshed ball = mesh_and_check(one_solid([](Model& m) {
                                           return add_ball(m, {0, 0, 0}, 1);
                                       }),
                                       second_order(4));
    CHECK(ball.check.boundary_area == doctest::Approx(4 * kPi).epsilon(1e-5));
}

TEST_CASE("nodes in the middles of edges on the model lie on it; those of creases on both surfaces") {
    const Meshed meshed = mesh_and_check(drilled_plate(), second_order(5));
    const Mesh& mesh = meshed.mesh;
    REQUIRE(meshed.defects.empty());
    const double largest = 1e-9;
    std::size_t on_cylinder = 0, rims = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const std::string& name = mesh.surface_names[mesh.facets.surface[f]];
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3 p = place(mesh, mesh.facets.middles[4 * f + k]);
            const bool is_round = std::fabs(std::hypot(p[0], p[1]) - 1) < largest;
            if (name.find("cylinder") != std::string::npos) {
                CHECK(is_round);
                ++on_cylinder;
            } else {
                CHECK(std::min({2 - std::fabs(p[0]), 2 - std::fabs(p[1]), std::fabs(p[2] + 0.4),
                                std::fabs(p[2] - 0.5)}) < largest);
            }
            if (mesh.model_dimension[mesh.facets.middles[4 * f + k]] != 1) continue;
            if (!is_round) continue;
            CHECK(std::min(std::fabs(p[2] + 0.4), std::fabs(p[2] - 0.5)) < largest);
            ++rims;
        }
    }
    CHECK(on_cylinder > 300);
    CHECK(rims > 100);
}

TEST_CASE("the corners are those of the mesh of first order, and middles come after them") {
    const Model model = drilled_plate();
    MeshOptions options = second_order(4);
    MeshReport report;
    const Mesh second = generate(model, options, &report);
    options.second_order = false;
    const Mesh first = generate(model, options);
    REQUIRE(second.is_second_order());
    REQUIRE_FALSE(first.is_second_order());
    Mesh corners = second;
    corners.points.resize(first.points.size());
    corners.facets.middles.clear();
    for (ElementBlock& block : corners.elements) block.middles.clear();
    CHECK(is_same_mesh(corners, first));
    CHECK(second.node_count() == first.node_count() + report.middle_nodes);
    CHECK(second.model_dimension.size() == second.node_count());
    // Numbered by the ends of their edges, the lower one first.
    std::map<NodeId, std::pair<NodeId, NodeId>> ends;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const LocalEdges local = local_edges(static_cast<ElementType>(t));
        const ElementBlock& block = second.elements[t];
        for (std::size_t i = 0; i < block.middles.size(); ++i) {
            const std::size_t edge = i % static_cast<std::size_t>(local.count);
            const NodeId* const node = block.nodes.data() + static_cast<std::size_t>(kElementNodes[t]) *
                                                                (i / static_cast<std::size_t>(local.count));
            const auto pair = std::minmax(node[local.edges[edge][0]], node[local.edges[edge][1]]);
            ends[block.middles[i]] = {pair.first, pair.second};
        }
    }
    CHECK(ends.size() == report.middle_nodes);
    std::pair<NodeId, NodeId> before = {0, 0};
    std::uint64_t curved = 0;
    for (const auto& [node, edge] : ends) {
        CHECK(node >= first.node_count());
        CHECK(before < edge);
        before = edge;
        const Vec3 a = place(second, edge.first), b = place(second, edge.second), m = place(second, node);
        curved += std::hypot(m[0] - 0.5 * (a[0] + b[0]), m[1] - 0.5 * (a[1] + b[1]),
                             m[2] - 0.5 * (a[2] + b[2])) > 1e-12;
    }
    CHECK(curved == report.curved_edges);
}

TEST_CASE("elements that would turn over have straighter edges") {
    // Balls and holes of one cell: facets span a sixth of a turn and more.
    const Model model = one_solid([](Model& m) {
        return subtract(m, {add_box(m, {-4, -4, -4}, {4, 4, 4}), add_ball(m, {0.4, 0.1, 0.3}, 0.8),
                            add_ball(m, {2.6, 2.2, 1.7}, 1.1), add_torus(m, 2.5, 0.45)});
    });
    std::uint64_t relaxed = 0;
    for (const int level : {3, 4}) {
        for (const bool tetrahedra : {false, true}) {
            MeshOptions options = second_order(level);
            options.tetrahedra = tetrahedra;
            const Meshed meshed = mesh_and_check(model, options);
            CHECK(meshed.defects.empty());
            CHECK(meshed.report.relaxed_edges < meshed.report.curved_edges);
            relaxed += meshed.report.relaxed_edges;
        }
    }
    CHECK(relaxed > 0);
}

TEST_CASE("random models of second order are valid") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 40);
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        const RandomModel random = make_random_model(seed);
        CAPTURE(seed);
        CAPTURE(random.style);
        MeshOptions options = second_order(4);
        options.tetrahedra = seed % 3 == 0;
        options.refine = seed % 4 == 0 ? 1 : 0;
        MeshReport report;
        Mesh mesh;
        try {
            mesh = generate(random.model, options, &report);
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);  // empty
            continue;
        }
        const CheckReport check = check_mesh(mesh);
        for (const Defect& defect : check.defects) FAIL_CHECK(defect.what << ": " << defect.first);
    }
}

TEST_CASE("the same bytes for any threads and parts") {
    const Model model = make_random_model(12).model;
    MeshOptions options = second_order(5);
    const Mesh whole = generate(model, options);
    REQUIRE(whole.is_second_order());
    options.threads = 1;
    CHECK(is_same_mesh(whole, generate(model, options)));
    options.pieces = 5;
    CHECK(is_same_mesh(whole, generate(model, options)));
}

TEST_CASE("second order is refused where it cannot be") {
    MeshOptions options = second_order(3);
    options.hanging = true;
    CHECK_THROWS_WITH_AS(
        generate(drilled_plate(), options),
        doctest::Contains("only elements of first order have hanging nodes; leave one of the two out"),
        Error);
}

}  // namespace mortise::test
