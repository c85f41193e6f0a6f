// polyhedron, text, import, surface, hull and minkowski as nodes of a .csg file.
#include <doctest/doctest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/model/membership.hpp"

namespace fs = std::filesystem;
using namespace mortise;
using test::region_at;

namespace {

/// A folder of files that is gone in the end.
class Folder {
  public:
    Folder() : path_(fs::temp_directory_path() / ("mortise_imports_" + std::to_string(::getpid()))) {
        fs::create_directories(path_ / "parts");
    }
    ~Folder() { fs::remove_all(path_); }
    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(path_ / name, std::ios::binary) << content;
        return (path_ / name).string();
    }
    Model read(const std::string& csg) const { return read_model(write("m.csg", csg)); }
    std::string refusal(const std::string& csg) const {
        try {
            read(csg);
        } catch (const Error& error) {
            const std::string message = error.what();
            return std::to_string(static_cast<int>(error.code())) + " " +
                   message.substr(message.find("m.csg"));
        }
        return {};
    }

  private:
    fs::path path_;
};

Model read_import(const std::string& csg) { return parse_model(csg, "csg", "m.csg"); }

const char* const kTetrahedronText =
    "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const CsgNode& only_primitive(const Model& model) {
    for (const CsgNode& node : model.nodes) {
        if (node.op == CsgNode::Op::kPrimitive) return node;
    }
    throw std::logic_error("no primitive");
}

}  // namespace

TEST_CASE(".csg polyhedron") {
    const std::string points = "points = [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0,0,1],[1,0,1],[1,1,1],[0,1,1]]";
    const std::string faces = "faces = [[0,1,2,3],[7,6,5,4],[4,5,1,0],[5,6,2,1],[6,7,3,2],[7,4,0,3]]";
    const Model cube = read_import("polyhedron(" + points + ", " + faces + ", convexity = 1);");
    // Convex: given by its planes.
    CHECK(only_primitive(cube).primitive.kind == Primitive::Kind::kConvex);
    CHECK(only_primitive(cube).primitive.planes.size() == 6);
    CHECK(only_primitive(cube).name == "polyhedron1");
    CHECK(region_at(cube, {0.9, 0.1, 0.5}) == 1);
    CHECK(region_at(cube, {1.1, 0.1, 0.5}) == 0);
    // With a dent.
    const Model dent = read_import(
        "polyhedron(points = [[0,0,0],[2,0,0],[0,2,0],[0,0,2],[0.3,0.3,0.3]], "
        "faces = [[0,1,2],[0,3,1],[0,2,3],[1,4,2],[2,4,3],[3,4,1]]);");
    CHECK(only_primitive(dent).primitive.kind == Primitive::Kind::kPolyhedron);
    CHECK(region_at(dent, {0.5, 0.5, 0.5}) == 0);
    CHECK(region_at(dent, {0.2, 0.2, 0.2}) == 1);

    const Model nothing = read_import("polyhedron(points = [], faces = [], convexity = 1); cube();");
    REQUIRE(nothing.warnings.size() == 1);
    CHECK(nothing.warnings[0] == "m.csg:1:1: a polyhedron without faces is left out");
    CHECK(read_import("polyhedron(points = undef, faces = undef); cube();").warnings.size() == 1);
    using test::refusal;
    CHECK(refusal("polyhedron(points = 3, faces = []);", "csg") ==
          "2 m.csg:1:21: 'polyhedron': points is not a list of triples of numbers");
    CHECK(refusal("polyhedron(" + points + ", faces = [1,2]);", "csg")
              .find("'polyhedron': faces is not a list") != std::string::npos);
    CHECK(
        refusal("\n polyhedron(" + points + ", faces = [[0,1,9],[0,1,2],[0,1,2],[0,1,2]]);", "csg") ==
        "2 m.csg:2:2: 'polyhedron': face 0 uses point 9, which does not exist; there are 8, counted from 0");
}

TEST_CASE(".csg text") {
    const Model sign = read_import(
        "linear_extrude(height = 2) { text(text = \"H\\\"H\", size = 10, halign = \"default\", $fn = 0); }");
    CHECK(sign.warnings.empty());
    // Left upright of the H: from 0.09 to 0.19 of its width of 10.
    CHECK(region_at(sign, {1.6, 5, 1}) == 1);
    CHECK(region_at(sign, {5, 8, 1}) == 0);
    CHECK(region_at(sign, {1.6, 9.7, 1}) == 0);
    using test::refusal;
    CHECK(refusal("linear_extrude(1) { text(\"H\", size = 0); }", "csg").find("'text' with size 0") !=
          std::string::npos);
    CHECK(refusal("linear_extrude(1) { text(\"H\", halign = \"up\"); }", "csg") ==
          "2 m.csg:1:21: 'text': halign is 'up'; expected left, center or right");
    CHECK(refusal("linear_extrude(1) { text(3); }", "csg") ==
          "2 m.csg:1:26: 'text': text is not a string; expected one in quotes");
    const Model missing = read_import(
        "linear_extrude(1) { text(\"H\", font = \"Nonesuch\"); text(\"I\", font = \"Nonesuch\"); }");
    CHECK(missing.warnings.size() == 1);
}

