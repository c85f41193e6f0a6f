// The lists of programs that are built and loaded ahead.
#include "host/pipeline/programs.hpp"

#include <doctest/doctest.h>

#include <set>
#include <string>

using namespace mortise;

TEST_CASE("what is loaded ahead is what is built ahead, but for what a run asks for at once") {
    std::multiset<std::string> later = {"probe.cl ", "octree/descend.cl "}, usual;
    for (const device::ProgramName& name : pipeline::kLaterPrograms)
        later.insert(name.file + " " + name.defines);
    for (const device::ProgramName& name : pipeline::kUsualPrograms)
        usual.insert(name.file + " " + name.defines);
    CHECK(later == usual);
}
