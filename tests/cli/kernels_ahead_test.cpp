// The first run on a machine, with empty caches.
#include <doctest/doctest.h>

#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/cli/program.hpp"

namespace {

using Json = nlohmann::json;

/// Caches of its own, empty at first, and no kernels that are installed.
Environment empty_caches(const ScratchFolder& scratch) {
    return {{"MORTISE_CACHE", scratch.file("mortise")},
            {"POCL_CACHE_DIR", scratch.file("pocl")},
            {"MORTISE_COMPILED_KERNELS", "/dev/null/none"}};
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

TEST_CASE("kernels compiled into a folder serve first runs, which leave it as it is") {
    const ScratchFolder scratch;
    const std::string folder = scratch.file("compiled");
    const Outcome compiled = run({"kernels", "-o", folder, "--json"}, empty_caches(scratch));
    REQUIRE(compiled.code == 0);
    const Json said = Json::parse(compiled.out);
    CHECK(said["folder"] == folder);
    const std::size_t programs = said["compiled"];
    const auto files = scratch.names("compiled");
    CHECK(files.size() == programs + 2);  // notes for runs that need the usual ones, and for this command
    CHECK(scratch.names("mortise").empty());
    const Outcome again = run({"kernels", "-o", folder}, empty_caches(scratch));
    CHECK(again.out == folder + ": all kernels are there\n");

    const Environment installed = {{"MORTISE_CACHE", scratch.file("mortise")},
                                   {"POCL_CACHE_DIR", scratch.file("other pocl")},
                                   {"MORTISE_COMPILED_KERNELS", folder},
                                   {"MORTISE_JACOBIANS", "own"}};
    // Two runs that need most kernels between them.
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{"--level", "4"}, {"--level", "3", "--refine", "1"}}) {
        std::vector<std::string> arguments = {asset("bracket.csg"), "-o", scratch.file("bracket.vtu"),
                                              "--json"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        CHECK(compiled_ahead(run(arguments, installed)) == 0);
    }
    CHECK(scratch.names("mortise").size() == 1);  // what the probe of the arithmetic found
    CHECK(scratch.names("compiled") == files);
}

TEST_CASE("kernels go to a folder that can be written, from a device that is there") {
    const ScratchFolder scratch;
    const Outcome unwritable = run({"kernels", "-o", "/dev/null/none"}, empty_caches(scratch));
    CHECK(unwritable.code == 6);
    CHECK(is_one_line(unwritable.err, "mortise: /dev/null/none: cannot be written"));
    const Outcome missing = run({"kernels", "--device", "no such device"}, empty_caches(scratch));
    CHECK(missing.code == 5);
    CHECK(is_one_line(missing.err, "mortise: "));
    CHECK(run({"kernels", "-o", scratch.file("a"), "-o", scratch.file("b")}, empty_caches(scratch)).code ==
          1);
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
