// What the benchmark's comparison at equal edge length rests on.
#include "bench/edges.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/io/folder.hpp"

namespace mortise::bench {
namespace {

/// A unit cube with a pyramid of height 1 on top: 12 edges of length 1, four of √(1/2 + 1).
Mesh house() {
    Mesh mesh;
    mesh.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 0.5, 0.5, 2};
    mesh.block(ElementType::kHexahedron).nodes = {0, 1, 2, 3, 4, 5, 6, 7};
    mesh.block(ElementType::kHexahedron).region = {1};
    mesh.block(ElementType::kPyramid).nodes = {4, 5, 6, 7, 8};
    mesh.block(ElementType::kPyramid).region = {1};
    return mesh;
}

TEST_CASE("each edge counts once, whoever shares it") {
    CHECK(mean_edge_length(house()) == doctest::Approx((12 + 4 * std::sqrt(1.5)) / 16));
}

TEST_CASE("the surface that TetGen gets has triangles only, and its own numbers") {
    Mesh mesh = house();
    mesh.facets.nodes = {0, 3, 2, 1, 4, 5, 8, 8};  // a quadrilateral and a triangle
    mesh.facets.surface = {0, 1};
    mesh.facets.inside = {1, 1};
    mesh.facets.outside = {0, 0};
    const Folder folder;
    const std::filesystem::path path = folder.path / "edges.smesh";
    write_surface(mesh, path.string());
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    CHECK(text.str() ==
          "7 3 0 0\n1 0 0 0\n2 0 1 0\n3 1 1 0\n4 1 0 0\n5 0 0 1\n6 1 0 1\n7 0.5 0.5 2\n"
          "3 0\n3 1 2 3\n3 1 3 4\n3 5 6 7\n0\n0\n");
}

}  // namespace
}  // namespace mortise::bench
