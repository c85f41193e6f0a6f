// What the readers refuse, with which exit code and at which place.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "tests/model/membership.hpp"

using namespace mortise;
using test::refusal;

namespace {

struct Case {
    const char* text;
    const char* place;    ///< line:column
    const char* mention;  ///< must occur in the message
};

void check(const Case& c, const std::string& format) {
    const std::string message = refusal(c.text, format);
    CAPTURE(c.text);
    CAPTURE(message);
    const std::string start = "2 m." + format + ":" + c.place + ": ";
    CHECK(message.compare(0, start.size(), start) == 0);
    CHECK(message.find(c.mention) != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
}

}  // namespace

TEST_CASE(".csg errors name the place, the thing and what was expected") {
    const Case cases[] = {
        {"", "1:1", "holds no solid"},
        {" \n // nothing\n", "3:1", "holds no solid"},
        {"\x89PNG\r\n", "1:1", "byte 0x89"},
        {"cube();\nunion() {\n cube();\n", "4:1", "'{' at line 2, column 9"},
        {"cube(); }", "1:9", "unexpected '}'"},
        {"cube()\ncube();", "2:1", "expected ';' after"},
        {"cube(", "1:6", "expected a value"},
        {"cube", "1:5", "expected '('"},
        {"cube(size = [1, 2", "1:13", "never closed"},
        {"cube(size = [1 2 3]);", "1:16", "expected ',' or ']'"},
        {"cube(size = ]);", "1:13", "expected a value"},
        {"cube(size = 1 center = true);", "1:15", "expected ',' or ')'"},
        {"cube(size = foo);", "1:13", "'foo'"},
        {"cube(size = 1.2.3);", "1:13", "malformed number"},
        {"cube(size = 1e999);", "1:13", "too large"},
        {"/* cube();", "1:1", "never closed"},
        {"%text(text = \"a);", "1:14", "never closed"},
        {"cubes();", "1:1", "unknown node 'cubes'; did you mean 'cube'?"},
        {"clyinder(r = 1);", "1:1", "unknown node 'clyinder'; did you mean 'cylinder'?"},
        {"frobnicate(1);", "1:1", "unknown node 'frobnicate'; supported are multmatrix, cube"},
        {"cylinder(centre = 1);", "1:19", "did you mean 'center'?"},
        {"cylinder(h = 5, r = 4, r = 2);", "1:28", "'r' is given twice"},
        {"cylinder(h = 5, r = 4, d = 2);", "1:28", "r and d are both given"},
        {"cylinder(h = 5, r1 = 4, d1 = 2);", "1:30", "r1 and d1 are both given"},
        {"sphere(d = 2, r = 4);", "1:12", "r and d are both given"},
        {"resize(newsize = [1, 1, 1], auto = [true, \"a\", 0]) { cube(); }", "1:36", "auto is neither"},
        {"cube(size =\n);", "2:1", "found ')'"},
        {"cube(size = 1\n", "2:1", "found end of file"},
        {"cube(sizes = 1);", "1:14", "no argument 'sizes'"},
        {"cube(1, true, 3);", "1:15", "too many"},
        {"cube() { sphere(); }", "1:8", "takes no children"},
        {"cube(size = \"a\");", "1:13", "not a number"},
        {"cube(size = [1, 2]);", "1:13", "three numbers"},
        {"cube(size = [1, [2], 3]);", "1:13", "three numbers"},
        {"cube(center = 1);", "1:15", "neither true nor false"},
        {"cube(size = [1, 0, 1]);", "1:13", "size 0"},
        {"cube(size = [1, -2, 1]);", "1:13", "size -2"},
        {"cube(size = [1, nan, 1]);", "1:13", "size nan"},
        {"cube(size = -inf);", "1:13", "size -inf"},
        {"\n sphere(r = 0);", "2:13", "radius 0"},
        {"sphere(r = -1);", "1:12", "radius -1"},
        {"sphere(r = inf);", "1:12", "radius inf"},
        {"cylinder(h = 0, r1 = 1, r2 = 1);", "1:14", "height 0"},
        {"cylinder(h = nan);", "1:14", "height nan"},
        {"cylinder(h = 1, r1 = -1, r2 = 1);", "1:22", "radius -1"},
        {"cylinder(h = 1, r1 = 0, r2 = 0);", "1:30", "radius 0"},
        {"multmatrix() { cube(); }", "1:1", "four rows"},
        {"multmatrix([[1,0,0],[0,1,0],[0,0,1]]) { cube(); }", "1:12", "four rows"},
        {"multmatrix([[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]) { cube(); }", "1:12", "singular"},
        {"multmatrix([[1,0,0,0],[0,1,0,0],[0,0,nan,0],[0,0,0,1]]) { cube(); }", "1:38", "nan or inf"},
        {"multmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0.1,1]]) { cube(); }", "1:12", "last row"},
        {"cube();\na = 5;", "2:3",
         "this looks like OpenSCAD's source, which belongs into a file named .scad"},
        {"$fn = 5;", "1:1", "looks like OpenSCAD's source"},
        {"for (i = [0:3]) cube(i);", "1:1", "found 'for'; this looks like OpenSCAD's source"},
        {"module foo() { cube(1); }", "1:1", "found 'module'; this looks like OpenSCAD's source"},
        {"use <foo.scad>\n", "1:1", "found 'use'; this looks like OpenSCAD's source"},
    };
    for (const Case& c : cases) check(c, "csg");
    for (const char* name : {"roof", "path_extrude"}) {
        const std::string text = "cube();\n  " + std::string(name) + "();";
        const std::string mention = "'" + std::string(name) + "' is not supported yet";
        check({text.c_str(), "2:3", mention.c_str()}, "csg");
    }
}

TEST_CASE(".geo errors name the place, the thing and what was expected") {
    const Case cases[] = {
        {"", "1:1", "empty"},
        {"# only a comment\n", "2:1", "empty"},
        {"\x7f"
         "ELF\x02\x01",
         "1:1", "byte 0x7f"},
        {"solid a = sphere(0,0,0;1);", "1:1", "'algebraic3d'"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1);\n", "3:1", "no top-level object"},
        {"algebraic3d\ntlo a;", "2:5", "'a' is not defined"},
        {"algebraic3d\nsolid a = b and c;", "2:11", "'b' is not defined"},
        {"algebraic3d\nsolid a = a;", "2:11", "'a' is not defined"},
        {"algebraic3d\nsolid sphere = sphere(0,0,0;1);", "2:7", "word of the language"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1);\nsolid a = sphere(0,0,0;2);", "3:7", "first in line 2"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1)\ntlo a;", "3:1", "';' or a flag"},
        {"algebraic3d\nsolid a = sphere(0,0;1);", "2:21", "','"},
        {"algebraic3d\nsolid a = sphere(0,0,0;nan);", "2:24", "'nan'"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1e999);", "2:24", "too large"},
        {"algebraic3d\nsolid a = sphere(0,0,0;0);", "2:11", "radius is 0"},
        {"algebraic3d\nsolid a = sphere(0,0,0;-1);", "2:11", "radius is -1"},
        {"algebraic3d\nsolid a = plane(0,0,0;0,0,0);", "2:11", "direction"},
        {"algebraic3d\nsolid a = cylinder(1,1,1;1,1,1;1);", "2:11", "axis"},
        {"algebraic3d\nsolid a = cone(0,0,0;0;1,0,0;0);", "2:11", "both radii"},
        {"algebraic3d\nsolid a = cone(0,0,0;-1;1,0,0;2);", "2:11", "-1"},
        {"algebraic3d\nsolid a = torus(0,0,0;1,0,0;2;0);", "2:11", "minor radius"},
        {"algebraic3d\nsolid a = ellipsoid(0,0,0;1,0,0;0,1,0;1,1,0);", "2:11", "one plane"},
        {"algebraic3d\nsolid a = ellipticcylinder(0,0,0;1,0,0;2,0,0);", "2:11", "parallel"},
        {"algebraic3d\nsolid a = ellipticcone(0,0,0;2,0,0;0,1,0;0;0.5);", "2:11", "height"},
        {"algebraic3d\nsolid a = orthobrick(0,0,0;1,-1,1);", "2:11", "y = 0 and -1"},
        {"algebraic3d\nsolid a = (sphere(0,0,0;1) and\n", "3:1", "found end of file"},
        {"algebraic3d\nsolid a = (sphere(0,0,0;1);", "2:27", "'(' at line 2, column 11"},
        {"algebraic3d\nsolid a = multitranslate(1,0,0;1.5;sphere(0,0,0;1));", "2:32", "1.5"},
        {"algebraic3d\nsolid a = multitranslate(1,0,0;1e7;sphere(0,0,0;1));", "2:32", "1e+07"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1) -maxh=0;", "2:27", "-maxh is 0"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1) -maxh;", "2:27", "-maxh=number"},
        {"algebraic3d\nboundingbox (0,0,0;1,1,0);", "2:1", "boundingbox"},
        {"algebraic3d\nsold a = sphere(0,0,0;1);", "2:1", "found 'sold'"},
        {"algebraic3d\n= 3;", "2:1", "found '='"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1); tlo a; boundarycondition a b 3;", "2:55",
         "not a top-level object"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1); tlo a; identify something a a;", "2:35", "something"},
        {"algebraic3d\nsolid a = spere(0,0,0;1); tlo a;", "2:11", "unknown primitive 'spere'"},
        {"algebraic3d\nsolid a = spere(0,0,0;1); tlo a;", "2:11", "did you mean 'sphere'?"},
        {"algebraic3d\nsolid a = b; tlo a;", "2:11", "the solid 'b' is not defined"},
        {"algebraic3d\nsold a = sphere(0,0,0;1); tlo a;", "2:1", "found 'sold'; did you mean 'solid'?"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1); tlo a; identify closeedges a a a;", "2:35",
         "closeedges' is unknown"},
        {"algebraic3d\nsolid a = sphere(0,0,0;1);\ntlo a;\n tlo a -maxh=1;", "4:2",
         "'tlo a' is given twice, first in line 3; expected it once"},
    };
    for (const Case& c : cases) check(c, "geo");
    for (const char* name : {"tube", "gencyl"}) {
        const std::string text = "algebraic3d\nsolid a = " + std::string(name) + "(0);";
        const std::string mention = "'" + std::string(name) + "' is not supported yet";
        check({text.c_str(), "2:11", mention.c_str()}, "geo");
    }
}

