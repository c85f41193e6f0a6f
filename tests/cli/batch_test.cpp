// mortise batch: many models, each told and written for itself.
#include <doctest/doctest.h>

#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/program.hpp"

namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

}  // namespace

TEST_CASE("batch: the same files as one by one, told in the order of the list") {
    const ScratchFolder scratch;
    const std::string list =
        scratch.write("list.txt", "# parts\n\n" + asset("star.csg") + "\n  " + asset("block.csg") + "  \n" +
                                      asset("bracket.csg") + "\r\n");
    const Outcome batch = run({"batch", list, "-o", scratch.file("meshes"), "--level", "4", "--check"});
    REQUIRE(batch.code == 0);
    CHECK(batch.err.empty());
    const auto lines = lines_of(batch.out);
    REQUIRE(lines.size() == 4);
    CHECK(contains(lines[0], "star.csg: "));
    CHECK(contains(lines[1], "block.csg: "));
    CHECK(contains(lines[2], "bracket.csg: "));
    CHECK(contains(lines[3], "3 of 3 models meshed"));
    CHECK(scratch.names("meshes") == Names{"block.vtu", "bracket.vtu", "star.vtu"});
    const std::string single = scratch.file("single.vtu");
    REQUIRE(run({asset("bracket.csg"), "-o", single, "--level", "4"}).code == 0);
    CHECK(read_file(single) == read_file(scratch.file("meshes/bracket.vtu")));

    const Outcome one_job = run({"batch", list, "-o", scratch.file("one"), "--level", "4", "--jobs", "1",
                                 "--format", "msh", "--json"});
    REQUIRE(one_job.code == 0);
    CHECK(scratch.names("one") == Names{"block.msh", "bracket.msh", "star.msh"});
    // In any case of letters, as -o part.VTU.
    REQUIRE(run({"batch", list, "-o", scratch.file("upper"), "--level", "2", "--format", "MSH"}).code == 0);
    CHECK(scratch.names("upper") == Names{"block.msh", "bracket.msh", "star.msh"});
    const auto objects = lines_of(one_job.out);
    REQUIRE(objects.size() == 3);
    CHECK(Json::parse(objects[1])["elements"]["hexahedra"] > 0);
    CHECK(Json::parse(objects[1])["exit_code"] == 0);
}

TEST_CASE("batch: a model that takes too long is given up and the others are not") {
    const ScratchFolder scratch;
    std::string balls = "union() {";
    for (int i = 0; i < 400; ++i)
        balls +=
            "translate([" + std::to_string(i % 20) + ", " + std::to_string(i / 20) + ", 0]) sphere(0.9);";
    const std::string slow = scratch.write("slow.csg", balls + "}");
    const std::string list = scratch.write("list.txt", slow + "\n" + asset("block.csg"));
    const Outcome batch = run({"batch", list, "-o", scratch.file("meshes"), "--size", "0.05", "--jobs", "1",
                               "--time-limit", "0.4", "--json", "--check"});
    CHECK(batch.code == 3);
    const auto objects = lines_of(batch.out);
    REQUIRE(objects.size() == 2);
    const Json first = Json::parse(objects[0]);
    CHECK(first["exit_code"] == 3);
    CHECK(contains(first["error"].get<std::string>(), "slow.csg: took more than 0.4 s, the last in '"));
    CHECK(first["seconds"] < 20);
    CHECK(scratch.names("meshes").size() <= 1);  // the second may be late, too, where the machine is busy
    const Outcome unhurried =
        run({"batch", scratch.write("one.txt", asset("block.csg")), "-o", scratch.file("meshes"), "--level",
             "3", "--time-limit", "600", "--json", "--check"});
    CHECK(unhurried.code == 0);
    const Json check = Json::parse(unhurried.out)["check"];
    CHECK(check["components"] == 1);
    CHECK(check["valid"] == true);
    for (const char* limit : {"0", "-1", "soon", "nan"}) {
        const Outcome wrong = run({"batch", list, "-o", scratch.file("meshes"), "--time-limit", limit});
        CHECK(wrong.code == 1);
        CHECK(contains(wrong.err, "--time-limit '" + std::string(limit) + "'"));
    }
}

