// Every kind of damage is seen, and under its own name.
#include <algorithm>
#include <array>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "host/quality/face_pairs.hpp"
#include "host/quality/jacobian.hpp"
#include "mortise/check.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

/// The defect of that name; count 0 if the mesh has none.
Defect find(const Mesh& mesh, const std::string& what) {
    for (const Defect& defect : check_mesh(mesh).defects) {
        if (defect.what == what) return defect;
    }
    return {what, 0, ""};
}

Mesh two_regions() {
    return grid(3, 3, 3, 2, [](int i, int, int) { return i < 2 ? 1 : 2; });
}

/// Index of the first listed facet with that outside region.
std::size_t facet_with_outside(const Mesh& mesh, int outside) {
    std::size_t i = 0;
    while (mesh.facets.outside.at(i) != outside) ++i;
    return i;
}

void remove_facet(Mesh& mesh, std::size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    mesh.facets.nodes.erase(mesh.facets.nodes.begin() + 4 * at, mesh.facets.nodes.begin() + 4 * at + 4);
    mesh.facets.surface.erase(mesh.facets.surface.begin() + at);
    mesh.facets.inside.erase(mesh.facets.inside.begin() + at);
    mesh.facets.outside.erase(mesh.facets.outside.begin() + at);
}

}  // namespace

TEST_CASE("the undamaged meshes are valid") {
    CHECK(check_mesh(two_regions()).valid());
    CHECK(check_mesh(mixed()).valid());
}

TEST_CASE("swapped nodes invert an element of any type") {
    const char* names[] = {"hexahedron", "wedge", "pyramid", "tetrahedron"};
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        CAPTURE(names[t]);
        Mesh mesh = mixed();
        std::swap(mesh.elements[t].nodes[0], mesh.elements[t].nodes[1]);
        const Defect defect = find(mesh, std::string(names[t]) + " with non-positive Jacobian");
        CHECK(defect.count == 1);
        CHECK(defect.first.find(std::string(names[t]) + " 0 at (") == 0);
    }
}

TEST_CASE("a mirrored element has its facets the same way round as its neighbour") {
    Mesh mesh = two_regions();
    std::vector<NodeId>& nodes = mesh.elements[0].nodes;
    for (std::size_t i = 0; i < 4; ++i) std::swap(nodes[8 * 13 + i], nodes[8 * 13 + i + 4]);
    CHECK(find(mesh, "hexahedron with non-positive Jacobian").count == 1);
    CHECK(find(mesh, "facet with the same orientation in both elements").count == 6);
}

TEST_CASE("a moved node that inverts its elements") {
    Mesh mesh = two_regions();
    mesh.points[0] += 1.5;
    const Defect defect = find(mesh, "hexahedron with non-positive Jacobian");
    CHECK(defect.count == 1);
    CHECK(defect.first.find("minimum Jacobian -") != std::string::npos);
}

TEST_CASE("flat and rounding-flat tetrahedra are defects") {
    for (const double height : {0.0, 1e-300, 1e-17, -1e-3}) {
        Mesh mesh = unit_element(ElementType::kTetrahedron);
        mesh.points = {0, 0, 0.1, 1, 0, 0.1, 0, 1, 0.1, 0.3, 0.3, 0.1 + height};
        CHECK(find(mesh, "tetrahedron with non-positive Jacobian").count == 1);
    }
    // Small and thin is no defect.
    Mesh mesh = unit_element(ElementType::kTetrahedron);
    for (double& x : mesh.points) x *= 1e-9;
    mesh.points[11] *= 1e-6;
    CHECK(check_mesh(mesh).valid());
}

TEST_CASE("a hexahedron inverted only in its interior, all corners well shaped") {
    Mesh mesh = unit_element(ElementType::kHexahedron);
    mesh.points = {-0.4, -0.2, -0.3, 1.9, -0.7, 0.8, 1.6, 1.2, 0.5, -0.7, 1.5, 0.6,
                   -0.5, -0.2, 0.8,  1.3, 0.9,  1.5, 1.5, 1.4, 0.7, -0.7, 0.3, 1.0};
    CHECK(scaled_jacobians(mesh)[0] > 0.5f);
    CHECK(find(mesh, "hexahedron with non-positive Jacobian").count == 1);
}

