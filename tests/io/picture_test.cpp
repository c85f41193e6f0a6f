// Pictures: which faces are drawn, and the file.
#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>

#include <doctest/doctest.h>

#include "host/io/cut_faces.hpp"
#include "mortise/check.hpp"
#include "mortise/io.hpp"
#include "tests/io/files.hpp"
#include "tests/io/folder.hpp"

using namespace mortise;
namespace fs = std::filesystem;

TEST_CASE("a picture that is cut: the faces of the elements behind") {
    // Four unit cubes in a row along x, two regions.
    Mesh mesh;
    for (int i = 0; i <= 4; ++i) {
        for (const auto& [y, z] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) samples::add_node(mesh, i, y, z);
    }
    for (NodeId i = 0; i < 4; ++i) {
        const NodeId a = 4 * i, b = a + 4;
        samples::add_element(mesh, ElementType::kHexahedron, {a, b, b + 1, a + 1, a + 3, b + 3, b + 2, a + 2},
                             i < 2 ? 1 : 2, ElementKind::kSnio);
    }
    samples::list_facets(mesh);
    mesh.region_names = {"left", "right"};
    mesh.surface_names = {"outside", "", "between"};
    REQUIRE(check_mesh(mesh).valid());
    CHECK(io::outer_faces(mesh).size() == 4 * 4 + 2);
    for (const int behind : {1, 2, 3}) {
        const auto faces = io::faces_behind(mesh, {0, behind + 0.2});
        CHECK(faces.size() == 4 * static_cast<std::size_t>(behind) + 2);
        std::size_t cut = 0;
        for (const io::DrawnFace& face : faces) {
            if (face.is_facet) continue;
            ++cut;
            CHECK(face.region == (behind < 3 ? 1 : 2));
            CHECK(face.kind == static_cast<std::uint8_t>(ElementKind::kSnio));
            for (const NodeId node : face.node) CHECK(mesh.points[3 * std::size_t{node}] == behind);
        }
        CHECK(cut == 1);
    }
    // Triangles are known by their nodes, whichever of them an element or a facet repeats.
    Mesh tetrahedra;
    for (const auto& [x, y, z] : {std::tuple{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {1, 0, 0}})
        samples::add_node(tetrahedra, x, y, z);
    samples::add_element(tetrahedra, ElementType::kTetrahedron, {0, 2, 1, 3});
    samples::add_element(tetrahedra, ElementType::kTetrahedron, {1, 2, 0, 4});
    samples::list_facets(tetrahedra);
    tetrahedra.region_names = {"both"};
    tetrahedra.surface_names = {"outside"};
    for (std::size_t f = 0; f < tetrahedra.facets.size(); ++f) {  // turned
        NodeId* const node = tetrahedra.facets.nodes.data() + 4 * f;
        std::rotate(node, node + 1, node + 3);
        node[3] = node[2];
    }
    REQUIRE(check_mesh(tetrahedra).valid());
    const auto whole = io::faces_behind(tetrahedra, {0, 5.0});
    CHECK(whole.size() == 6);
    for (const io::DrawnFace& face : whole) CHECK(face.is_facet);
    CHECK(io::faces_behind(mesh, {0, {}}).size() == 4 * 2 + 2);  // the middle
    CHECK(io::faces_behind(mesh, {1, {}}).size() == 4 * 4 + 2);  // all centres lie in it
    CHECK(io::faces_behind(mesh, {2, -1.0}).empty());
    CHECK(io::faces_behind(mesh, {1, -1.0}).size() == 4 * 4 + 2);
    const Folder folder;
    PictureOptions options = {160, 120, PictureCut{0, 1.5}};
    write_picture(mesh, folder.file("cut.png"), options);
    write_picture(mesh, folder.file("whole.png"), {160, 120, {}});
    CHECK(read_bytes(folder.file("cut.png")) != read_bytes(folder.file("whole.png")));
    options.cut->axis = 3;
    CHECK(error_of([&] { write_picture(mesh, folder.file("a.png"), options); }).code() == ExitCode::kUsage);
}

TEST_CASE("pictures: a PNG of the size asked for, white around coloured facets") {
    const Folder folder;
    const std::string path = folder.file("mesh.png");
    write_picture(three_regions(), path, {160, 120, {}});
    const std::string bytes = read_bytes(path);
    REQUIRE(bytes.size() > 100);
    CHECK(bytes.compare(1, 3, "PNG") == 0);
    CHECK(static_cast<unsigned char>(bytes[19]) == 160);
    CHECK(static_cast<unsigned char>(bytes[23]) == 120);
    // An empty mesh is a white picture, smaller than any with something in it.
    write_picture(Mesh{}, folder.file("empty.png"), {160, 120, {}});
    CHECK(fs::file_size(folder.file("empty.png")) < bytes.size() / 2);
    CHECK(error_of([&] { write_picture(Mesh{}, path, {0, 10, {}}); }).code() == ExitCode::kUsage);
    CHECK(error_of([&] { write_picture(Mesh{}, path, {10, 1 << 20, {}}); }).code() == ExitCode::kUsage);
    CHECK(error_of([&] { write_picture(Mesh{}, folder.file("none/a.png")); }).code() == ExitCode::kFiles);
    CHECK(folder.entries() == 2);
}
