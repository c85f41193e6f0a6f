// Whatever is wrong with a run: one line on stderr, the documented exit code, and no file left.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "mortise/io.hpp"
#include "tests/cli/program.hpp"

namespace {

constexpr int kUsage = 1, kInput = 2, kMeshing = 3, kDevice = 5, kFiles = 6;

/// Runs and checks what all failures have in common. The folder `out` must be empty before and after.
Outcome expect_failure(const ScratchFolder& scratch, int code, const std::string& message,
                       const std::vector<std::string>& arguments, const Environment& environment = {}) {
    REQUIRE(scratch.names("out").empty());
    const Outcome outcome = run(arguments, environment);
    INFO("stderr: ", outcome.err);
    CHECK(outcome.code == code);
    CHECK(is_one_line(outcome.err, "mortise: "));
    CHECK(contains(outcome.err, message));
    CHECK(scratch.names("out").empty());
    return outcome;
}

struct BadModel {
    const char* name;
    std::string text;
    int code;
    const char* message;
};

const std::string kGeo = "algebraic3d\n";

const std::string kBinary(
    "\x7f"
    "ELF\0\1\2\xff\xfe",
    9);

const BadModel kBadModels[] = {
    {"empty.csg", "", kInput, "no solid"},
    {"empty.geo", "", kInput, "empty"},
    {"binary.csg", kBinary, kInput, "byte"},
    {"binary.geo", kBinary, kInput, "byte"},
    {"brace.csg", "union() {\n cube(1);\n", kInput, "brace.csg:3:1"},
    {"node.csg", "cube(1);\nfrobnicate(1);\n", kInput, "node.csg:2:1: unknown node 'frobnicate'"},
    {"nan.csg", "sphere(r = nan);", kInput, "nan"},
    {"infinite.csg", "cube(size = [inf, 1, 1]);", kInput, "inf"},
    {"zero.csg", "sphere(r = 0);", kInput, "radius 0"},
    {"negative.csg", "sphere(r = -1);", kInput, "radius -1"},
    {"negative.geo", kGeo + "solid s = sphere (0, 0, 0; -1);\ntlo s;\n", kInput, "-1"},
    {"flat.csg", "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]) { cube(1); }", kInput, "singular"},
    {"disjoint.csg",
     "intersection() { cube(1); multmatrix([[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { cube(1); } }", kInput,
     "empty"},
    {"nothing.csg", "group();", kInput, "empty"},
    {"itself.csg", "difference() { cube(1); cube(1); }", kInput, "empty"},
    {"plane.geo", kGeo + "solid s = plane (0, 0, 0; 0, 0, 1);\ntlo s;\n", kInput, "--box"},
    {"cylinder.geo", kGeo + "solid s = cylinder (0, 0, 0; 0, 0, 1; 0.5);\ntlo s;\n", kInput, "--box"},
    {"bounds.formula", "bounds nan 0 0 1 1 1\nx", kInput,
     "bounds.formula:1:8: bounds: expected six finite numbers, found 'nan'"},
    {"endless.formula", "z", kInput, "within 10000 of the origin; cut it with --box"},
    {"word.geo", kGeo + "solid s = frobnicate (0, 0, 0; 1);\ntlo s;\n", kInput, "'frobnicate'"},
    {"no_object.geo", kGeo + "solid s = sphere (0, 0, 0; 1);\n", kInput, "tlo"},
    {"model.step", "solid\n", kInput, "unknown model format"},
    {"model.stl", "solid\n", kInput, "model.stl:2:1: expected 'facet' or 'endsolid'"},
};

}  // namespace

TEST_CASE("a model that cannot be meshed") {
    const ScratchFolder scratch;
    for (const BadModel& model : kBadModels) {
        CAPTURE(model.name);
        const std::string path = scratch.write(model.name, model.text);
        expect_failure(scratch, model.code, model.message,
                       {path, "-o", scratch.file("out/a.vtu"), "--level", "4"});
    }
}

TEST_CASE("a model file that cannot be read") {
    const ScratchFolder scratch;
    const std::string out = scratch.file("out/a.vtu");
    expect_failure(scratch, kFiles, "missing.csg", {scratch.file("missing.csg"), "-o", out});
    expect_failure(scratch, kFiles, "folder", {scratch.file("out"), "-o", out});
    expect_failure(scratch, kFiles, "missing.geo", {"info", scratch.file("missing.geo")});
}

