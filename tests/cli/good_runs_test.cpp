// What a user does every day: mesh, check, report; and stopping a run.
#include <doctest/doctest.h>

#include <signal.h>
#include <fstream>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/cli/program.hpp"

namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

void wait_a_little() { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }

/// What all runs that a signal ends have in common.
void expect_interrupted(const ScratchFolder& scratch, Program& program, int signal_number) {
    REQUIRE(program.running());
    program.send(signal_number);
    const auto sent = std::chrono::steady_clock::now();
    const Outcome outcome = program.wait();
    CHECK(std::chrono::steady_clock::now() - sent < std::chrono::seconds(5));
    CHECK(outcome.signal == signal_number);
    CHECK(outcome.err == "mortise: interrupted\n");
    CHECK(outcome.out.empty());
    CHECK(scratch.names("out").empty());
}

}  // namespace

TEST_CASE("the models of assets/ give valid meshes in both formats") {
    const ScratchFolder scratch;
    for (const char* name : {"block", "bracket", "cyl_cyl_int", "housing", "object_x", "star"}) {
        CAPTURE(name);
        const std::string vtu = scratch.file(std::string("out/") + name + ".vtu");
        const std::string msh = scratch.file(std::string("out/") + name + ".msh");
        scratch.names("out");
        const Outcome outcome =
            run({asset(name + std::string(".csg")), "--level", "4", "-o", vtu, "-o", msh});
        CHECK(outcome.code == 0);
        // Cells this large may hold features that cannot be kept; then the run says so.
        CHECK((outcome.err.empty() || is_one_line(outcome.err, "warning: ")));
        CHECK(contains(outcome.out, "tetrahedra"));
        Json figures[2];
        for (const std::string& path : {vtu, msh}) {
            const Outcome check = run({"check", path, "--json"});
            INFO(path, ": ", check.out, check.err);
            REQUIRE(check.code == 0);
            Json& document = figures[path == msh];
            document = Json::parse(check.out);
            CHECK(document["valid"] == true);
            CHECK(document["defects"].empty());
            document.erase("file");
        }
        CHECK(figures[0]["elements"] == figures[1]["elements"]);
        CHECK(figures[0]["volume"].get<double>() == doctest::Approx(figures[1]["volume"].get<double>()));
    }
    CHECK(scratch.names("out").size() == 12);
}

TEST_CASE("extensions mean the same in any case of letters") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string model = scratch.write("part.CSG", read_file(asset("block.csg")));
    CHECK(run({model, "-o", scratch.file("out/a.VTU"), "-o", scratch.file("out/b.Msh"), "--picture",
               scratch.file("out/c.PNG"), "--report", scratch.file("out/d.Json"), "--features",
               scratch.file("out/e.VTP"), "--level", "3"})
              .code == 0);
    CHECK(run({model, "-o", scratch.file("out/f.VTU"), "--memory", "1G", "--level", "3"}).code == 0);
    CHECK(scratch.names("out") == Names{"a.VTU", "b.Msh", "c.PNG", "d.Json", "e.VTP", "f.VTU"});
    CHECK(read_file(scratch.file("out/f.VTU")) == read_file(scratch.file("out/a.VTU")));
    CHECK(run({"check", scratch.file("out/a.VTU")}).code == 0);
    CHECK(run({"check", scratch.file("out/b.Msh")}).code == 0);
}

