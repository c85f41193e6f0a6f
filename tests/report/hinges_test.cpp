// Where meshes hang together by edges or nodes, against the checker, which shares no code with it.
#include "host/features/hinges.hpp"

#include <doctest/doctest.h>

#include <random>

#include "mortise/check.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;

TEST_CASE("hinges: cubes that touch at an edge or a node") {
    const auto hinges_of = [](const Mesh& mesh) {
        return features::find_hinges(mesh.facets, mesh.node_count(), 2);
    };
    const features::Hinges none = hinges_of(samples::grid(3, 2, 2, 1));
    CHECK(!none.any());
    const features::Hinges edge =
        hinges_of(samples::grid(2, 2, 1, 1, [](int i, int j, int) { return i == j ? 1 : 0; }));
    CHECK(edge.edges == 1);
    CHECK(edge.nodes == 0);
    CHECK(edge.any());
    const Mesh corner =
        samples::grid(2, 2, 2, 1, [](int i, int j, int k) { return i == j && j == k ? 1 : 0; });
    const features::Hinges node = hinges_of(corner);
    CHECK(node.edges == 0);
    CHECK(node.nodes == 1);
    REQUIRE(node.first);
    CHECK(corner.points[3 * std::size_t{*node.first}] == 1);
    // A second region fills the gap: nothing hangs any more.
    CHECK(!hinges_of(samples::grid(2, 2, 1, 2, [](int i, int j, int) { return i == j ? 1 : 2; })).any());
}

TEST_CASE("hinges of random voxels, as the checker counts them") {
    std::mt19937 random(7);
    for (int round = 0; round < 60; ++round) {
        const unsigned filled = 20 + static_cast<unsigned>(round);  // percent
        std::vector<int> region(6 * 6 * 6);
        for (int& r : region) r = random() % 100 < filled ? 1 + static_cast<int>(random() % 2) : 0;
        const Mesh mesh = samples::grid(6, 6, 6, 2, [&](int i, int j, int k) {
            return region[static_cast<std::size_t>(i + 6 * (j + 6 * k))];
        });
        const CheckReport report = check_mesh(mesh);
        const features::Hinges hinges = features::find_hinges(mesh.facets, mesh.node_count(), 1 + round % 3);
        CHECK(hinges.edges == report.nonmanifold_edges);
        // The checker counts nodes whose fans are apart even where edges are crowded.
        CHECK(hinges.any() == (report.nonmanifold_edges + report.nonmanifold_nodes > 0));
        if (report.nonmanifold_edges == 0) CHECK(hinges.nodes == report.nonmanifold_nodes);
    }
}
