// Broken surroundings of the OpenCL driver. They must be in place before the first OpenCL call, so each case
// runs this program again, with another environment, for one test case that is skipped otherwise.
#include "host/device/environment.hpp"

#include <doctest/doctest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "host/device/device.hpp"
#include "host/device/doctor.hpp"
#include "scratch.hpp"

using namespace mortise;
using namespace mortise::device;

namespace {

/// Exit status of this program run for one test case with `environment` ("A=b C=d"); -1 if it has none of
/// this name: doctest takes what a comma parts for several names, and is content with none.
int run_again(const std::string& environment, const std::string& test_case) {
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command =
        "env " + environment + " '" + self + "' --no-skip --test-case='" + test_case + "'";
    FILE* const pipe = popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::string output;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output += static_cast<char>(c);
    const int status = pclose(pipe);
    INFO(output);
    CHECK(WIFEXITED(status));
    const std::string told = "test cases:";  // and how many have run
    const std::size_t at = output.find(told);
    const bool has_run = at != std::string::npos && std::atoi(output.c_str() + at + told.size()) == 1;
    CHECK_MESSAGE(has_run, "no test case \"" << test_case << "\"");
    return WIFEXITED(status) && has_run ? WEXITSTATUS(status) : -1;
}

void open_and_compute() {
    DeviceOptions options;
    options.disk_cache = false;  // so that the driver must build
    Device device("cpu", options);
    const Buffer in = device.upload(std::vector<std::uint32_t>{1, 2, 3});
    Buffer out = device.allocate(16);
    CHECK(device.exclusive_scan_u32(in, out, 3) == 6);
}

const DoctorLine& line(const std::vector<DoctorLine>& lines, const std::string& what) {
    for (const DoctorLine& candidate : lines) {
        if (candidate.what == what) return candidate;
    }
    FAIL("no line " << what);
    return lines.front();
}

}  // namespace

TEST_CASE("child: no driver" * doctest::skip()) {
    CHECK(list_devices().empty());
    CHECK(contains(device_error([] { Device(""); }), "apt-get install pocl-opencl-icd"));
    const std::vector<DoctorLine> lines = doctor();
    CHECK_FALSE(line(lines, "OpenCL devices").ok);
    CHECK(contains(line(lines, "OpenCL devices").remedy, "pocl-opencl-icd"));
}

TEST_CASE("no OpenCL driver: an empty list, and what to install") {
    ScratchFolder empty;
    CHECK(run_again("OCL_ICD_VENDORS='" + empty.path() + "'", "child: no driver") == 0);
}

TEST_CASE("child: no linker" * doctest::skip()) {
    CHECK(contains(device_error([] { Device("cpu"); }), "apt-get install binutils"));
    CHECK_FALSE(line(doctor(), "linker on PATH").ok);
}

TEST_CASE("no linker: named before PoCL aborts") {
    ScratchFolder empty;
    CHECK(run_again("PATH='" + empty.path() + "'", "child: no linker") == 0);
}

TEST_CASE("child: empty POCL_CACHE_DIR" * doctest::skip()) {
    open_and_compute();
    CHECK(std::getenv("POCL_CACHE_DIR") == nullptr);
}

TEST_CASE("an empty POCL_CACHE_DIR is unset") {
    CHECK(run_again("POCL_CACHE_DIR=", "child: empty POCL_CACHE_DIR") == 0);
}

TEST_CASE("child: unwritable cache" * doctest::skip()) {
    const std::vector<DoctorLine> lines = doctor("cpu");
    CHECK_FALSE(line(lines, "PoCL's cache folder").ok);
    CHECK_FALSE(line(lines, "Mortise's cache folder").ok);
    CHECK(line(lines, "kernels build").ok);
    open_and_compute();
    CHECK(is_writable_folder(std::getenv("POCL_CACHE_DIR")));
}

TEST_CASE("cache folders that cannot be written are replaced or done without") {
    CHECK(run_again("-u POCL_CACHE_DIR -u MORTISE_CACHE XDG_CACHE_HOME=/dev/null/cache",
                    "child: unwritable cache") == 0);
    CHECK(run_again("-u MORTISE_CACHE -u XDG_CACHE_HOME HOME=/dev/null POCL_CACHE_DIR=/dev/null/cache",
                    "child: unwritable cache") == 0);
    CHECK(run_again("-u POCL_CACHE_DIR -u MORTISE_CACHE -u XDG_CACHE_HOME -u HOME",
                    "child: unwritable cache") == 0);
}

TEST_CASE("child: small and large launches" * doctest::skip()) {
    DeviceOptions options;
    options.probe = false;
    Device device("cpu", options);
    for (const std::size_t count : {std::size_t{3}, std::size_t{1} << 20}) {
        const Buffer in = device.upload(std::vector<std::uint32_t>(count, 1));
        Buffer out = device.allocate((count + 1) * sizeof(std::uint32_t));
        CHECK(device.exclusive_scan_u32(in, out, count) == count);
    }
}

TEST_CASE("PoCL compiles each kernel once, for launches of every size") {
    if (list_devices()[choose_device("cpu", list_devices())].platform != "Portable Computing Language")
        return;
    ScratchFolder folder;
    REQUIRE(run_again("-u POCL_WORK_GROUP_SPECIALIZATION POCL_CACHE_DIR='" + folder.path() +
                          "' MORTISE_CACHE='" + folder.path() + "'",
                      "child: small and large launches") == 0);
    std::vector<std::string> compiled;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
        if (entry.path().extension() == ".so") compiled.push_back(entry.path().stem().string());
    }
    std::sort(compiled.begin(), compiled.end());
    CHECK(compiled == std::vector<std::string>{"scan_fill", "scan_sums"});
}

TEST_CASE("child: what PoCL is told" * doctest::skip()) {
    const std::string wanted = std::getenv("MORTISE_TEST_METHOD");
    prepare_environment();
    CHECK(std::getenv("POCL_WORK_GROUP_METHOD") == wanted);
}

TEST_CASE("PoCL runs work-items one by one, unless told otherwise") {
    CHECK(run_again("-u POCL_WORK_GROUP_METHOD MORTISE_TEST_METHOD=loops", "child: what PoCL is told") == 0);
    CHECK(run_again("POCL_WORK_GROUP_METHOD=cbs MORTISE_TEST_METHOD=cbs", "child: what PoCL is told") == 0);
}

TEST_CASE("the cache folder follows the environment") {
    const Variable xdg("XDG_CACHE_HOME", "/cache");
    {
        const Variable own("MORTISE_CACHE", "/own");
        CHECK(cache_folder() == "/own");
    }
    {
        const Variable own("MORTISE_CACHE", "");
        CHECK(cache_folder() == "/cache/mortise");
        const Variable none("XDG_CACHE_HOME", "");
        const Variable home("HOME", "/home/me");
        CHECK(cache_folder() == "/home/me/.cache/mortise");
        const Variable homeless("HOME", "");
        CHECK(cache_folder().empty());
    }
    CHECK_FALSE(is_writable_folder(""));
    CHECK_FALSE(is_writable_folder("/dev/null/x"));
    CHECK(find_on_path("no-such-program-anywhere").empty());
    CHECK(contains(find_on_path("ls"), "/ls"));
}