TEST_CASE("numbers out of range") {
    const ScratchFolder scratch;
    const std::vector<std::vector<std::string>> cases = {
        {"--level", "0"},
        {"--level", "12"},
        {"--level", "40"},
        {"--level", "-3"},
        {"--level", "4.5"},
        {"--level", "six"},
        {"--level", "99999999999999999999"},
        {"--size", "-1"},
        {"--size", "0"},
        {"--size", "nan"},
        {"--size", "inf"},
        {"--size", "1e-9"},
        {"--size", ""},
        {"--refine", "-1"},
        {"--refine", "19"},
        {"--refine", "18"},
        {"--curvature-elements", "12"},
        {"--refine", "1", "--curvature-elements", "2"},
        {"--size-max", "0"},
        {"--size-max", "0.1", "--size-min", "1"},
        {"--size-min", "-1"},
        {"--size-of", "no_such_name", "1"},
        {"--size-of", "block", "0"},
        {"--size-of", "block"},
        {"--size-at", "0", "0", "0", "1"},
        {"--size-at", "0", "0", "0", "0", "1"},
        {"--size-at", "0", "0", "0", "1", "-1"},
        {"--size-at", "0", "0", "0", "1e-9", "0"},
        {"--size-formula", "1 +"},
        {"--size-formula", "x"},
        {"--interior-coarsening", "-1"},
        {"--threads", "-1"},
        {"--threads", "0"},
        {"--work-group", "-1"},
        {"--elements", "oct"},
        {"--facets", "fine"},
        {"--level"},
        {"--box", "0", "0", "0", "1"},
        {"--box", "0", "0", "0", "1", "1", "0"},
        {"--box", "0", "0", "0", "1", "1", "nan"},
        {"--box", "0", "0", "0", "1", "1", "inf"},
    };
    for (const std::vector<std::string>& words : cases) {
        CAPTURE(words.back());
        std::vector<std::string> arguments = {asset("block.csg"), "-o", scratch.file("out/a.vtu")};
        arguments.insert(arguments.end(), words.begin(), words.end());
        expect_failure(scratch, kUsage, "", arguments);
    }
}

