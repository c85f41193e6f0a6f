// Folders that are made for a mesh, and a signal at any time.
#include <doctest/doctest.h>

#include <signal.h>
#include <sys/stat.h>
#include <sys/time.h>

#include <string>

#include "host/io/temporary_file.hpp"
#include "tests/io/folder.hpp"

namespace {

using namespace mortise;

char folder_name[4096];
volatile sig_atomic_t left_behind = 0, arrived = 0;

void end_of_run(int) {
    arrived = arrived + 1;
    io::remove_temporary_files();
    struct stat status;
    if (stat(folder_name, &status) == 0) left_behind = left_behind + 1;
}

}  // namespace

TEST_CASE("a signal at any time leaves no new folder") {
    const Folder parent;
    const std::string path = parent.file("polyMesh");
    path.copy(folder_name, sizeof folder_name - 1);
    struct sigaction action {
    }, before{};
    action.sa_handler = end_of_run;
    action.sa_flags = SA_RESTART;
    REQUIRE(sigaction(SIGALRM, &action, &before) == 0);
    const itimerval often = {{0, 50}, {0, 50}};  // microseconds
    REQUIRE(setitimer(ITIMER_REAL, &often, nullptr) == 0);
    for (int i = 0; i < 1000000 && arrived < 3000; ++i) const io::NewFolder folder(path);
    const itimerval never = {};
    setitimer(ITIMER_REAL, &never, nullptr);
    sigaction(SIGALRM, &before, nullptr);
    CHECK(arrived >= 1000);
    CHECK(left_behind == 0);
}