TEST_CASE("batch: a model that fails costs itself only") {
    const ScratchFolder scratch;
    const std::string broken = scratch.write("broken.csg", "cube([1, 1, 1]) {");
    const std::string empty = scratch.write("empty.csg", "difference() { cube(1); cube(2); }");
    const std::string list = scratch.write(
        "list.txt", broken + "\n" + asset("block.csg") + "\n" + empty + "\n" + scratch.file("none.csg"));
    const Outcome batch = run({"batch", list, "-o", scratch.file("meshes"), "--level", "3"});
    CHECK(batch.code == 2);  // of the first
    CHECK(contains(batch.out, "1 of 4 models meshed"));
    const auto errors = lines_of(batch.err);
    REQUIRE(errors.size() == 3);
    CHECK(contains(errors[0], "broken.csg:1:"));
    CHECK(contains(errors[1], "empty.csg"));
    CHECK(contains(errors[2], "none.csg"));
    CHECK(scratch.names("meshes") == Names{"block.vtu"});

    const Outcome json =
        run({"batch", list, "-o", scratch.file("meshes"), "--level", "3", "--json", "--jobs", "2"});
    CHECK(json.code == 2);
    const auto objects = lines_of(json.out);
    REQUIRE(objects.size() == 4);
    CHECK(Json::parse(objects[0])["exit_code"] == 2);
    CHECK(contains(Json::parse(objects[0])["error"], "broken.csg:1:"));
    CHECK(Json::parse(objects[3])["exit_code"] == 6);
}

TEST_CASE("batch: every failure names its model") {
    const ScratchFolder scratch;
    const std::string list = scratch.write("list.txt", asset("block.csg") + "\n" + asset("star.csg") + "\n");
    const std::vector<std::vector<std::string>> options = {{"--quality-floor", "0.99"},
                                                           {"--size-of", "nothing", "0.1"}};
    for (const std::vector<std::string>& some : options) {
        std::vector<std::string> words = {"batch", list, "-o", scratch.file("meshes"), "--level", "3"};
        words.insert(words.end(), some.begin(), some.end());
        const Outcome batch = run(words);
        CHECK(batch.code != 0);
        const auto errors = lines_of(batch.err);
        REQUIRE(errors.size() == 2);
        CHECK(contains(errors[0], "block.csg: "));
        CHECK(contains(errors[1], "star.csg: "));
    }
}

TEST_CASE("batch: names that are not UTF-8 are meshed and told of like others") {
    const ScratchFolder scratch;
    const std::string name = scratch.write("\xd6l.csg", "cube([1, 1, 1]);");
    const std::string list = scratch.write("list.txt", name + "\n" + asset("block.csg") + "\n");
    for (const char* output : {"--json", "--check"}) {
        const Outcome batch = run({"batch", list, "-o", scratch.file("meshes"), "--level", "3", output});
        CHECK(batch.code == 0);
        CHECK(batch.err.empty());
        CHECK(lines_of(batch.out).size() >= 2);
        CHECK(scratch.names("meshes").size() == 2);
    }
}

TEST_CASE("batch: models of one name keep their folders") {
    const ScratchFolder scratch;
    std::string list;
    for (const char* folder : {"shapes/1", "shapes/2/inner", "shapes"}) {
        std::filesystem::create_directories(scratch.file(folder));
        list += scratch.write(std::string(folder) + "/part.csg", "cube(1);") + "\n";
    }
    list += scratch.write("shapes/1/other.csg", "cube(2);");
    const Outcome batch =
        run({"batch", scratch.write("list.txt", list), "-o", scratch.file("meshes"), "--level", "2"});
    CHECK(batch.code == 0);
    CHECK(scratch.names("meshes") == Names{"1", "2", "part.vtu"});
    CHECK(scratch.names("meshes/1") == Names{"other.vtu", "part.vtu"});
    CHECK(scratch.names("meshes/2/inner") == Names{"part.vtu"});
}

TEST_CASE("batch: models listed twice, or with one name in one folder, cost that line only") {
    const ScratchFolder scratch;
    const std::string part = scratch.write("part.csg", "cube(1);");
    const std::string repeated = asset("block.csg") + "\n\n" + part + "\n" + asset("block.csg") + "\n" + part;
    const Outcome batch =
        run({"batch", scratch.write("twice.txt", repeated), "-o", scratch.file("meshes"), "--level", "2"});
    CHECK(batch.code == 1);
    const auto lines = lines_of(batch.err);
    REQUIRE(lines.size() == 2);
    CHECK(contains(lines[0], "twice.txt:4: "));
    CHECK(contains(lines[0], "listed in line 1"));
    CHECK(contains(lines[1], "twice.txt:5: "));
    CHECK(contains(batch.out, "2 of 4 models meshed"));
    CHECK(scratch.names("meshes") == Names{"block.vtu", "part.vtu"});
    const std::string alike = part + "\n" + scratch.write("part.formula", "x^2 + y^2 + z^2 - 1");
    const Outcome clash =
        run({"batch", scratch.write("alike.txt", alike), "-o", scratch.file("others"), "--level", "2"});
    CHECK(clash.code == 1);
    CHECK(is_one_line(clash.err, "mortise: "));
    CHECK(contains(clash.err, "alike.txt:2: "));
    CHECK(scratch.names("others") == Names{"part.vtu"});
}