TEST_CASE("a command line that is not understood") {
    const ScratchFolder scratch;
    const std::string model = asset("block.csg"), out = scratch.file("out/a.vtu");
    expect_failure(scratch, kUsage, "mortise --help", {});
    expect_failure(scratch, kUsage, "-o FILE.vtu", {model});
    expect_failure(scratch, kUsage, "'--colour'; see mortise --help", {model, "-o", out, "--colour"});
    expect_failure(scratch, kUsage, "'-q'", {model, "-o", out, "-q"});
    expect_failure(scratch, kUsage, "'another.csg'", {model, "another.csg", "-o", out});
    expect_failure(scratch, kUsage, "--output", {model, "-o"});
    expect_failure(scratch, kUsage, "twice", {model, "-o", out, "-o", out});
    expect_failure(scratch, kUsage, "twice", {model, "-o", out, "-o", scratch.file("out/./a.vtu")});
    std::filesystem::create_directories(scratch.file("out"));
    const std::string surface = scratch.file("surface.stl");
    CHECK(run({model, "-o", surface, "--level", "3"}).code == 0);
    expect_failure(scratch, kUsage, "is the model itself", {surface, "-o", surface, "--level", "3"});
    expect_failure(scratch, kUsage, "--level is given twice; expected it once",
                   {model, "-o", out, "--level", "4", "--level", "5"});
    expect_failure(
        scratch, kUsage, "--box is given twice",
        {model, "-o", out, "--box", "0", "0", "0", "1", "1", "1", "--box", "0", "0", "0", "1", "1", "1"});
    expect_failure(scratch, kUsage, "--size-formula is given twice",
                   {model, "-o", out, "--size-formula", "1", "--size-formula", "1"});
    expect_failure(scratch, kUsage, "--level: expected a value", {model, "-o", out, "--level"});
    expect_failure(scratch, kUsage, "--size", {model, "-o", out, "--level", "3", "--size", "1"});
    expect_failure(scratch, kUsage, "min_angle (--min-angle) 17 is out of range; use 18 to 44 degrees",
                   {model, "-o", out, "--min-angle", "17"});
    expect_failure(scratch, kUsage, "(--no-improve): elements reach larger angles",
                   {model, "-o", out, "--min-angle", "25", "--no-improve"});
    expect_failure(scratch, kUsage, "(--hanging, --elements tet)",
                   {model, "-o", out, "--hanging", "--elements", "tet"});
    expect_failure(scratch, kUsage, "--level '12': expected a whole number from 1 to 11; the default is 6",
                   {model, "-o", out, "--level", "12"});
    expect_failure(scratch, kInput, "the solid is empty, or lies outside of the box that cuts it",
                   {model, "-o", out, "--box", "100", "100", "100", "101", "101", "101"});
    expect_failure(scratch, kUsage, "--order '3': expected 1 or 2", {model, "-o", out, "--order", "3"});
    expect_failure(scratch, kUsage, "(--hanging, --order 2)",
                   {model, "-o", out, "--hanging", "--order", "2"});
    expect_failure(scratch, kUsage, "--order 2 needs the whole mesh",
                   {model, "-o", out, "--memory", "1G", "--order", "2"});
    expect_failure(scratch, kUsage, "OpenFOAM's meshes have no elements of second order",
                   {model, "-o", scratch.file("out/polyMesh"), "--order", "2"});
    expect_failure(scratch, kUsage, "--cut: there is no picture", {model, "-o", out, "--cut", "x"});
    for (const char* cut : {"w", "x4", "x=", "x=low"})
        expect_failure(scratch, kUsage, "--cut",
                       {model, "-o", out, "--picture", scratch.file("out/a.png"), "--cut", cut});
    expect_failure(scratch, kUsage, "--layers '0': expected a whole number from 1 to 100",
                   {model, "-o", out, "--layers", "0"});
    expect_failure(scratch, kUsage, "--first-layer: there are no layers; add --layers N",
                   {model, "-o", out, "--first-layer", "0.1"});
    expect_failure(scratch, kUsage, "--layers-on: there are no layers",
                   {model, "-o", out, "--layers-on", "block"});
    expect_failure(scratch, kUsage, "--first-layer '-1': expected a positive length",
                   {model, "-o", out, "--layers", "2", "--first-layer", "-1"});
    expect_failure(scratch, kUsage, "growth of layers (--layer-growth) 9 is out of range; use 0.5 to 3",
                   {model, "-o", out, "--layers", "2", "--layer-growth", "9"});
    expect_failure(scratch, kUsage, "(--layers, --hanging)",
                   {model, "-o", out, "--layers", "2", "--hanging"});
    expect_failure(scratch, kUsage, "(--layers, --order 2)",
                   {model, "-o", out, "--layers", "2", "--order", "2"});
    expect_failure(scratch, kUsage, "--layers needs the whole mesh",
                   {model, "-o", out, "--layers", "2", "--memory", "1G"});
    expect_failure(scratch, kUsage, "(--layers, --periodic)",
                   {model, "-o", out, "--layers", "2", "--periodic", "x"});
    expect_failure(scratch, kUsage, "--periodic needs the whole mesh",
                   {model, "-o", out, "--memory", "1G", "--periodic", "x"});
    expect_failure(scratch, kUsage, "periodic axes 'xx'", {model, "-o", out, "--periodic", "xx"});
    expect_failure(scratch, kUsage, "give the box that is repeated", {model, "-o", out, "--periodic", "x"});
    expect_failure(scratch, kUsage, "no region or surface is called 'wing'",
                   {model, "-o", out, "--layers", "2", "--layers-on", "wing"});
    expect_failure(scratch, kUsage, ".msh files have no place for hanging nodes",
                   {model, "-o", scratch.file("out/a.MSH"), "--hanging"});
    expect_failure(scratch, kUsage, "a folder polyMesh (OpenFOAM)", {model, "-o", scratch.file("out/mesh")});
    expect_failure(scratch, kUsage, "OpenFOAM's meshes are written only", {"check", "case/polyMesh"});
    expect_failure(scratch, kUsage, "expected .vtu or .msh", {"check", model});
    expect_failure(scratch, kUsage, "merge_distance (--merge) 0.3 is out of range; use 0 to 0.25 of a cell",
                   {model, "-o", out, "--merge", "0.3"});
    expect_failure(scratch, kUsage, "no mesh given", {"check"});
    expect_failure(scratch, kUsage, "no model given", {"info"});
    expect_failure(scratch, kUsage, "'--level'", {"check", out, "--level", "3"});
    expect_failure(scratch, kUsage, "two values, NAME H", {model, "-o", out, "--size-of", "block"});
    expect_failure(scratch, kUsage, "five numbers, X Y Z H G", {model, "-o", out, "--size-at", "1", "2"});
    expect_failure(scratch, kUsage, "from 1 to 11", {model, "-o", out, "--level", "0"});
    expect_failure(scratch, kUsage, "(--size-min) up to size_max",
                   {model, "-o", out, "--size-max", "0.1", "--size-min", "1"});
    for (const char* option : {"--quality", "--picture", "--report=r.json", "--memory", "--features"}) {
        expect_failure(scratch, kUsage, std::string("'") + option + "' is for meshing a single model",
                       {"batch", model, "-o", scratch.file("out"), option});
    }
    expect_failure(scratch, kUsage, "unexpected argument '--colour'; see mortise batch --help",
                   {"batch", model, "-o", scratch.file("out"), "--colour"});
}