TEST_CASE("faces that do not fit together are seen by one sum") {
    for (const Mesh& whole : {mixed(), two_regions()}) {
        CHECK(quality::faces_are_paired(whole, 1));
        CHECK(quality::faces_are_paired(whole, 2));
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            if (whole.elements[t].size() == 0) continue;
            Mesh mesh = whole;
            std::swap(mesh.elements[t].nodes[0], mesh.elements[t].nodes[1]);  // a face the other way round
            CHECK_FALSE(quality::faces_are_paired(mesh, 1));
            mesh = whole;
            mesh.elements[t].nodes[0] = add_node(mesh, 0, 0, 0);  // a crack
            CHECK_FALSE(quality::faces_are_paired(mesh, 1));
            mesh = whole;
            const auto end = mesh.elements[t].nodes.begin() + kElementNodes[t];
            add_element(mesh, static_cast<ElementType>(t), {mesh.elements[t].nodes.begin(), end});
            CHECK_FALSE(quality::faces_are_paired(mesh, 1));
        }
        Mesh mesh = whole;
        remove_facet(mesh, facet_with_outside(mesh, 0));
        CHECK_FALSE(quality::faces_are_paired(mesh, 1));
        mesh = whole;
        // Two triangles in the place of a quadrilateral.
        std::size_t i = 0;
        while (mesh.facets.outside[i] != 0 || mesh.facets.nodes[4 * i + 2] == mesh.facets.nodes[4 * i + 3])
            ++i;
        const std::vector<NodeId> n(mesh.facets.nodes.begin() + 4 * static_cast<std::ptrdiff_t>(i),
                                    mesh.facets.nodes.begin() + 4 * static_cast<std::ptrdiff_t>(i) + 4);
        mesh.facets.nodes[4 * i + 3] = n[2];
        mesh.facets.nodes.insert(mesh.facets.nodes.end(), {n[0], n[2], n[3], n[3]});
        mesh.facets.surface.push_back(mesh.facets.surface[i]);
        mesh.facets.inside.push_back(mesh.facets.inside[i]);
        mesh.facets.outside.push_back(0);
        CHECK_FALSE(quality::faces_are_paired(mesh, 1));
    }
}

namespace {

/// Elements of all different nodes, in random order: neighbours' numbers, or from anywhere.
std::vector<NodeId> random_elements(std::size_t count, std::size_t nodes_each, bool anywhere,
                                    std::mt19937& random) {
    std::vector<NodeId> all;
    for (std::size_t i = 0; i < count; ++i) {
        std::vector<NodeId> nodes(nodes_each);
        for (NodeId k = 0; k < nodes_each; ++k) nodes[k] = anywhere ? k << 29 | random() >> 3 : ~k;
        std::shuffle(nodes.begin(), nodes.end(), random);
        all.insert(all.end(), nodes.begin(), nodes.end());
    }
    return all;
}

/// The faces of a type's elements as facets, each from any of its nodes.
FacetBlock facets_of(ElementType type, const std::vector<NodeId>& nodes, std::mt19937& random) {
    FacetBlock facets;
    const LocalFaces faces = local_faces(type);
    const auto each = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    for (std::size_t i = 0; i < nodes.size(); i += each) {
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            const std::size_t count = corner_count(face);
            const auto turn = random() % count;
            for (std::size_t k = 0; k < 4; ++k) {
                const std::size_t at = (std::min(k, count - 1) + turn) % count;
                facets.nodes.push_back(nodes[i + static_cast<std::size_t>(face[at])]);
            }
            facets.surface.push_back(0);
            facets.inside.push_back(1);
            facets.outside.push_back(0);
        }
    }
    return facets;
}

}  // namespace

