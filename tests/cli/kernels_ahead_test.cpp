// The first run on a machine, with empty caches.
#include <doctest/doctest.h>

#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/cli/program.hpp"

namespace {

using Json = nlohmann::json;

/// Caches of its own, empty at first.
Environment empty_caches(const ScratchFolder& scratch) {
    return {{"MORTISE_CACHE", scratch.file("mortise")}, {"POCL_CACHE_DIR", scratch.file("pocl")}};
}

/// Programs compiled ahead, as a run's report says; 0 without that stage.
std::size_t compiled_ahead(const Outcome& outcome) {
    REQUIRE(outcome.code == 0);
    const Json report = Json::parse(outcome.out);
    for (const Json& stage : report["stages"]) {
        if (stage["stage"] == "kernels") return stage["items"];
    }
    return 0;
}

}  // namespace

TEST_CASE("the first run compiles all kernels ahead, those that follow none") {
    const ScratchFolder scratch;
    const Environment caches = empty_caches(scratch);
    const std::vector<std::string> arguments = {
        asset("bracket.csg"), "-o", scratch.file("bracket.vtu"), "--level", "4", "--json"};
    const std::size_t programs = compiled_ahead(run(arguments, caches));
    CHECK(programs > 1);
    // Beside the programs: that they are all there, and what the probe of the arithmetic found. A program
    // that the run needed and that was not compiled ahead would be one more.
    CHECK(scratch.names("mortise").size() == programs + 2);
    const std::string first = read_file(scratch.file("bracket.vtu"));
    CHECK(compiled_ahead(run(arguments, caches)) == 0);
    CHECK(scratch.names("mortise").size() == programs + 2);
    CHECK(read_file(scratch.file("bracket.vtu")) == first);
}

TEST_CASE("a run without a cache folder compiles nothing ahead") {
    const ScratchFolder scratch;
    const Outcome outcome =
        run({asset("block.csg"), "-o", scratch.file("block.vtu"), "--level", "3", "--json"},
            {{"MORTISE_CACHE", "/dev/null/cache"}});
    CHECK(compiled_ahead(outcome) == 0);
}

TEST_CASE("a signal ends a run that compiles kernels, and what compiles for it") {
    const ScratchFolder scratch;
    Program program({asset("block.csg"), "-o", scratch.file("block.vtu"), "--level", "3"},
                    empty_caches(scratch));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    REQUIRE(program.running());
    program.send(SIGINT);
    const Outcome outcome = program.wait();
    CHECK(outcome.signal == SIGINT);
    CHECK(outcome.err == "mortise: interrupted\n");
    const auto files = scratch.names("mortise");
    std::this_thread::sleep_for(std::chrono::seconds(2));  // a program takes less
    CHECK(scratch.names("mortise") == files);
}