TEST_CASE("an output that cannot be written is refused before the work") {
    const ScratchFolder scratch;
    const std::string model = asset("block.csg"), out = scratch.file("out/a.vtu");
    // A level that would take minutes.
    const std::vector<std::string> begin = {model, "--level", "10", "-o"};
    const auto refuse = [&](int code, const std::string& message, const std::vector<std::string>& words) {
        std::vector<std::string> arguments = begin;
        arguments.insert(arguments.end(), words.begin(), words.end());
        CHECK(expect_failure(scratch, code, message, arguments).seconds < 5);
    };
    refuse(kUsage, "'.obj'", {scratch.file("out/a.obj")});
    refuse(kUsage, "''", {scratch.file("out/a")});
    refuse(kUsage, "'.obj'", {out, "-o", scratch.file("out/a.obj")});
    refuse(kFiles, "absent", {scratch.file("absent/a.vtu")});
    refuse(kUsage, ".png", {out, "--picture", scratch.file("out/a.jpg")});
    refuse(kUsage, ".json", {out, "--report", model});
    refuse(kFiles, "absent", {out, "--picture", scratch.file("absent/a.png")});
    refuse(kFiles, "absent", {out, "--report", scratch.file("absent/a.json")});
    for (const char* name : {"d.vtu", "d.msh", "d.png", "d.json"}) {
        scratch.names(std::string("folders/") + name);
    }
    refuse(kFiles, "d.vtu", {scratch.file("folders/d.vtu")});
    refuse(kFiles, "d.msh", {out, "-o", scratch.file("folders/d.msh")});
    refuse(kFiles, "d.png", {out, "--picture", scratch.file("folders/d.png")});
    refuse(kFiles, "d.json", {out, "--report", scratch.file("folders/d.json")});
    // Root may write into any folder, except where the file system itself refuses.
    namespace fs = std::filesystem;
    scratch.names("sealed");
    fs::permissions(scratch.file("sealed"), fs::perms::owner_read | fs::perms::owner_exec);
    refuse(kFiles, "a.vtu", {geteuid() == 0 ? "/proc/a.vtu" : scratch.file("sealed/a.vtu")});
}

TEST_CASE("a device that cannot be used") {
    const ScratchFolder scratch;
    const std::string absent = scratch.file("absent");
    const std::vector<std::string> arguments = {asset("block.csg"), "-o", scratch.file("out/a.vtu"),
                                                "--level", "3"};
    const auto with = [&arguments](const std::vector<std::string>& more) {
        std::vector<std::string> all = arguments;
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    expect_failure(scratch, kDevice, "frobnicator", with({"--device", "frobnicator"}));
    expect_failure(scratch, kDevice, "99", with({"--device", "99"}));
    expect_failure(scratch, kDevice, "frobnicator", arguments, {{"MORTISE_DEVICE", "frobnicator"}});
    expect_failure(scratch, kDevice, "work-group", with({"--work-group", "1000000"}));
    expect_failure(scratch, kDevice, "pocl-opencl-icd", arguments, {{"OCL_ICD_VENDORS", absent}});
    expect_failure(scratch, kDevice, "pocl-opencl-icd", {"devices"}, {{"OCL_ICD_VENDORS", absent}});
    expect_failure(scratch, kDevice, "MORTISE_KERNELS", arguments, {{"MORTISE_KERNELS", absent}});
    const Outcome doctor = run({"doctor"}, {{"OCL_ICD_VENDORS", absent}});
    CHECK(doctor.code == kDevice);
    CHECK(contains(doctor.out, "FAIL  OpenCL devices"));
    // A driver that cannot be loaded for want of memory is not there, either.
    rlimit limit{};
    REQUIRE(getrlimit(RLIMIT_AS, &limit) == 0);
    rlimit small = limit;
    small.rlim_cur = rlim_t{512} << 20;
    REQUIRE(setrlimit(RLIMIT_AS, &small) == 0);
    expect_failure(scratch, kDevice, "512 MiB of memory (ulimit -v)", arguments,
                   {{"OCL_ICD_VENDORS", absent}});
    REQUIRE(setrlimit(RLIMIT_AS, &limit) == 0);
}

TEST_CASE("a disk that fills up leaves no part of a file") {
    const ScratchFolder scratch;
    REQUIRE(scratch.names("out").empty());
    const std::vector<std::string> arguments = {asset("block.csg"), "-o", scratch.file("out/a.vtu"),
                                                "--level", "4"};
    CHECK(run(arguments).code == 0);  // kernels are in the cache from here on
    CHECK(std::filesystem::remove(scratch.file("out/a.vtu")));
    rlimit limit{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &limit) == 0);
    rlimit small = limit;
    small.rlim_cur = 20000;
    // The child inherits the limit; a file beyond it fails as on a full disk.
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
    const Outcome outcome = run(arguments);
    REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    INFO(outcome.err);
    CHECK(outcome.code == kFiles);
    CHECK(is_one_line(outcome.err, "mortise: cannot write"));
    CHECK(scratch.names("out").empty());
}

