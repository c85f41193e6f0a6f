// Input decks of Abaqus and CalculiX, read back by a reader of the tests' own.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "tests/io/deck.hpp"
#include "tests/io/folder.hpp"
#include "tests/quality/hanging_meshes.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

Deck written(const Mesh& mesh, const MeshFileOptions& options = {}) {
    const Folder folder;
    write_mesh(mesh, folder.file("mesh.inp"), {}, options);
    CHECK(folder.entries() == 1);
    return Deck(folder.file("mesh.inp"));
}

/// Nodes of a facet, from 1, without order.
std::set<int> nodes_of(const Mesh& mesh, std::size_t facet) {
    std::set<int> nodes;
    for (const NodeId node : mesh.facets.facet(facet)) nodes.insert(static_cast<int>(node) + 1);
    return nodes;
}

/// Every face of a surface, as the solver sees it, is a facet of the mesh, and the other way round.
void check_surfaces(const Mesh& mesh, const Deck& deck) {
    std::multiset<std::set<int>> faces, facets;
    for (const auto& [name, list] : deck.surfaces) {
        std::set<int> on_faces;
        for (const auto& [number, s] : list) {
            const Deck::Element& element = deck.elements.at(number);
            std::set<int> nodes;
            for (const int corner : Deck::face(element.type, s))
                nodes.insert(element.nodes.at(static_cast<std::size_t>(corner - 1)));
            faces.insert(nodes);
            on_faces.insert(nodes.begin(), nodes.end());
            const auto edges = Deck::edges(element.type);
            for (std::size_t e = 0; e < edges.size(); ++e) {
                const auto node = [&](int corner) {
                    return element.nodes[static_cast<std::size_t>(corner - 1)];
                };
                if (nodes.count(node(edges[e].first)) != 0 && nodes.count(node(edges[e].second)) != 0)
                    on_faces.insert(element.nodes[element.nodes.size() - edges.size() + e]);
            }
        }
        const std::vector<int>& set = deck.node_sets.at(name);
        CHECK(std::vector<int>(on_faces.begin(), on_faces.end()) == set);
    }
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) facets.insert(nodes_of(mesh, f));
    CHECK(faces == facets);
}

}  // namespace

TEST_CASE("a deck has all nodes, elements by type and region, and surfaces as sets of nodes and of faces") {
    const Mesh mesh = mixed();
    const Deck deck = written(mesh);
    REQUIRE(deck.nodes.size() == mesh.node_count());
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
        CHECK(deck.nodes.at(static_cast<int>(i / 3) + 1)[i % 3] == mesh.points[i]);
    REQUIRE(deck.elements.size() == 4);
    CHECK(deck.elements.at(1).type == "C3D8");
    CHECK(deck.elements.at(2).type == "C3D6");
    CHECK(deck.elements.at(2).nodes == std::vector<int>{2, 6, 10, 3, 7, 11});
    CHECK(deck.elements.at(3).type == "C3D8");  // a pyramid
    CHECK(deck.elements.at(3).nodes == std::vector<int>{5, 6, 7, 8, 9, 9, 9, 9});
    CHECK(deck.elements.at(4).type == "C3D4");
    CHECK(deck.elements.at(1).set == "REGION_1");
    CHECK(deck.elements.at(2).set == "REGION_1");
    CHECK(deck.elements.at(3).set == "REGION_2");
    CHECK(deck.element_sets.at("EALL") == std::vector<std::string>{"REGION_1", "REGION_2"});
    check_surfaces(mesh, deck);
    // The wall of two regions is two surfaces; the interface is seen from the first of its regions.
    std::set<std::string> names;
    for (const auto& [name, list] : deck.surfaces) names.insert(name);
    CHECK(names == std::set<std::string>{"INTERFACE_2", "WALL_REGION_1", "WALL_REGION_2"});
    for (const auto& [element, face] : deck.surfaces.at("INTERFACE_2"))
        CHECK(deck.elements.at(element).set == "REGION_1");
}