TEST_CASE("batch: a mesh below the quality floor counts as meshed") {
    const ScratchFolder scratch;
    const std::string cube = scratch.write("cube.csg", "cube(1);");
    const std::string list = scratch.write("list.txt", asset("bracket.csg") + "\n" + cube);
    const Outcome batch =
        run({"batch", list, "-o", scratch.file("meshes"), "--level", "4", "--quality-floor", "0.9"});
    CHECK(batch.code == 4);
    CHECK(contains(batch.out, "2 of 2 models meshed"));
    CHECK(contains(batch.out, ", 1 of them below the quality floor"));
    CHECK(scratch.names("meshes") == Names{"bracket.vtu", "cube.vtu"});
}

TEST_CASE("batch: warnings are counted; --json has them") {
    const ScratchFolder scratch;
    const std::string list = scratch.write(
        "list.txt", scratch.write("one.csg", "cube(1); square(1);") + "\n" +
                        scratch.write("two.csg", "cube(1); polygon(points = []); polyhedron();") + "\n" +
                        asset("block.csg"));
    const Outcome batch = run({"batch", list, "-o", scratch.file("meshes"), "--level", "3"});
    CHECK(batch.code == 0);
    CHECK(batch.err.empty());
    const auto lines = lines_of(batch.out);
    REQUIRE(lines.size() == 4);
    CHECK(contains(lines[0], "one.vtu; 1 warning"));
    CHECK_FALSE(contains(lines[0], "warnings"));
    CHECK(contains(lines[1], "two.vtu; 2 warnings"));
    CHECK_FALSE(contains(lines[2], "warning"));
    const Outcome json = run({"batch", list, "-o", scratch.file("meshes"), "--level", "3", "--json"});
    CHECK(json.err.empty());
    const auto objects = lines_of(json.out);
    REQUIRE(objects.size() == 3);
    CHECK(Json::parse(objects[0])["warnings"].size() == 1);
    CHECK(Json::parse(objects[1])["warnings"].size() == 2);
    CHECK(Json::parse(objects[2])["warnings"].empty());
}

TEST_CASE("batch: bad command lines and lists") {
    const ScratchFolder scratch;
    const std::string list = scratch.write("list.txt", asset("block.csg") + "\n");
    const auto refused = [](const std::vector<std::string>& words, int code, const char* part) {
        CAPTURE(part);
        const Outcome outcome = run(words);
        CHECK(outcome.code == code);
        CHECK(is_one_line(outcome.err, "mortise: "));
        CHECK(contains(outcome.err, part));
    };
    const std::string folder = scratch.file("meshes");
    refused({"batch"}, 1, "mortise batch LIST -o FOLDER");
    refused({"batch", list}, 1, "-o FOLDER");
    refused({"batch", list, "-o", folder, "--jobs", "0"}, 1, "--jobs");
    refused({"batch", list, "-o", folder, "--format", "obj"}, 1, "vtu, msh, inp or stl");
    refused({"batch", list, "-o", folder, "--level", "77"}, 1, "77");
    refused({"batch", scratch.file("no list"), "-o", folder}, 6, "no list");
    refused({"batch", scratch.write("blank.txt", "\n# nothing\n"), "-o", folder}, 1, "lists no models");
    refused({"batch", list, "-o", "/proc/nowhere/meshes"}, 6, "/proc/nowhere");
    refused({"batch", scratch.file("."), "-o", scratch.file("meshes")}, 6, "is a folder; expected a list");
}

TEST_CASE("batch: an interrupted run leaves no half-written file") {
    const ScratchFolder scratch;
    std::string text;
    for (const char* name : {"gyroid.csg", "housing.csg", "bracket.csg", "star.csg"})
        text += asset(name) + "\n";
    Program program({"batch", scratch.write("list.txt", text), "-o", scratch.file("meshes"), "--level", "6"});
    program.send(SIGTERM);
    const Outcome outcome = program.wait();
    CHECK(outcome.signal == SIGTERM);
    CHECK(lines_of(outcome.err).size() <= 1);  // not one of each process
    for (const std::string& name : scratch.names("meshes")) {
        CAPTURE(name);
        CHECK(name.size() > 4);
        CHECK(name.substr(name.size() - 4) == ".vtu");
    }
}