TEST_CASE("faces of elements count the same as facets, whatever their nodes' numbers") {
    std::mt19937 random(11);
    for (const ElementType type : {ElementType::kHexahedron, ElementType::kTetrahedron}) {
        for (int round = 0; round < 2000; ++round) {
            Mesh mesh;
            ElementBlock& block = mesh.block(type);
            const auto count = static_cast<std::size_t>(round % 3 + 1);
            const auto each = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
            block.nodes = random_elements(count, each, round % 2 == 0, random);
            block.region.resize(count);
            block.kind.resize(count);
            const FacetBlock facets = facets_of(type, block.nodes, random);
            CHECK(quality::sum_of_faces(mesh, 1) == quality::sum_of_outer_facets(facets, 1));
        }
    }
}

TEST_CASE("duplicate element") {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        Mesh mesh = mixed();
        const std::vector<NodeId> nodes = mesh.elements[t].nodes;
        add_element(mesh, static_cast<ElementType>(t), nodes);
        CHECK(find(mesh, "duplicate element").count == 1);
    }
    Mesh mesh = two_regions();
    const std::vector<NodeId> inner(mesh.elements[0].nodes.begin() + 8 * 13,
                                    mesh.elements[0].nodes.begin() + 8 * 14);
    // The copy starts at another corner.
    add_element(mesh, ElementType::kHexahedron,
                {inner[1], inner[2], inner[3], inner[0], inner[5], inner[6], inner[7], inner[4]});
    add_element(mesh, ElementType::kHexahedron, inner);
    CHECK(find(mesh, "duplicate element").count == 2);
    CHECK(find(mesh, "facet shared by more than two elements").count == 6);
}

TEST_CASE("removed element: its neighbours' facets are missing from the list") {
    Mesh mesh = two_regions();
    ElementBlock& block = mesh.elements[0];
    block.nodes.erase(block.nodes.begin() + 8 * 12, block.nodes.begin() + 8 * 13);  // on the face x = 0
    block.region.erase(block.region.begin() + 12);
    block.kind.erase(block.kind.begin() + 12);
    CHECK(find(mesh, "boundary facet missing from the list").count == 5);
    CHECK(find(mesh, "listed facet that is no facet of an element").count == 1);
}

TEST_CASE("missing boundary and interface facets") {
    Mesh mesh = two_regions();
    remove_facet(mesh, facet_with_outside(mesh, 0));
    CHECK(find(mesh, "boundary facet missing from the list").count == 1);
    CHECK(find(mesh, "listed outer facets not closed").count == 4);
    mesh = two_regions();
    remove_facet(mesh, facet_with_outside(mesh, 2));
    CHECK(find(mesh, "interface facet missing from the list").count == 1);
    CHECK(find(mesh, "boundary facet missing from the list").count == 0);
}

TEST_CASE("facet listed twice, inside a region, or nowhere in the mesh") {
    Mesh mesh = two_regions();
    const auto repeat = [&mesh](const std::vector<NodeId>& nodes) {
        mesh.facets.nodes.insert(mesh.facets.nodes.end(), nodes.begin(), nodes.end());
        mesh.facets.surface.push_back(0);
        mesh.facets.inside.push_back(1);
        mesh.facets.outside.push_back(0);
    };
    const std::vector<NodeId> copy(mesh.facets.nodes.begin(), mesh.facets.nodes.begin() + 4);
    repeat(copy);
    CHECK(find(mesh, "facet listed twice").count == 1);
    mesh = two_regions();
    const std::vector<NodeId>& nodes = mesh.elements[0].nodes;
    repeat({nodes[1], nodes[2], nodes[6], nodes[5]});  // between hexahedra 0 and 1
    CHECK(find(mesh, "listed facet between elements of one region").count == 1);
    mesh = two_regions();
    repeat({0, 1, 40, 63});
    CHECK(find(mesh, "listed facet that is no facet of an element").count == 1);
}