TEST_CASE("a warning tells what to do about a wall that is too thin, and only then") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string hint = "too thin for these cells";
    const auto tube = [&](const std::string& inner) {
        return scratch.write("tube.csg",
                             "difference() { cylinder($fn=0, $fa=12, $fs=2, h=10, r1=10, r2=10, "
                             "center=true); cylinder($fn=0, $fa=12, $fs=2, h=12, r1=" +
                                 inner + ", r2=" + inner + ", center=true); }");
    };
    const std::string out = scratch.file("out/tube.vtu");
    for (const char* how : {"--quiet", "--json", "--check"}) {
        CAPTURE(how);
        const Outcome thin = run({tube("9.95"), "--level", "4", "-o", out, how});
        CHECK(contains(thin.err, hint));
        if (std::string(how) == "--json")
            CHECK(contains(Json::parse(thin.out)["warnings"].back().get<std::string>(), hint));
        CHECK(run({tube("6"), "--level", "4", "-o", out, how}).err.empty());
    }
    CHECK(contains(run({tube("9.95"), "--level", "4", "-o", out, "--memory", "1G"}).err, hint));
    CHECK_FALSE(contains(run({tube("9.95"), "--level", "4", "-o", out, "--no-improve"}).err, hint));
}

TEST_CASE("report, picture and --json hold what was made") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string vtu = scratch.file("out/a.vtu"), picture = scratch.file("out/a.png"),
                      report = scratch.file("out/a.json");
    const Outcome outcome = run({asset("bracket.csg"), "-o", vtu, "--level=3", "--picture", picture,
                                 "--report", report, "--json", "--check"});
    REQUIRE(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK(scratch.names("out") == Names{"a.json", "a.png", "a.vtu"});
    CHECK(read_file(picture).compare(0, 4, "\x89PNG") == 0);
    CHECK(outcome.out == read_file(report));
    const Json document = Json::parse(outcome.out);
    CHECK(document["level"] == 3);
    CHECK(document["outputs"] == Json::array({vtu}));
    CHECK(document["warnings"].empty());
    const Json check = Json::parse(run({"check", vtu, "--json"}).out);
    CHECK(document["nodes"] == check["nodes"]);
    CHECK(document["elements"] == check["elements"]);
    CHECK(document["check"]["volume"] == check["volume"]);
    std::uint64_t elements = 0, by_kind = 0, by_region = 0, facets = 0;
    for (const Json& count : document["elements"]) elements += count.get<std::uint64_t>();
    for (const Json& count : document["elements_by_kind"]) by_kind += count.get<std::uint64_t>();
    for (const Json& region : document["regions"]) by_region += region["elements"].get<std::uint64_t>();
    for (const Json& surface : document["surfaces"]) facets += surface["facets"].get<std::uint64_t>();
    CHECK(elements > 0);
    CHECK(by_kind == elements);
    CHECK(by_region == elements);
    CHECK(facets == check["boundary_facets"].get<std::uint64_t>());
    CHECK(document["stages"].front()["stage"] == "read");
}

TEST_CASE("an infinite solid is meshed inside the box, whose faces are named") {
    const ScratchFolder scratch;
    scratch.names("out");
    struct Infinite {
        const char* text;
        std::vector<std::string> surfaces;
    };
    const Infinite models[] = {{"algebraic3d\nsolid s = plane (0, 0, 0; 0, 0, 1);\ntlo s;\n",
                                {"s", "box_xmin", "box_xmax", "box_ymin", "box_ymax", "box_zmin"}},
                               {"algebraic3d\nsolid s = cylinder (0, 0, 0; 0, 0, 1; 0.5);\ntlo s;\n",
                                {"s", "box_zmin", "box_zmax"}}};
    for (const Infinite& model : models) {
        CAPTURE(model.text);
        const std::string path = scratch.write("infinite.geo", model.text), out = scratch.file("out/a.msh");
        const Outcome outcome = run({path, "-o", out, "--level", "3", "--json", "--check", "--box", "-1",
                                     "-1.0", "-.9", "1", "1e0", "+1"});
        CHECK(outcome.err.empty());
        REQUIRE(outcome.code == 0);
        std::vector<std::string> surfaces;
        const Json document = Json::parse(outcome.out);
        for (const Json& surface : document["surfaces"]) surfaces.push_back(surface["name"]);
        CHECK(surfaces == model.surfaces);
        CHECK(run({"check", out}).code == 0);
    }
}