TEST_CASE("a deck of second order: middles of edges as the solvers number them") {
    Mesh first = mixed();
    // Without the pyramid, which such a deck cannot hold.
    first.block(ElementType::kPyramid) = {};
    list_facets(first);
    const Mesh mesh = with_middles(first);
    const Deck deck = written(mesh);
    std::set<std::string> types;
    for (const auto& [number, element] : deck.elements) {
        types.insert(element.type);
        const auto edges = Deck::edges(element.type);
        const std::size_t corners = element.nodes.size() - edges.size();
        for (std::size_t e = 0; e < edges.size(); ++e) {
            for (std::size_t j = 0; j < 3; ++j) {
                const auto at = [&](std::size_t k) { return deck.nodes.at(element.nodes.at(k))[j]; };
                const double mean = 0.5 * (at(static_cast<std::size_t>(edges[e].first) - 1) +
                                           at(static_cast<std::size_t>(edges[e].second) - 1));
                CHECK(at(corners + e) == mean);
            }
        }
    }
    CHECK(types == std::set<std::string>{"C3D10", "C3D15", "C3D20"});
    CHECK(deck.longest_line == 16);  // of C3D20, with its number 21 entries
    check_surfaces(mesh, deck);
}

TEST_CASE("a deck: numbers that solvers read whole; and lists over many lines") {
    Mesh mesh = grid(9, 7, 5, 1);
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
        mesh.points[i] = -1.2345678901234567e-5 * (mesh.points[i] + 1.0 / 3);
    mesh.points[0] = -1.2345678901234567e-120;
    mesh.points[1] = 1e22;
    mesh.points[2] = -123456.78901234567;
    const Deck deck = written(mesh);
    CHECK(deck.longest_number <= 20);
    CHECK(deck.longest_line <= 16);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        const double there = deck.nodes.at(static_cast<int>(i / 3) + 1)[i % 3];
        CHECK(std::fabs(there - mesh.points[i]) <= 5e-13 * std::fabs(mesh.points[i]));
    }
    check_surfaces(mesh, deck);
    CHECK(deck.node_sets.at("WALL").size() == 480 - 8 * 6 * 4);
}

TEST_CASE("a deck: names are words that solvers take, each once, and comments tell which they were") {
    Mesh mesh = grid(2, 1, 1, 2, [](int i, int, int) { return i + 1; });
    mesh.region_names = {"eall", "Eall"};
    mesh.surface_names = {std::string(3000, 'x'), "2nd \"side\", of\nit", "other"};
    const Deck deck = written(mesh);
    CHECK(deck.element_sets.at("EALL") == std::vector<std::string>{"EALL_2", "EALL_3"});
    CHECK(std::find(deck.comments.begin(), deck.comments.end(), "** region 'Eall': EALL_3") !=
          deck.comments.end());
    // CalculiX reads 1320 characters of a line, and what is beyond as data.
    for (const std::string& comment : deck.comments) CHECK(comment.size() < 250);
    REQUIRE(deck.surfaces.size() == 3);
    for (const auto& [name, list] : deck.surfaces) {
        CHECK(name.size() <= 80);
        CHECK(name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == std::string::npos);
        CHECK(name[0] >= 'A');
    }
    check_surfaces(mesh, deck);
}

TEST_CASE("a deck has the same bytes for any number of threads") {
    const Folder folder;
    const Mesh mesh = grid(30, 20, 20, 1);
    std::string bytes[2];
    for (const int threads : {1, 3}) {
        MeshFileOptions options;
        options.threads = threads;
        write_mesh(mesh, folder.file("mesh.inp"), {}, options);
        std::ifstream file(folder.file("mesh.inp"));
        bytes[threads / 2] = {std::istreambuf_iterator<char>(file), {}};
    }
    CHECK(bytes[0].size() > 100000);
    CHECK(bytes[0] == bytes[1]);
}

TEST_CASE("what a deck cannot hold is refused") {
    const Folder folder;
    const auto refused = [&](const Mesh& mesh, ExitCode code, const std::string& part) {
        try {
            write_mesh(mesh, folder.file("mesh.inp"));
            FAIL("no error");
        } catch (const Error& error) {
            CHECK(error.code() == code);
            INFO(error.what());
            CHECK(std::string(error.what()).find(part) != std::string::npos);
        }
        CHECK(folder.entries() == 0);
    };
    refused(with_middles(mixed()), ExitCode::kUsage, "--elements tet");
    refused(large_among_small(), ExitCode::kUsage, "hanging nodes");
    Mesh torn = mixed();
    std::swap(torn.facets.nodes[0], torn.facets.nodes[5]);
    refused(torn, ExitCode::kMeshing, "no face of an element");
    try {
        read_mesh(folder.file("mesh.inp"));
        FAIL("no error");
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kUsage);
    }
}