TEST_CASE(".csg import and surface: files beside the model") {
    const Folder folder;
    folder.write("parts/t.obj", kTetrahedronText);
    folder.write(
        "open.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 2 1 5\nf 3 2 5\n");
    folder.write("square.svg", "<svg><rect width='72' height='72'/></svg>");
    folder.write("c.dxf",
                 "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\na\n10\n5\n20\n0\n40\n2\n0\nENDSEC\n0\nEOF\n");
    folder.write("h.dat", "1 1\n1 1\n");
    folder.write("a.3mf", "");

    const Model solid = folder.read(
        "import(file = \"parts/t.obj\", layer = \"\", origin = [0, 0], scale = 1, convexity = 1, $fn = 0, "
        "timestamp = 0);");
    CHECK(region_at(solid, {0.5, 0.5, 0.5}) == 1);
    CHECK(region_at(solid, {2, 2, 2}) == 0);
    CHECK(only_primitive(solid).name == "import1");
    const Model centered = folder.read("import(file = \"parts/t.obj\", center = true);");
    CHECK(region_at(centered, {-1.5, -1.5, -1.5}) == 1);
    const Model open = folder.read("import(file = \"open.obj\");");
    REQUIRE(open.warnings.size() == 1);
    CHECK(open.warnings[0].find("m.csg:1:1: ") != std::string::npos);
    CHECK(open.warnings[0].find("open.obj: 3 edges have only one triangle") != std::string::npos);
    const Model square =
        folder.read("linear_extrude(height = 1) { import(file = \"square.svg\", center = true); }");
    CHECK(region_at(square, {12.6, -12.6, 0.5}) == 1);
    CHECK(region_at(square, {12.8, 0, 0.5}) == 0);
    const Model circle = folder.read(
        "linear_extrude(height = 1) { import(file = \"c.dxf\", layer = \"a\", origin = [5, 0], scale = 2, "
        "$fn = 64); }");
    CHECK(region_at(circle, {3.9, 0, 0.5}) == 1);
    CHECK(region_at(circle, {4.1, 0, 0.5}) == 0);
    const Model heights = folder.read("surface(file = \"h.dat\", center = true, invert = false);");
    CHECK(region_at(heights, {0.4, -0.4, 0.9}) == 1);
    CHECK(region_at(heights, {0.4, -0.4, 1.1}) == 0);

    CHECK(folder.refusal("import(file = \"\");") ==
          "2 m.csg:1:15: 'import': there is no file; expected a path");
    CHECK(folder.refusal("import(file = \"a\\nb.stl\");").find("control characters") != std::string::npos);
    const std::string missing = folder.refusal("import(file = \"none.stl\");");
    CHECK(missing.find("6 m.csg:1:15: 'import': ") == 0);
    CHECK(missing.find("none.stl: cannot be read: No such file") != std::string::npos);
    CHECK(folder.refusal("surface(file = \"none.dat\");").find("6 m.csg:1:16: 'surface': ") == 0);
    CHECK(folder.refusal("import(file = \"a.3mf\");") ==
          "2 m.csg:1:15: 'import': the format '.3mf' is not read; expected .stl, .obj, .off, .dxf or .svg");
    folder.write("bad.obj", "v 1 x\n");
    CHECK(folder.refusal("import(file = \"bad.obj\");").find("bad.obj:1:5: expected a coordinate") !=
          std::string::npos);
    CHECK(folder.refusal("import(file = \"c.dxf\", scale = 0);").find("'import': scale is 0") !=
          std::string::npos);
    CHECK(folder.refusal("import(file = \"c.dxf\", layer = \"b\");").find("no closed outline in layer 'b'") !=
          std::string::npos);
}

TEST_CASE(".csg hull and minkowski of solids") {
    const Model capsule = read_import(
        "hull() { sphere(r = 1); multmatrix([[1,0,0,4],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { sphere(r = 1); } }");
    CHECK(capsule.warnings.empty());
    CHECK(region_at(capsule, {2, 0, 0.95}) == 1);
    CHECK(region_at(capsule, {4.8, 0, 0.7}) == 0);
    // Of extrusions, whose points are known: a plate of a square and a circle.
    const Model plate = read_import(
        "hull() { linear_extrude(height = 2) { square([2, 2], center = true); } "
        "multmatrix([[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { linear_extrude(height = 2) { circle(r = 1); "
        "} } }");
    CHECK(plate.warnings.empty());
    CHECK(region_at(plate, {3, 0.95, 1}) == 1);
    CHECK(region_at(plate, {5.7, 0.7, 1}) == 1);
    CHECK(region_at(plate, {5.75, 0.75, 1}) == 0);
    CHECK(region_at(plate, {3, 0, 2.05}) == 0);
    // An extruded dent is filled.
    const Model filled =
        read_import("hull() { linear_extrude(height = 1) { polygon(points = [[0,0],[4,0],[1,1],[0,4]]); } }");
    CHECK(region_at(filled, {1.9, 1.9, 0.5}) == 1);
    const Model rounded = read_import("minkowski(convexity = 0) { cube([2, 2, 2]); sphere(r = 1); }");
    CHECK(rounded.warnings.empty());
    CHECK(region_at(rounded, {-0.5, -0.5, -0.5}) == 1);
    CHECK(region_at(rounded, {-0.6, -0.6, -0.6}) == 0);
    const Model mixed = read_import("hull() { square(1); cube(); }");
    CHECK(mixed.warnings.size() == 1);
    CHECK(region_at(read_import("hull() { } cube();"), {0.5, 0.5, 0.5}) == 1);
    CHECK(test::refusal("hull() { difference() { cube(2); sphere(1); } }", "csg")
              .find("2 m.csg:1:1: 'hull': a difference") == 0);
    CHECK(test::refusal("minkowski() { difference() { cube(2); sphere(1); } cube(); }", "csg")
              .find("2 m.csg:1:1: 'minkowski': a difference") == 0);
}