TEST_CASE("words without an end are not repeated whole") {
    const std::string word(10000000, 'a');
    std::string words;
    for (int i = 0; i < 1000000; ++i) words += "words ";
    const std::pair<std::string, const char*> cases[] = {
        {word, "csg"},
        {word + "();", "csg"},
        {"cube(" + word + ");", "csg"},
        {"cube(" + word + " = 1);", "csg"},
        {"cube(" + std::string(10000000, '1') + "x);", "csg"},
        {"text(\"a\", halign = \"" + word + "\");", "csg"},
        {"import(file = \"" + word + "\");", "csg"},
        {"implicit(\"" + word + "\", 3);", "csg"},
        {"linear_extrude(1) text(\"a\", halign = \"" + words + "\");", "csg"},
        {"import(file = \"" + words + "\");", "csg"},
        {word, "geo"},
        {"algebraic3d\n" + word, "geo"},
        {"algebraic3d\nsolid " + word + ";", "geo"},
        {"algebraic3d\nsolid a = " + word + ";", "geo"},
        {"algebraic3d\ntlo " + word + ";", "geo"},
        {"x " + word, "vm"},
        {"x var-x\ny abs " + word, "vm"},
        {word, "formula"},
        {"solid x\n" + word, "stl"},
        {"v " + word, "obj"},
        {"OFF\n" + word, "off"},
    };
    for (const auto& [text, format] : cases) {
        CAPTURE(format);
        CAPTURE(text.substr(0, 40));
        const std::string message = refusal(text, format);
        CHECK(!message.empty());
        CHECK(message.size() < 900);
    }
    const Model model =
        parse_model("algebraic3d\nsolid a = sphere(0,0,0;1); tlo a -" + word + ";", "geo", "m.geo");
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0].size() < 100);
}