TEST_CASE("listed facet with the wrong orientation") {
    for (const int outside : {0, 2}) {
        Mesh mesh = two_regions();
        const std::size_t i = facet_with_outside(mesh, outside);
        std::swap(mesh.facets.nodes[4 * i + 1], mesh.facets.nodes[4 * i + 3]);
        CHECK(find(mesh, "listed facet with the wrong orientation").count == 1);
        // Turned without being reversed: the same facet.
        mesh = two_regions();
        const auto first = mesh.facets.nodes.begin() + static_cast<std::ptrdiff_t>(4 * i);
        std::rotate(first, first + 1, first + 4);
        CHECK(check_mesh(mesh).valid());
    }
    // Both turned round and given from the other side: an interface may be listed either way.
    Mesh mesh = two_regions();
    const std::size_t i = facet_with_outside(mesh, 2);
    std::swap(mesh.facets.nodes[4 * i + 1], mesh.facets.nodes[4 * i + 3]);
    std::swap(mesh.facets.inside[i], mesh.facets.outside[i]);
    CHECK(check_mesh(mesh).valid());
}

TEST_CASE("wrong regions of facets and elements") {
    Mesh mesh = two_regions();
    mesh.facets.inside[facet_with_outside(mesh, 0)] = 2;
    CHECK(find(mesh, "listed facet with the wrong regions").count == 1);
    mesh = two_regions();
    mesh.facets.outside[facet_with_outside(mesh, 2)] = 0;
    CHECK(find(mesh, "listed facet with the wrong regions").count == 1);
    mesh = two_regions();
    mesh.elements[0].region[13] = 2;  // an inner element of region 1: five new interfaces, one less
    CHECK(find(mesh, "interface facet missing from the list").count == 5);
    CHECK(find(mesh, "listed facet between elements of one region").count == 1);
}

TEST_CASE("coincident nodes: equal and nearly equal") {
    const double eps = std::numeric_limits<double>::epsilon();
    for (const double distance : {0.0, 3 * eps, 5e-12}) {
        Mesh mesh = two_regions();
        const NodeId copy = add_node(mesh, 1 + distance, 1, 1);
        NodeId original = 0;
        const double* p = mesh.points.data();
        while (p[3 * original] != 1 || p[3 * original + 1] != 1 || p[3 * original + 2] != 1) ++original;
        std::replace(mesh.elements[0].nodes.begin() + 8 * 13, mesh.elements[0].nodes.begin() + 8 * 14,
                     original, copy);
        CHECK(find(mesh, "coincident nodes").count == 1);
        CHECK(find(mesh, "coincident nodes").first ==
              "nodes " + std::to_string(original) + " and 64 at (1, 1, 1)");
    }
    Mesh mesh = two_regions();
    add_node(mesh, 1 + 1e-11, 1, 1);
    CHECK(find(mesh, "coincident nodes").count == 0);
    CHECK(find(mesh, "unused node").count == 1);
}

TEST_CASE("many nodes in one place are counted without delay") {
    Mesh mesh = two_regions();
    for (int i = 0; i < 200000; ++i) add_node(mesh, 1, 1, 1);
    CHECK(find(mesh, "coincident nodes").count == 200000);
}

TEST_CASE("unused node, also when a listed facet uses it") {
    Mesh mesh = two_regions();
    const NodeId extra = add_node(mesh, 9, 9, 9);
    CHECK(find(mesh, "unused node").count == 1);
    CHECK(find(mesh, "unused node").first == "node 64 at (9, 9, 9)");
    mesh.facets.nodes[0] = extra;
    CHECK(find(mesh, "unused node").count == 1);
}

TEST_CASE("indices out of range stop the check, others are reported beside the rest") {
    Mesh mesh = two_regions();
    mesh.elements[0].nodes[17] = 64;
    CHECK(find(mesh, "element with a node index out of range").first ==
          "hexahedron 2: node 64, expected at most 63");
    mesh = two_regions();
    mesh.facets.nodes[5] = 4000000000u;
    CHECK(find(mesh, "listed facet with a node index out of range").count == 1);
    mesh = two_regions();
    mesh.elements[0].region[3] = 3;
    mesh.elements[0].region[4] = 0;
    mesh.elements[0].kind[5] = 7;
    mesh.facets.surface[0] = 3;
    mesh.facets.outside[1] = 3;
    mesh.facets.inside[2] = 0;
    mesh.surface_names[1] = mesh.surface_names[0];
    CHECK(find(mesh, "element with a region out of range").count == 2);
    CHECK(find(mesh, "element of unknown kind").count == 1);
    CHECK(find(mesh, "listed facet with a surface out of range").count == 1);
    CHECK(find(mesh, "listed facet with a region out of range").count == 2);
    CHECK(find(mesh, "surface name used twice").first == "'wall'");
    CHECK(check_mesh(mesh).volume == doctest::Approx(27));
    mesh = two_regions();
    mesh.points.clear();
    CHECK(find(mesh, "element with a node index out of range").count == 8 * 27);
}

