#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "host/improve/quality.hpp"
#include "host/tetrahedra/split.hpp"
#include "mortise/check.hpp"

using namespace mortise;

namespace {

const std::vector<double> cube = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};

Mesh split_all(Mesh mesh, int threads) {
    return tetrahedra::split_cubes(tetrahedra::split_around_cubes(std::move(mesh), threads), threads);
}

/// One element of each type with the given numbering of its nodes, as a mesh with its own facets.
Mesh single(ElementType type, const std::vector<double>& points, const std::vector<NodeId>& order) {
    Mesh mesh;
    mesh.points.resize(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (std::size_t j = 0; j < 3; ++j) mesh.points[3 * order[i] + j] = points[3 * i + j];
    }
    ElementBlock& block = mesh.block(type);
    block.nodes = order;
    block.region = {1};
    block.kind = {static_cast<std::uint8_t>(ElementKind::kSnio)};  // no cube
    const LocalFaces faces = local_faces(type);
    for (int f = 0; f < faces.count; ++f) {
        const LocalFace& face = faces.faces[f];
        for (int k = 0; k < 4; ++k)
            mesh.facets.nodes.push_back(order[static_cast<std::size_t>(face[k] < 0 ? face[2] : face[k])]);
        mesh.facets.surface.push_back(0);
        mesh.facets.inside.push_back(1);
        mesh.facets.outside.push_back(0);
    }
    mesh.region_names = {"solid"};
    mesh.surface_names = {"skin"};
    return mesh;
}

void check_all_numberings(ElementType type, const std::vector<double>& points, double volume) {
    std::vector<NodeId> order(points.size() / 3);
    std::iota(order.begin(), order.end(), 0u);
    std::size_t count = 0;
    do {
        // All 40,320 numberings of a hexahedron are too many for a quick test: every 37th.
        if (order.size() == 8 && count++ % 37 != 0) continue;
        const Mesh split = split_all(single(type, points, order), 1);
        const CheckReport report = check_mesh(split);
        REQUIRE_MESSAGE(report.valid(), (report.defects.empty() ? "" : report.defects[0].what));
        REQUIRE(report.volume == doctest::Approx(volume).epsilon(1e-12));
        REQUIRE(split.node_count() == order.size());
    } while (std::next_permutation(order.begin(), order.end()));
}

}  // namespace

TEST_CASE("elements with plane faces split without new nodes, whatever their numbering") {
    check_all_numberings(ElementType::kHexahedron, cube, 1);
    check_all_numberings(ElementType::kWedge, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1}, 0.5);
    check_all_numberings(ElementType::kPyramid, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 1}, 1.0 / 3);
}

TEST_CASE("cubes split into good tetrahedra; those that are sixths around a diagonal are told of") {
    std::vector<NodeId> order(8);
    std::iota(order.begin(), order.end(), 0u);
    std::size_t alike = 0;
    do {
        Mesh mesh = single(ElementType::kHexahedron, cube, order);
        mesh.elements[0].kind = {static_cast<std::uint8_t>(ElementKind::kIn)};
        IndexRuns sixths;
        Mesh around = tetrahedra::split_around_cubes(std::move(mesh), 1);
        REQUIRE(around.elements[0].size() == 1);
        const Mesh split = tetrahedra::split_cubes(std::move(around), 1, {}, &sixths);
        const std::vector<NodeId>& nodes = split.block(ElementType::kTetrahedron).nodes;
        REQUIRE(nodes.size() == 24);
        for (std::size_t i = 0; i < nodes.size(); i += 4) {
            std::array<improve::Point, 4> p;
            for (std::size_t k = 0; k < 4; ++k)
                for (std::size_t j = 0; j < 3; ++j) p[k][j] = split.points[3 * nodes[i + k] + j];
            REQUIRE(improve::tetrahedron_quality(p[0], p[1], p[2], p[3]) > improve::kGoodQuality);
        }
        const std::vector<float> jacobians = scaled_jacobians(split);
        if (!sixths.empty()) {
            REQUIRE(sixths.size() == 1);
            REQUIRE(sixths[0].begin == 0);
            REQUIRE(sixths[0].end == 6);
            for (const float value : jacobians) REQUIRE(value == 0.408248290463863f);
            ++alike;
        }
        // As good as all divisions by the lowest node are: 1/√12 where a diagonal avoids the far corner.
        for (const float value : jacobians) REQUIRE(value > 0.2886f);
    } while (std::next_permutation(order.begin(), order.end()));
    CHECK(alike > 0);
    CHECK(alike < 40320);
}