TEST_CASE("check refuses what is not a mesh") {
    const ScratchFolder scratch;
    expect_failure(scratch, kFiles, "missing.vtu", {"check", scratch.file("missing.vtu")});
    expect_failure(scratch, kUsage, "'.obj'", {"check", scratch.file("a.obj")});
    expect_failure(scratch, kInput, "empty.vtu", {"check", scratch.write("empty.vtu", "")});
    expect_failure(scratch, kInput, "binary.msh", {"check", scratch.write("binary.msh", kBinary)});
}

TEST_CASE("check names each defect on a line of its own") {
    // A tetrahedron that is inside out, and a node that nothing uses.
    mortise::Mesh mesh;
    mesh.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 5, 5};
    mesh.region_names = {"part"};
    mesh.surface_names = {"skin"};
    mortise::ElementBlock& block = mesh.block(mortise::ElementType::kTetrahedron);
    block.nodes = {0, 2, 1, 3};
    block.region = {1};
    block.kind = {2};
    const ScratchFolder scratch;
    const std::string path = scratch.file("bad.vtu");
    mortise::write_mesh(mesh, path);
    const Outcome outcome = run({"check", path});
    CHECK(outcome.code == kMeshing);
    CHECK(outcome.err.empty());
    CHECK(contains(outcome.out, "bad.vtu: invalid\n"));
    const nlohmann::json document = nlohmann::json::parse(run({"check", path, "--json"}).out);
    CHECK(document["valid"] == false);
    REQUIRE(document["defects"].size() >= 2);
    for (const nlohmann::json& defect : document["defects"]) {
        CHECK(contains(outcome.out, "\n  defect     " + std::to_string(defect["count"].get<int>()) + " × " +
                                        defect["what"].get<std::string>() + ", first: "));
    }
}

TEST_CASE("a solid too small for its coordinates is refused, not meshed badly") {
    const ScratchFolder scratch;
    const std::string path = scratch.write(
        "far.csg", "multmatrix([[1,0,0,1e15],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { sphere(r = 1); }");
    REQUIRE(scratch.names("out").empty());
    const Outcome outcome = run({path, "-o", scratch.file("out/a.vtu"), "--level", "4"});
    CHECK((outcome.code == kInput || outcome.code == kMeshing));
    CHECK(is_one_line(outcome.err, "mortise: "));
    CHECK(scratch.names("out").empty());
}

TEST_CASE("a standard output that is full is an error") {
    if (!std::filesystem::exists("/dev/full")) return;
    const Outcome outcome = Program({"--help"}, {}, "/dev/full").wait();
    CHECK(outcome.code == kFiles);
    CHECK(is_one_line(outcome.err, "mortise: cannot write to the standard output"));
}

TEST_CASE("--memory is refused where it makes no sense") {
    const ScratchFolder scratch;
    const std::string model = asset("bracket.csg");
    const std::string vtu = scratch.file("out/a.vtu");
    scratch.names("out");
    for (const char* word : {"4", "G", "-1G", "4T", "4GB", "nanG", "1e30G"}) {
        CAPTURE(word);
        expect_failure(scratch, kUsage, "expected a number and a unit, such as 4G or 800M",
                       {model, "-o", vtu, std::string("--memory=") + word});
    }
    expect_failure(scratch, kUsage, "can be written as .vtu only",
                   {model, "-o", scratch.file("out/a.msh"), "--memory", "1G"});
    for (const char* option : {"--check", "--quality"}) {
        expect_failure(scratch, kUsage, std::string(option) + " needs the whole mesh in memory",
                       {model, "-o", vtu, "--memory", "1G", option});
    }
    expect_failure(scratch, kUsage, "needs the whole mesh",
                   {model, "-o", vtu, "--memory", "1G", "--elements", "tet"});
    expect_failure(scratch, kUsage, "cells of several sizes",
                   {model, "-o", vtu, "--memory", "1G", "--refine", "1"});
    expect_failure(scratch, kDevice, "allow more by --memory",
                   {model, "-o", vtu, "--memory", "10M", "--level", "4"});
}