TEST_CASE("the same bytes for every number of threads and work-group size, and --quiet is quiet") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string model = asset("housing.csg"), a = scratch.file("out/a.vtu"),
                      b = scratch.file("out/b.vtu");
    const Outcome one = run({model, "-o", a, "--level", "4", "--threads", "1", "--quiet"});
    const Outcome two = run({"--quiet", "--threads", "3", "--level", "4", "-o", b, model});
    CHECK(one.code == 0);
    CHECK(two.code == 0);
    CHECK(one.out + one.err + two.out + two.err == "");
    CHECK(read_file(a) == read_file(b));
}

TEST_CASE("scaled Jacobians of host and device: the same bytes, the same figures") {
    const ScratchFolder scratch;
    std::string bytes;
    Json figures;
    for (const char* way : {"host", "own"}) {
        CAPTURE(way);
        const std::string vtu = scratch.file(std::string(way) + ".vtu");
        const Outcome outcome =
            run({asset("bracket.csg"), "-o", vtu, "--level", "4", "--json"}, {{"MORTISE_JACOBIANS", way}});
        REQUIRE(outcome.code == 0);
        const Json document = Json::parse(outcome.out);
        if (bytes.empty()) {
            bytes = read_file(vtu);
            figures = document["min_scaled_jacobian"];
        }
        CHECK(read_file(vtu) == bytes);
        CHECK(document["min_scaled_jacobian"] == figures);
    }
    const Outcome wrong = run({asset("bracket.csg"), "-o", scratch.file("a.vtu"), "--level", "2"},
                              {{"MORTISE_JACOBIANS", "blas"}});
    CHECK(wrong.code == 1);
    CHECK(is_one_line(wrong.err, "mortise: MORTISE_JACOBIANS is 'blas'"));
}

TEST_CASE("a warning is one line on stderr, said once, and the run goes on") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string path =
        scratch.write("warn.geo", "algebraic3d\nsolid s = sphere (0, 0, 0; 1);\ntlo s;\nword\n");
    const Outcome outcome = run({path, "-o", scratch.file("out/a.vtu"), "--level", "3", "--quiet"});
    CHECK(outcome.code == 0);
    CHECK(is_one_line(outcome.err, "warning: "));
    CHECK(contains(outcome.err, "word"));
    const Outcome info = run({"info", path, "--json"});
    CHECK(info.err == outcome.err);
    CHECK(Json::parse(info.out)["warnings"].size() == 1);
}

