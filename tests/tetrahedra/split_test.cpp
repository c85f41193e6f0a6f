#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "host/tetrahedra/split.hpp"
#include "mortise/check.hpp"

using namespace mortise;

namespace {

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
    block.kind = {0};
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
        const Mesh split = tetrahedra::split(single(type, points, order));
        const CheckReport report = check_mesh(split);
        REQUIRE_MESSAGE(report.valid(), (report.defects.empty() ? "" : report.defects[0].what));
        REQUIRE(report.volume == doctest::Approx(volume).epsilon(1e-12));
        REQUIRE(split.node_count() == order.size());
    } while (std::next_permutation(order.begin(), order.end()));
}

}  // namespace

TEST_CASE("elements with plane faces split without new nodes, whatever their numbering") {
    check_all_numberings(ElementType::kHexahedron,
                         {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1}, 1);
    check_all_numberings(ElementType::kWedge, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1}, 0.5);
    check_all_numberings(ElementType::kPyramid, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 1}, 1.0 / 3);
}

TEST_CASE("a hexahedron with a curved face splits positively") {
    // The lid rises at one corner: no plane holds its four nodes.
    Mesh mesh = single(ElementType::kHexahedron,
                       {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0.05, 1, 0, 0.9, 1, 1, 0.05, 0, 1, 0.9},
                       {0, 1, 2, 3, 4, 5, 6, 7});
    CHECK(check_mesh(tetrahedra::split(mesh)).valid());
}