TEST_CASE("files that cannot be read, and unknown formats") {
    const auto code_of = [](const std::string& path) {
        try {
            read_model(path);
        } catch (const Error& error) {
            CHECK(std::string(error.what()).find(path) != std::string::npos);
            return error.code();
        }
        return ExitCode::kOk;
    };
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / "mortise-test-model-errors";
    fs::create_directories(folder);
    CHECK(code_of((folder / "missing.csg").string()) == ExitCode::kFiles);
    CHECK(code_of(folder.string()) == ExitCode::kFiles);
    const auto write = [&](const char* name, const std::string& text) {
        std::ofstream(folder / name, std::ios::binary) << text;
        return (folder / name).string();
    };
    CHECK(code_of(write("empty.csg", "")) == ExitCode::kInput);
    CHECK(code_of(write("empty.geo", "")) == ExitCode::kInput);
    CHECK(code_of(write("binary.csg", std::string("\x00\x01\xff\xfe", 4))) == ExitCode::kInput);
    CHECK(code_of(write("binary.geo", std::string("\x00\x01\xff\xfe", 4))) == ExitCode::kInput);
    CHECK(code_of(write("part.stl", "solid x")) == ExitCode::kInput);
    CHECK(code_of(write("part.CSG", "cube();")) == ExitCode::kOk);
    fs::remove_all(folder);
    CHECK(refusal("cube();", "step").find("unknown model format 'step'") != std::string::npos);
}