TEST_CASE("info, devices, doctor, help and version") {
    const Outcome info = run({"info", asset("bracket.csg"), "--json"});
    CHECK(info.code == 0);
    const Json document = Json::parse(info.out);
    CHECK(document["regions"].size() == 1);
    CHECK(document["primitives"]["convex"].get<int>() + document["primitives"]["cylinder"].get<int>() >= 5);
    CHECK(document["bounds"]["min"].size() == 3);
    CHECK(document["surfaces"].size() > 10);
    CHECK(document["surfaces"][0]["max_size"].is_null());
    CHECK(run({"info", asset("bracket.csg")}).code == 0);
    const auto cylinders = [](const std::string& facets) {
        const Outcome outcome = run({"info", asset("bracket.csg"), "--facets", facets, "--json"});
        return Json::parse(outcome.out)["primitives"]["cylinder"].get<int>();
    };
    CHECK(cylinders("smooth") > 0);
    CHECK(cylinders("exact") == 0);
    {
        // What a hull becomes is counted, too.
        const ScratchFolder scratch;
        const std::string path =
            scratch.write("hull.csg",
                          "hull() { sphere(r = 1); multmatrix([[1,0,0,3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { "
                          "sphere(r = 1); } "
                          "multmatrix([[1,0,0,0],[0,1,0,3],[0,0,1,0],[0,0,0,1]]) { sphere(r = 1); } }");
        const Json hull = Json::parse(run({"info", path, "--json"}).out);
        CHECK(hull["primitives"]["rounded"] == 1);
        CHECK(hull["surfaces"].size() == 1);
    }
    {
        const ScratchFolder scratch;
        const std::string path = scratch.file("plane.geo");
        std::ofstream(path) << "algebraic3d\nsolid half = plane(0,0,0;0,0,1) -maxh=2;\ntlo half;\n";
        const Outcome infinite = run({"info", path, "--json"});
        CHECK(infinite.code == 0);
        CHECK(Json::parse(infinite.out)["bounds"].is_null());
        CHECK(Json::parse(infinite.out)["surfaces"][0]["max_size"] == 2);
        CHECK(contains(run({"info", path}).out, "element size 2"));
    }

    const Outcome devices = run({"devices", "--json"});
    CHECK(devices.code == 0);
    int defaults = 0;
    for (const Json& device : Json::parse(devices.out)) defaults += device["default"].get<bool>() ? 1 : 0;
    CHECK(defaults == 1);
    CHECK(contains(run({"devices"}).out, " * "));
    // Its last line measures how many cores are free: not on a busy machine.
    const Outcome doctor = run({"doctor"});
    CHECK(contains(doctor.out, "ok    arithmetic equals the host's"));
    CHECK((doctor.code == 0) == !contains(doctor.out, "FAIL"));

    CHECK(is_one_line(run({"--version"}).out, "mortise "));
    const Outcome help = run({"--help"});
    CHECK(help.code == 0);
    for (const char* part : {"--level", "--box", "check", "doctor", "Exit codes:", "Examples:"}) {
        CHECK(contains(help.out, part));
    }
    std::size_t lines = 0, widest = 0;
    for (std::size_t start = 0; start < help.out.size(); ++lines) {
        const std::size_t end = help.out.find('\n', start);
        widest = std::max(widest, end - start);
        start = end + 1;
    }
    CHECK(lines <= 66);  // a printed page
    CHECK(widest <= 100);
    CHECK(contains(run({"check", "--help"}).out, "mortise check FILE"));
}

TEST_CASE("a signal ends a run at once, without a file") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string out = scratch.file("out/a.vtu");
    {
        Program program({asset("bracket.csg"), "-o", out, "--level", "8"});
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        expect_interrupted(scratch, program, SIGTERM);
    }
    {
        // In the middle of writing: the temporary file is there and has content.
        Program program({asset("bracket.csg"), "-o", out, "--level", "8"});
        const auto is_writing = [&scratch] {
            for (const std::string& name : scratch.names("out")) {
                std::error_code error;
                const std::uintmax_t size = std::filesystem::file_size(scratch.file("out/" + name), error);
                if (!error && size > 0) return true;
            }
            return false;
        };
        while (program.running() && !is_writing()) wait_a_little();
        expect_interrupted(scratch, program, SIGINT);
    }
}

TEST_CASE("a function of x and y alone is a solid in a box") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string disc = scratch.write("disc.formula", "x^2 + y^2 - 1");
    const Outcome outcome = run({disc, "-o", scratch.file("out/a.vtu"), "--level", "4", "--check", "--box",
                                 "-2", "-2", "0", "2", "2", "1"});
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "volume 3.0"));
    CHECK(run({disc, "-o", scratch.file("out/b.vtu")}).code == 2);
}

TEST_CASE("a mesh of second order as .vtu and .msh, which check reads") {
    const ScratchFolder scratch;
    const std::string vtu = scratch.file("a.vtu"), msh = scratch.file("a.msh"), json = scratch.file("a.json");
    const Outcome outcome =
        run({asset("bracket.csg"), "--order", "2", "-o", vtu, "-o", msh, "--report", json, "--check"});
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK(contains(outcome.out, "nodes in the middles of edges"));
    CHECK(contains(outcome.out, "check      valid; volume "));
    CHECK(contains(outcome.out, ", 1 component\n"));
    for (const std::string& file : {vtu, msh}) {
        const Outcome check = run({"check", file});
        CHECK(check.code == 0);
        CHECK(contains(check.out, " of them in the middles of edges"));
    }
    std::ifstream text(json);
    const nlohmann::json report = nlohmann::json::parse(text);
    CHECK(report["second_order"]["curved_edges"] > 1000);
    CHECK(report["second_order"]["relaxed_edges"] == 0);
}

