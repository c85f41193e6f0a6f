// Hanging nodes: a large cube among small ones, whole and damaged.
#include <doctest/doctest.h>

#include "host/quality/face_pairs.hpp"
#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "mortise/hanging.hpp"
#include "tests/quality/hanging_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

std::uint64_t count_of(const Mesh& mesh, const std::string& what) {
    for (const Defect& defect : check_mesh(mesh).defects) {
        if (defect.what == what) return defect.count;
    }
    return 0;
}

constexpr const char* kMasters = "hanging node with unusable masters";

using Point = std::array<double, 3>;
Point normal_of(const Mesh& mesh, const std::array<NodeId, 4>& face) {
    const auto side = [&](std::size_t to, std::size_t j) {
        return mesh.points[3 * std::size_t{face[to]} + j] - mesh.points[3 * std::size_t{face[0]} + j];
    };
    return {side(1, 1) * side(3, 2) - side(1, 2) * side(3, 1),
            side(1, 2) * side(3, 0) - side(1, 0) * side(3, 2),
            side(1, 0) * side(3, 1) - side(1, 1) * side(3, 0)};
}

/// Index of a hanging node in the middle of a face.
std::size_t in_face(const Mesh& mesh) {
    std::size_t i = 0;
    while (mesh.hanging.in_edge(i)) ++i;
    return i;
}

}  // namespace

TEST_CASE("faces that meet four smaller ones are valid if their hanging nodes are listed") {
    const Mesh mesh = large_among_small();
    CHECK(mesh.hanging.size() == 18);
    const CheckReport report = check_mesh(mesh);
    CHECK(report.valid());
    CHECK(report.volume == doctest::Approx(64));
    CHECK(report.boundary_facets == 96);
    CHECK(report.euler_characteristic == 2);
    CHECK(report.components == 1);
    CHECK(report.parts == 1);
    CHECK(report.nonmanifold_edges == 0);
    CHECK(quality::faces_are_paired(mesh, 1));
    const Mesh column = large_among_small(3);
    CHECK(column.hanging.size() == 14 + 28);
    CHECK(check_mesh(column).valid());
    CHECK(quality::faces_are_paired(column, 1));
}

TEST_CASE("hanging faces run as seen from outside the larger hexahedron") {
    const Mesh mesh = large_among_small();
    const std::vector<HangingFace> faces = hanging_faces(mesh.hanging);
    REQUIRE(faces.size() == 6);
    for (const HangingFace& face : faces) {
        const Point whole = normal_of(mesh, face.whole);
        // The larger cube's middle is (2, 2, 2).
        double outward = 0;
        for (std::size_t j = 0; j < 3; ++j)
            outward += whole[j] * (mesh.points[3 * std::size_t{face.whole[0]} + j] - 2);
        CHECK(outward == doctest::Approx(4));
        for (std::size_t q = 0; q < 4; ++q) {
            CHECK(face.quarters[q][0] == face.whole[q]);
            for (std::size_t j = 0; j < 3; ++j)
                CHECK(normal_of(mesh, face.quarters[q])[j] == doctest::Approx(whole[j] / 4));
        }
    }
}

TEST_CASE("without its hanging nodes the mesh has cracks") {
    Mesh mesh = large_among_small();
    mesh.hanging = {};
    CHECK_FALSE(quality::faces_are_paired(mesh, 1));
    CHECK(count_of(mesh, "boundary facet missing from the list") == 6 * 5);
}

TEST_CASE("hanging nodes that cannot be") {
    Mesh mesh = large_among_small();
    std::vector<NodeId>& masters = mesh.hanging.masters;
    ElementBlock& cubes = mesh.block(ElementType::kHexahedron);
    const std::size_t face = in_face(mesh);
    SUBCASE("a side's middle is missing") {
        std::size_t i = 0;
        while (!mesh.hanging.in_edge(i)) ++i;
        const auto at = static_cast<std::ptrdiff_t>(i);
        mesh.hanging.node.erase(mesh.hanging.node.begin() + at);
        masters.erase(masters.begin() + 4 * at, masters.begin() + 4 * at + 4);
        CHECK_THROWS_AS(hanging_faces(mesh.hanging), Error);
        CHECK(count_of(mesh, kMasters) == 1);
    }
    SUBCASE("the larger hexahedron lies on the other side") {
        std::swap(masters[4 * face + 1], masters[4 * face + 3]);
        CHECK(count_of(mesh, "facet with the same orientation in both elements") == 5);
        CHECK_FALSE(quality::faces_are_paired(mesh, 1));
    }
    SUBCASE("a master hangs") {
        masters[4 * face] = mesh.hanging.node.back();
        CHECK(count_of(mesh, kMasters) == 1);
    }
    SUBCASE("a master twice") {
        masters[4 * face + 1] = masters[4 * face];
        CHECK(count_of(mesh, kMasters) == 1);
    }
    SUBCASE("out of order") {
        std::swap(mesh.hanging.node[0], mesh.hanging.node[1]);
        CHECK(count_of(mesh, kMasters) >= 1);
    }
    SUBCASE("no node of the mesh") {
        masters[1] = 1000;
        CHECK(count_of(mesh, kMasters) == 1);
    }
    SUBCASE("arrays of unequal length") {
        masters.pop_back();
        CHECK(count_of(mesh, "arrays of unequal length") == 1);
        CHECK_THROWS_AS(hanging_faces(mesh.hanging), Error);
    }
    SUBCASE("not in the middle") {
        mesh.points[3 * std::size_t{mesh.hanging.node[face]} + 1] += 0.001;
        CHECK(count_of(mesh, "hanging node that is not in the middle of its masters") == 1);
    }
    SUBCASE("the larger hexahedron is missing") {
        cubes.nodes.resize(cubes.nodes.size() - 8);
        cubes.region.pop_back();
        cubes.kind.pop_back();
        CHECK(count_of(mesh, "face with a hanging node that no element has") == 6);
    }
    SUBCASE("between two regions") {
        mesh.region_names.push_back("other");
        cubes.region.back() = 2;
        CHECK(count_of(mesh, "face with a hanging node between two regions") > 0);
    }
    SUBCASE("listed as a boundary") {
        const HangingFace listed = hanging_faces(mesh.hanging).front();
        mesh.facets.nodes.insert(mesh.facets.nodes.end(), listed.whole.begin(), listed.whole.end());
        mesh.facets.surface.push_back(0);
        mesh.facets.inside.push_back(1);
        mesh.facets.outside.push_back(0);
        CHECK(count_of(mesh, "listed facet between elements of one region") == 1);
    }
}
