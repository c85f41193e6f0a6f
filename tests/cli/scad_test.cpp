// .scad files on the command line, with a script in place of openscad (tests/model/scad_test.cpp tests the
// rest).
#include <doctest/doctest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/cli/program.hpp"

namespace fs = std::filesystem;

namespace {

/// Environment in which `openscad` is that script.
Environment with_openscad(const ScratchFolder& scratch, const std::string& script) {
    const std::string path = scratch.write("bin/openscad", "#!/bin/sh\n" + script + "\n");
    fs::permissions(path, fs::perms::owner_all);
    return {{"PATH", scratch.file("bin") + ":" + std::getenv("PATH")}};
}

/// Neither running nor about to: gone, or waiting for whoever takes its status.
bool has_ended(const std::string& process) {
    const std::string status = read_file("/proc/" + process + "/stat");
    const std::size_t bracket = status.rfind(')');
    return bracket == std::string::npos || status.substr(bracket + 2, 1) == "Z";
}

}  // namespace

TEST_CASE("scad: mesh, info and batch") {
    const ScratchFolder scratch;
    const Environment fake =
        with_openscad(scratch, "case \"$6\" in n=*) echo \"cube(${6#n=});\";; *) echo 'cube(1);';; esac");
    const std::string part = scratch.write("part.scad", "n = 1; cube(n);");
    const std::string mesh = scratch.file("out/part.vtu");
    scratch.names("out");
    const Outcome meshed = run({part, "-o", mesh, "--level", "3", "-D", "n=2"}, fake);
    INFO(meshed.err);
    REQUIRE(meshed.code == 0);
    CHECK(meshed.err.empty());
    CHECK(fs::exists(mesh));
    const Outcome info = run({"info", part, "--define", "n=7"}, fake);
    CHECK(info.code == 0);
    CHECK(contains(info.out, "(7, 7, 7)"));
    const std::string list = scratch.write("list.txt", part + "\n" + asset("block.csg") + "\n");
    const Outcome batch = run({"batch", list, "-o", scratch.file("meshes"), "--level", "3"}, fake);
    CHECK(batch.code == 0);
    CHECK(scratch.names("meshes") == std::vector<std::string>{"block.vtu", "part.vtu"});
    // Nothing is left beside the model.
    CHECK(scratch.names("") == std::vector<std::string>{"bin", "list.txt", "meshes", "out", "part.scad"});
}

TEST_CASE("scad: failures are one line") {
    const ScratchFolder scratch;
    const std::string part = scratch.write("part.scad", "cube(1);");
    const std::string out = scratch.file("part.vtu");
    const Outcome none = run({part, "-o", out}, {{"PATH", scratch.file("nowhere")}});
    CHECK(none.code == 2);
    CHECK(is_one_line(none.err, "mortise: " + part + ": "));
    CHECK(contains(none.err, "apt install openscad"));
    const Environment bad =
        with_openscad(scratch, "echo 'ERROR: syntax error in file part.scad, line 1' >&2; exit 1");
    const Outcome failed = run({part, "-o", out}, bad);
    CHECK(failed.code == 2);
    CHECK(failed.err == "mortise: " + part + ":1: openscad: syntax error\n");
    const Outcome usage = run({asset("block.csg"), "-o", out, "-D", "a=1"});
    CHECK(usage.code == 1);
    CHECK(contains(usage.err, "--define is for OpenSCAD's .scad files only"));
    CHECK(run({part, "-o", out, "-D", "a"}, bad).code == 1);
    CHECK(run({part, "-o", out, "-D"}, bad).code == 1);
    CHECK_FALSE(fs::exists(out));
}

TEST_CASE("scad: an interrupted run ends the program that converts") {
    const ScratchFolder scratch;
    const std::string note = scratch.file("pid");
    const Environment fake = with_openscad(
        scratch, "echo $$ > '" + note + "'; : > '" + note + ".whole'; trap '' TERM INT; exec /bin/sleep 600");
    const std::string part = scratch.write("part.scad", "cube(1);");
    Program program({part, "-o", scratch.file("part.vtu")}, fake);
    for (int i = 0; i < 1000 && !fs::exists(note + ".whole"); ++i) usleep(20000);
    std::string process;
    std::ifstream(note) >> process;
    REQUIRE_FALSE(process.empty());
    CHECK_FALSE(has_ended(process));
    program.send(SIGTERM);
    CHECK(program.wait().signal == SIGTERM);
    for (int i = 0; i < 500 && !has_ended(process); ++i) usleep(20000);
    CHECK(has_ended(process));
}