TEST_CASE("layers at walls as .vtu, .msh and for OpenFOAM") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string vtu = scratch.file("a.vtu"), msh = scratch.file("a.msh"), json = scratch.file("a.json");
    const Outcome outcome =
        run({"--layers", "3", "--layers-on", "cube1_xmin", "--layers-on", "cube1_xmax", asset("block.csg"),
             "-o", vtu, "-o", msh, "-o", scratch.file("out/polyMesh"), "--report", json, "--check"});
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK(contains(outcome.out, "  layers     "));
    CHECK(run({"check", vtu}).code == 0);
    CHECK(run({"check", msh}).code == 0);
    std::ifstream text(json);
    const nlohmann::json report = nlohmann::json::parse(text);
    CHECK(report["layers"]["facets"] > 100);
    CHECK(report["layers"]["bare"] == 0);
    std::ifstream boundary(scratch.file("out/polyMesh/boundary"));
    const std::string patches((std::istreambuf_iterator<char>(boundary)), std::istreambuf_iterator<char>());
    std::size_t walls = 0;
    for (std::size_t at = 0; (at = patches.find(" wall;", at)) != std::string::npos; ++at) ++walls;
    CHECK(walls == 2);
    CHECK(report["layers"]["first_bare"].is_null());
    CHECK(report["layers"]["elements"] == 3 * report["layers"]["facets"].get<int>());
    CHECK(report["elements_by_kind"]["layer"] == report["layers"]["elements"]);
}

TEST_CASE("a signal in the middle of writing for OpenFOAM leaves no folder") {
    const ScratchFolder scratch;
    scratch.names("out");
    for (const char* folder : {"out/polyMesh", "out/case/constant/polyMesh"}) {
        Program program({asset("bracket.csg"), "-o", scratch.file(folder), "--level", "7"});
        while (program.running() && !std::filesystem::exists(scratch.file(folder))) wait_a_little();
        expect_interrupted(scratch, program, SIGTERM);
    }
}

TEST_CASE("a signal leaves the old file of that name untouched") {
    const ScratchFolder scratch;
    const std::string out = scratch.write("out/a.vtu", "old");
    Program program({asset("bracket.csg"), "-o", out, "--level", "8"});
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    program.send(SIGINT);
    CHECK(program.wait().signal == SIGINT);
    CHECK(scratch.names("out") == Names{"a.vtu"});
    CHECK(read_file(out) == "old");
}

TEST_CASE("--dry-run tells what a run would make, and makes nothing") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string vtu = scratch.file("out/a.vtu");
    const Outcome text = run({asset("bracket.csg"), "--level", "5", "-o", vtu, "--dry-run"});
    CHECK(text.code == 0);
    CHECK(contains(text.out, " elements, "));
    CHECK(contains(text.out, "  memory     about "));
    CHECK(scratch.names("out").empty());
    const Outcome told = run({asset("bracket.csg"), "--level", "5", "--dry-run", "--json"});
    const Outcome made = run({asset("bracket.csg"), "--level", "5", "-o", vtu, "--json"});
    REQUIRE((told.code == 0 && made.code == 0));
    const Json guess = Json::parse(told.out), mesh = Json::parse(made.out);
    CHECK(guess["is_exact"] == true);
    CHECK(guess["nodes"] == mesh["nodes"]);
    CHECK(guess["cells"]["nio"] == mesh["cells"]["nio"]);
    using Words = std::vector<std::string>;
    for (const Words& words :
         {Words{"--check"}, Words{"--quality"}, Words{"--quality-floor", "0.1"}, Words{"--features", "a.vtp"},
          Words{"--picture", "a.png"}, Words{"--cut", "x"}, Words{"--memory", "1G"}}) {
        Words all = {asset("bracket.csg"), "--dry-run"};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome refused = run(all);
        CHECK(refused.code == 1);
        CHECK(is_one_line(refused.err, "mortise: " + words[0] + ": a dry run makes no mesh"));
    }
    CHECK(run({asset("bracket.csg"), "--dry-run", "-o", "a.xyz"}).code == 1);
    CHECK(run({asset("bracket.csg"), "--dry-run", "-o", "a.inp", "--order", "2"}).code == 1);
    const Outcome large = run({asset("bracket.csg"), "--dry-run", "--level", "11"});
    CHECK(large.code == 0);
    CHECK(contains(large.out, ": about 1.4 billion elements"));
}