TEST_CASE("cubes may be left for last, and their pieces come first, on any number of threads") {
    // A row of hexahedra, every third of them no cube; every ninth so curved that it is split from its
    // centre.
    Mesh mesh;
    ElementBlock& block = mesh.block(ElementType::kHexahedron);
    const std::vector<double> curved = {0, 0.4, -0.2, 1,   0, 0,   0.6, 0.6, 0.2, 0,   1,   0,
                                        0, 0,   1,    1.4, 0, 0.8, 1,   1,   1,   0.2, 0.8, 1};
    const std::size_t count = 20000;
    std::size_t cubes = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_cube = i % 3 != 0, is_curved = i % 9 == 0;
        const std::vector<double>& points = is_curved ? curved : cube;
        // Cubes are numbered along x, then y, then z, as those of the grid.
        std::array<NodeId, 8> number = {0, 1, 2, 3, 4, 5, 6, 7};
        if (is_cube) number = {0, 1, 3, 2, 4, 5, 7, 6};
        const auto first = static_cast<NodeId>(mesh.node_count());
        mesh.points.resize(mesh.points.size() + 24);
        for (std::size_t c = 0; c < 8; ++c) {
            block.nodes.push_back(first + number[c]);
            double* const point = &mesh.points[3 * std::size_t{block.nodes.back()}];
            for (std::size_t j = 0; j < 3; ++j)
                point[j] = points[3 * c + j] + (j == 0 ? 3 * static_cast<double>(i) : 0);
        }
        block.region.push_back(1);
        block.kind.push_back(static_cast<std::uint8_t>(is_cube ? ElementKind::kIn : ElementKind::kSnio));
        cubes += is_cube ? 1 : 0;
    }
    // Of the cubes, some that are followed: the first, and the last two of the row.
    const IndexRuns moved = {{1, 2}, {count - 3, count}};
    Mesh first;
    for (const int threads : {1, 2, 5}) {
        IndexRuns followed = moved, sixths;
        Mesh around = tetrahedra::split_around_cubes(mesh, threads, nullptr, &followed);
        CHECK(around.elements[0].size() == cubes);
        REQUIRE(followed.size() == 2);
        CHECK(followed[0].end == 1);
        CHECK(followed[1].begin == cubes - 2);
        CHECK(followed[1].end == cubes);
        const Mesh split = tetrahedra::split_cubes(std::move(around), threads, followed, &sixths);
        const ElementBlock& tetrahedra = split.block(ElementType::kTetrahedron);
        REQUIRE(sixths.size() == 1);  // all are numbered alike
        CHECK(sixths[0].begin == 6);
        CHECK(sixths[0].end == 6 * (cubes - 2));
        for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
            const bool is_piece = tetrahedra.kind[i] == static_cast<std::uint8_t>(ElementKind::kIn);
            REQUIRE(is_piece == (i < 6 * cubes));
        }
        CHECK(split.elements[0].size() == 0);
        CHECK(split.node_count() == mesh.node_count() + (count + 8) / 9);  // centres
        CHECK(tetrahedra.size() == 6 * count + 6 * ((count + 8) / 9));
        if (first.points.empty()) first = split;
        CHECK(first.block(ElementType::kTetrahedron).nodes == tetrahedra.nodes);
        CHECK(first.points == split.points);
    }
}

TEST_CASE("cubes whose nodes are ranked by others are not left for last") {
    Mesh mesh = single(ElementType::kHexahedron, cube, {0, 1, 2, 3, 4, 5, 6, 7});
    mesh.elements[0].kind = {static_cast<std::uint8_t>(ElementKind::kIn)};
    std::vector<NodeId> rank(8);
    std::iota(rank.begin(), rank.end(), 0u);
    CHECK(tetrahedra::split_around_cubes(mesh, 1, &rank).elements[0].size() == 1);
    rank[6] = 0;
    const Mesh split = tetrahedra::split_around_cubes(mesh, 1, &rank);
    CHECK(split.elements[0].size() == 0);
    CHECK(check_mesh(split).valid());
}

TEST_CASE("a hexahedron with a curved face splits positively") {
    // The lid rises at one corner: no plane holds its four nodes.
    Mesh mesh = single(ElementType::kHexahedron,
                       {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0.05, 1, 0, 0.9, 1, 1, 0.05, 0, 1, 0.9},
                       {0, 1, 2, 3, 4, 5, 6, 7});
    CHECK(check_mesh(split_all(mesh, 1)).valid());
}
