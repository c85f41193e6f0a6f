// Child processes and system figures; see process.hpp. POSIX, with Linux' /proc where it exists.
#include "bench/process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "mortise/error.hpp"

extern char** environ;

namespace mortise::bench {
namespace {

/// This process's environment with some variables replaced.
std::vector<std::string> merged_environment(const std::vector<std::pair<std::string, std::string>>& changes) {
    std::vector<std::string> result;
    for (char** entry = environ; *entry != nullptr; ++entry) {
        const std::string text = *entry;
        bool replaced = false;
        for (const auto& change : changes) {
            replaced = replaced || text.compare(0, change.first.size() + 1, change.first + "=") == 0;
        }
        if (!replaced) result.push_back(text);
    }
    for (const auto& change : changes) result.push_back(change.first + "=" + change.second);
    return result;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> result;
    for (std::string& text : texts) result.push_back(text.data());
    result.push_back(nullptr);
    return result;
}

std::string read_all(int file) {
    std::string text;
    std::array<char, 4096> chunk;
    for (;;) {
        const ssize_t count = read(file, chunk.data(), chunk.size());
        if (count > 0) text.append(chunk.data(), static_cast<std::size_t>(count));
        if (count == 0 || (count < 0 && errno != EINTR)) return text;
    }
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// CPU time of this process and of its children that have ended.
double own_cpu_seconds() {
    double sum = 0;
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage usage{};
        getrusage(who, &usage);
        sum += seconds(usage.ru_utime) + seconds(usage.ru_stime);
    }
    return sum;
}

/// Seconds of all cores since the machine started, from the first line of /proc/stat.
bool machine_seconds(double& busy, double& stolen, double& total) {
    std::ifstream file("/proc/stat");
    std::string label;
    std::array<double, 8> ticks{};  // user nice system idle iowait irq softirq steal
    file >> label;
    for (double& value : ticks) file >> value;
    if (!file || label != "cpu") return false;
    const double tick = 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK));
    busy = tick * (ticks[0] + ticks[1] + ticks[2] + ticks[5] + ticks[6]);
    stolen = tick * ticks[7];
    total = busy + stolen + tick * (ticks[3] + ticks[4]);
    return total > 0;
}

std::uint64_t status_bytes(const std::string& field) {
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);) {
        if (line.compare(0, field.size() + 1, field + ":") != 0) continue;
        std::istringstream rest(line.substr(field.size() + 1));
        std::uint64_t kibibytes = 0;
        rest >> kibibytes;
        return 1024 * kibibytes;
    }
    return 0;
}

}  // namespace

ProgramResult run_program(const std::vector<std::string>& arguments,
                          const std::vector<std::pair<std::string, std::string>>& environment,
                          bool merge_errors) {
    std::vector<std::string> argument_texts = arguments;
    std::vector<std::string> environment_texts = merged_environment(environment);
    const std::vector<char*> argument_list = pointers(argument_texts);
    const std::vector<char*> environment_list = pointers(environment_texts);

    int pipe_ends[2];
    if (pipe2(pipe_ends, O_CLOEXEC) != 0) {
        throw Error(ExitCode::kFiles, std::string("no pipe for a child process: ") + std::strerror(errno));
    }
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
    if (merge_errors) posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDERR_FILENO);

    const auto begin = std::chrono::steady_clock::now();
    pid_t child = 0;
    const int failure = posix_spawnp(&child, argument_list[0], &actions, nullptr, argument_list.data(),
                                     environment_list.data());
    posix_spawn_file_actions_destroy(&actions);
    close(pipe_ends[1]);
    if (failure != 0) {
        close(pipe_ends[0]);
        throw Error(ExitCode::kFiles, "cannot start '" + arguments[0] + "': " + std::strerror(failure) +
                                          "; expected a program that can be run");
    }
    ProgramResult result;
    result.output = read_all(pipe_ends[0]);
    close(pipe_ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    result.wall_seconds = wall.count();
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return result;
}

std::string own_path() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

bool is_on_path(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::string file = (folder.empty() ? "." : folder) + "/" + name;
        if (access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file)) return true;
    }
    return false;
}

ScratchFolder::ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "mortise_bench_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
        throw Error(ExitCode::kFiles, "cannot make the temporary folder '" + name +
                                          "': " + std::strerror(errno) +
                                          "; set TMPDIR to a folder that can be written to");
    }
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::uint64_t peak_resident_bytes() { return status_bytes("VmHWM"); }

std::uint64_t resident_bytes() { return status_bytes("VmRSS"); }

LoadWatch::LoadWatch() : own_(own_cpu_seconds()) {
    if (!machine_seconds(busy_, stolen_, total_)) total_ = 0;
}

LoadWatch::Load LoadWatch::so_far() const {
    double busy = 0;
    double stolen = 0;
    double total = 0;
    Load load;
    if (total_ <= 0 || !machine_seconds(busy, stolen, total) || total <= total_) return load;
    load.known = true;
    const double others = (busy - busy_) - (own_cpu_seconds() - own_);
    load.others = others > 0 ? others / (total - total_) : 0;
    load.stolen = (stolen - stolen_) / (total - total_);
    return load;
}

}  // namespace mortise::bench