TEST_CASE("arrays of unequal length") {
    for (int which = 0; which < 7; ++which) {
        Mesh mesh = two_regions();
        if (which == 0) mesh.points.pop_back();
        if (which == 1) mesh.elements[0].nodes.pop_back();
        if (which == 2) mesh.elements[0].kind.pop_back();
        if (which == 3) mesh.facets.nodes.pop_back();
        if (which == 4) mesh.facets.inside.push_back(1);
        if (which == 5) mesh.facets.outside.clear();
        if (which == 6) mesh.model_dimension.assign(5, 3);
        CAPTURE(which);
        CHECK(find(mesh, "arrays of unequal length").count == 1);
    }
}

TEST_CASE("node with a coordinate that is not finite") {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Mesh mesh = two_regions();
        mesh.points[4] = bad;
        CHECK(find(mesh, "node with a coordinate that is not finite").count == 1);
        CHECK(find(mesh, "hexahedron with non-positive Jacobian").count >= 1);
    }
}

TEST_CASE("quadrilateral against two triangles") {
    Mesh mesh = unit_element(ElementType::kHexahedron);
    const NodeId apex = add_node(mesh, 0.5, 0.5, 2);
    add_element(mesh, ElementType::kTetrahedron, {4, 5, 6, apex});
    add_element(mesh, ElementType::kTetrahedron, {4, 6, 7, apex});
    list_facets(mesh);
    const Defect defect = find(mesh, "quadrilateral against triangles");
    CHECK(defect.count == 1);
    CHECK(defect.first.find("facet (4, 5, 6, 7)") == 0);
    // A fan of facets at the diagonal: more than two at one edge.
    CHECK(check_mesh(mesh).nonmanifold_edges > 0);
}

TEST_CASE("quadrilaterals over the same nodes in different order") {
    Mesh mesh = grid(2, 1, 1, 1);
    std::vector<NodeId>& nodes = mesh.elements[0].nodes;
    std::swap(nodes[8], nodes[11]);  // twists the shared face of the second cube
    CHECK(find(mesh, "quadrilaterals with the same nodes in different order").count == 1);
}

TEST_CASE("element with a repeated node") {
    Mesh mesh = mixed();
    mesh.elements[1].nodes[2] = mesh.elements[1].nodes[1];
    CHECK(find(mesh, "element with a repeated node").count == 1);
    CHECK(find(mesh, "wedge with non-positive Jacobian").count == 1);
}

TEST_CASE("a facet of three elements, and the open boundary that it leaves") {
    Mesh mesh = unit_element(ElementType::kTetrahedron);
    add_node(mesh, -1, -1, -1);
    add_node(mesh, -2, -1, -1);
    add_element(mesh, ElementType::kTetrahedron, {0, 2, 1, 4});
    add_element(mesh, ElementType::kTetrahedron, {0, 2, 1, 5});
    CHECK(find(mesh, "facet shared by more than two elements").count == 1);
    CHECK(find(mesh, "boundary not closed").count == 3);
}

TEST_CASE("the report does not depend on the run: many defects, equal first examples") {
    Mesh mesh = grid(30, 30, 30, 1);
    for (std::size_t i = 0; i < mesh.node_count(); i += 7) mesh.points[3 * i] += 1.5;
    const CheckReport first = check_mesh(mesh);
    REQUIRE(!first.valid());
    for (int run = 0; run < 3; ++run) {
        const CheckReport again = check_mesh(mesh);
        REQUIRE(again.defects.size() == first.defects.size());
        for (std::size_t i = 0; i < first.defects.size(); ++i) {
            CHECK(again.defects[i].count == first.defects[i].count);
            CHECK(again.defects[i].first == first.defects[i].first);
        }
        CHECK(again.volume == first.volume);
    }
}
