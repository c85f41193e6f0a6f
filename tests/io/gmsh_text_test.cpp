// Meshes of other programs: Gmsh's text formats.
#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

using namespace mortise;

namespace {

/// A file in a temporary folder, gone with the object.
class TextFile {
  public:
    explicit TextFile(const std::string& text) {
        path_ =
            std::filesystem::temp_directory_path() / ("mortise_gmsh_" + std::to_string(getpid()) + ".msh");
        std::ofstream(path_, std::ios::binary) << text;
    }
    ~TextFile() { std::filesystem::remove(path_); }
    std::string path() const { return path_.string(); }

  private:
    std::filesystem::path path_;
};

// A cube with a pyramid on top, in two volumes; node 9 of the geometry belongs to no element.
const std::string kNodes4 =
    "$Nodes\n2 10 1 90\n0 1 0 1\n9\n5 5 5\n3 1 0 9\n1\n2\n3\n4\n15\n16\n17\n18\n90\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n0.5 0.5 2\n$EndNodes\n";
const std::string kElements4 =
    "$Elements\n3 3 1 7\n2 1 3 1\n1 1 2 3 4\n3 7 5 1\n5 1 2 3 4 15 16 17 18\n3 4 7 1\n7 15 16 17 18 90\n"
    "$EndElements\n";
const std::string kFormat4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"x\"\n$EndPhysicalNames\n";

void check_cube_and_pyramid(const Mesh& mesh) {
    CHECK(mesh.node_count() == 9);
    CHECK(mesh.block(ElementType::kHexahedron).size() == 1);
    CHECK(mesh.block(ElementType::kPyramid).size() == 1);
    REQUIRE(mesh.region_names.size() == 2);
    CHECK(mesh.region_names[0] == "volume_4");
    CHECK(mesh.block(ElementType::kPyramid).region[0] == 1);
    CHECK(mesh.block(ElementType::kHexahedron).region[0] == 2);
    const CheckReport report = check_mesh(mesh);
    INFO((report.defects.empty() ? "" : report.defects.front().what));
    CHECK(report.valid());
    CHECK(report.boundary_facets == 9);
    CHECK(report.interface_facets == 1);
    CHECK(report.volume == doctest::Approx(1 + 1.0 / 3));
}

}  // namespace

TEST_CASE("Gmsh text 4.1") {
    check_cube_and_pyramid(read_mesh(TextFile(kFormat4 + kNodes4 + kElements4).path()));
}

TEST_CASE("Gmsh text 2.2, with line ends of Windows") {
    std::string text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n"
        "6 1 0 1\n7 1 1 1\n8 0 1 1\n9 0.5 0.5 2e0\n$EndNodes\n$Elements\n3\n1 2 2 0 1 1 2 3\n"
        "2 5 2 0 7 1 2 3 4 5 6 7 8\n3 7 3 0 4 1 5 6 7 8 9\n$EndElements\n";
    for (std::size_t i = text.find('\n'); i != std::string::npos; i = text.find('\n', i + 2))
        text.insert(i, "\r");
    check_cube_and_pyramid(read_mesh(TextFile(text).path()));
}

TEST_CASE("a tetrahedron of second order in Gmsh's text") {
    // Gmsh's last two nodes are those of the edges (3, 2) and (3, 1); the edge from 0 to 1 is curved.
    const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n";
    const std::string nodes =
        "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 .5 0 -.1\n6 .5 .5 0\n7 0 .5 0\n8 0 0 .5\n9 0 .5 .5\n"
        "10 .5 0 .5\n$EndNodes\n";
    const std::string element = "$Elements\n1\n1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
    const Mesh mesh = read_mesh(TextFile(head + nodes + element).path());
    REQUIRE(mesh.is_second_order());
    const CheckReport report = check_mesh(mesh);
    CHECK(report.valid());
    CHECK(report.volume == doctest::Approx(1.0 / 6 + 0.1 / 6));
    CHECK(mesh.facets.middles.size() == 16);
}

TEST_CASE("Gmsh text that is damaged or not supported is refused") {
    const auto refused = [](const std::string& text) {
        const TextFile file(text);
        try {
            read_mesh(file.path());
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);
            return std::string(error.what());
        }
        FAIL("accepted");
        return std::string();
    };
    const std::string whole = kFormat4 + kNodes4 + kElements4;
    for (std::size_t size = 24; size + 14 < whole.size(); size += 5) refused(whole.substr(0, size));
    std::string second_order = whole;
    second_order.replace(second_order.find("3 7 5 1"), 7, "3 7 12 1");
    CHECK(refused(second_order).find("element type 12") != std::string::npos);
    std::string mixed_orders = whole;
    mixed_orders.replace(mixed_orders.find("3 4 7 1\n7 15 16 17 18 90"), 24,
                         "3 4 19 1\n7 15 16 17 18 90 1 2 3 4 1 2 3 4");
    CHECK(refused(mixed_orders).find("of first and of second order in one mesh") != std::string::npos);
    std::string fraction = whole;
    fraction.replace(fraction.find("7 15 16"), 7, "7 15.5 16");
    CHECK(refused(fraction).find("expected whole numbers") != std::string::npos);
    std::string no_node = whole;
    no_node.replace(no_node.find("18 90\n$EndE"), 5, "18 91");
    CHECK(refused(no_node).find("node 91") != std::string::npos);
    CHECK(refused("$MeshFormat\n4.0 0 8\n$EndMeshFormat\n").find("4.1 or 2.2") != std::string::npos);
    CHECK(refused(kFormat4 + kNodes4).find("no volume elements") != std::string::npos);
}

TEST_CASE("numbers of Gmsh's text: signs, exponents, what is too small; no others") {
    const std::string apex = "0.5 0.5 2\n";
    const auto with_apex = [&](const std::string& text) {
        std::string nodes = kNodes4;
        nodes.replace(nodes.find(apex), apex.size(), text + "\n");
        return kFormat4 + nodes + kElements4;
    };
    check_cube_and_pyramid(read_mesh(TextFile(with_apex("+0.5\t5E-1  +20e-1")).path()));
    CHECK(read_mesh(TextFile(with_apex("1e-400 0.5 2")).path()).node_count() == 9);
    for (const char* const wrong : {"+-1 0.5 2", "++1 0.5 2", "+ 1 0.5 2", "inf 0.5 2", "0.5 nan 2",
                                    "1e400 0.5 2", "0.5 0,5", "0.5 0.5"}) {
        CAPTURE(wrong);
        CHECK_THROWS_AS(read_mesh(TextFile(with_apex(wrong)).path()), Error);
    }
}
