// polyMesh folders that the program writes.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/cli/program.hpp"

namespace {

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a mesh with hanging nodes as .vtu, which check reads, and for OpenFOAM") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string vtu = scratch.file("out/a.vtu"), foam = scratch.file("out/polyMesh");
    const std::vector<std::string> words = {
        asset("block.csg"), "--interior-coarsening", "3", "--hanging", "-o", vtu, "-o", foam};
    const Outcome outcome = run(words);
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK(contains(outcome.out, "of them hexahedra with hanging nodes"));
    CHECK(run({"check", vtu}).code == 0);
    CHECK(scratch.names("out/polyMesh") ==
          Names{"boundary", "cellZones", "faces", "neighbour", "owner", "points"});
    // A second run takes the place of the first.
    CHECK(run(words).code == 0);
    CHECK(scratch.names("out") == Names{"a.vtu", "polyMesh"});
}

TEST_CASE("OpenFOAM's folder is made with its case, and with neither if the run fails") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string foam = scratch.file("out/case/constant/polyMesh");
    CHECK(
        run({scratch.write("empty.csg", "intersection(){cube(1); translate([3,0,0]) cube(1);}"), "-o", foam})
            .code == 2);
    CHECK(scratch.names("out").empty());
    const Outcome outcome = run({asset("block.csg"), "--level", "3", "-o", foam + "/", "--json", "--quiet"});
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "\"surfaces\""));
    CHECK(scratch.names("out/case/constant/polyMesh").size() == 6);
    const Outcome deeper =
        run({asset("block.csg"), "--level", "3", "-o", scratch.file("out/a/b/c/polyMesh"), "--quiet"});
    CHECK(deeper.code == 6);
    CHECK(contains(deeper.err, "create it first"));
    CHECK(scratch.names("out") == Names{"case"});
}