TEST_CASE("--scale: files in other units, reports in the model's") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string model = scratch.write("box.csg", "cube([3, 2, 1]);");
    const std::string vtu = scratch.file("out/box.vtu"), parts = scratch.file("out/parts.vtu");
    const Outcome outcome = run({model, "--level", "3", "-o", vtu, "--scale", "0.001", "--json"});
    REQUIRE(outcome.code == 0);
    CHECK(Json::parse(outcome.out)["cell_size"].get<double>() > 0.1);
    const Json checked = Json::parse(run({"check", vtu, "--json"}).out);
    CHECK(checked["volume"].get<double>() == doctest::Approx(6e-9));
    REQUIRE(run({model, "--level", "3", "-o", parts, "--scale", "0.001", "--memory", "1G"}).code == 0);
    CHECK((read_file(vtu) == read_file(parts)));
    for (const char* bad : {"0", "-1", "1e13", "mm"}) {
        const Outcome refused = run({model, "-o", vtu, "--scale", bad});
        CHECK(refused.code == 1);
        CHECK(is_one_line(refused.err, std::string("mortise: --scale '") + bad + "'"));
    }
}

TEST_CASE("--memory writes the same file, and tells how much it took") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string whole = scratch.file("out/whole.vtu"), parts = scratch.file("out/parts.vtu");
    REQUIRE(run({asset("bracket.csg"), "--level", "5", "-o", whole}).code == 0);
    // What a GPU's driver takes counts, too: half a gigabyte.
    const Outcome outcome = run({asset("bracket.csg"), "--level", "5", "-o", parts, "--memory", "1G"});
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK(contains(outcome.out, " MiB at most"));
    const auto bytes = [](const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    CHECK((bytes(whole) == bytes(parts)));
    CHECK(scratch.names("out") == Names{"parts.vtu", "whole.vtu"});

    const Outcome json =
        run({asset("bracket.csg"), "--level", "5", "-o", parts, "--memory", "1.5G", "--json"});
    const Json in_parts = Json::parse(json.out);
    const Json at_once = Json::parse(run({asset("bracket.csg"), "--level", "5", "-o", whole, "--json"}).out);
    for (const char* key : {"nodes", "elements", "elements_by_kind", "min_scaled_jacobian", "regions",
                            "surfaces", "features", "cells"}) {
        CAPTURE(key);
        CHECK(in_parts[key] == at_once[key]);
    }
    // Where the worst element is, as --quality has it; parts are gone when that is known.
    CHECK(in_parts["worst_place"].is_null());
    const std::string with_quality =
        run({asset("bracket.csg"), "--level", "5", "-o", whole, "--json", "--quality"}).out;
    CHECK(at_once["worst_place"] == Json::parse(with_quality)["quality"]["worst"][0]["place"]);
    CHECK(in_parts["peak_memory_bytes"].get<double>() > 1e6);

    const Outcome floor =
        run({asset("bracket.csg"), "--level", "5", "-o", parts, "--memory", "1G", "--quality-floor", "0.9"});
    CHECK(floor.code == 4);
    CHECK(contains(floor.err, "quality floor 0.9 not met"));
}
