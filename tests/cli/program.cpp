// See program.hpp.
#include "tests/cli/program.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder() {
    path_ = (fs::temp_directory_path() / "mortise-test-XXXXXX").string();
    REQUIRE(mkdtemp(path_.data()) != nullptr);
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

std::string ScratchFolder::write(const std::string& name, const std::string& content) const {
    const fs::path path = file(name);
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path.string();
}

std::vector<std::string> ScratchFolder::names(const std::string& subfolder) const {
    fs::create_directories(file(subfolder));
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(file(subfolder))) {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

Program::Program(const std::vector<std::string>& arguments, const Environment& environment,
                 const std::string& out) {
    std::vector<std::string> words = {MORTISE_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<std::string> settings;
    for (const auto& [name, value] : environment) settings.push_back(name + "=" + value);
    for (char** inherited = environ; *inherited != nullptr; ++inherited) {
        const std::string setting = *inherited;
        const std::string name = setting.substr(0, setting.find('='));
        const bool replaced = std::any_of(environment.begin(), environment.end(),
                                          [&name](const auto& item) { return item.first == name; });
        if (!replaced) settings.push_back(setting);
    }
    std::vector<char*> argv, envp;
    for (std::string& word : words) argv.push_back(word.data());
    for (std::string& setting : settings) envp.push_back(setting.data());
    argv.push_back(nullptr);
    envp.push_back(nullptr);

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    const std::string out_path = out.empty() ? streams_.file("out") : out, err_path = streams_.file("err");
    const int flags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_path.c_str(), flags, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_path.c_str(), flags, 0600);
    // Shells start background jobs with SIGINT ignored; the program would respect that.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal_number);
    posix_spawnattr_setsigdefault(&attributes, &signals);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    start_ = std::chrono::steady_clock::now();
    REQUIRE(posix_spawn(&process_, MORTISE_PROGRAM, &files, &attributes, argv.data(), envp.data()) == 0);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
}

Program::~Program() {
    if (ended_) return;
    kill(process_, SIGKILL);
    waitpid(process_, &status_, 0);
}

bool Program::running() {
    if (!ended_) ended_ = waitpid(process_, &status_, WNOHANG) == process_;
    return !ended_;
}

void Program::send(int signal_number) const { kill(process_, signal_number); }

Outcome Program::wait() {
    if (!ended_) REQUIRE(waitpid(process_, &status_, 0) == process_);
    ended_ = true;
    Outcome outcome;
    outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (WIFEXITED(status_)) outcome.code = WEXITSTATUS(status_);
    if (WIFSIGNALED(status_)) outcome.signal = WTERMSIG(status_);
    outcome.out = read_file(streams_.file("out"));
    outcome.err = read_file(streams_.file("err"));
    return outcome;
}

Outcome run(const std::vector<std::string>& arguments, const Environment& environment) {
    return Program(arguments, environment).wait();
}

std::string read_file(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

bool is_one_line(const std::string& text, const std::string& beginning) {
    return text.compare(0, beginning.size(), beginning) == 0 && text.find('\n') == text.size() - 1;
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string asset(const std::string& name) {
    return std::string(MORTISE_SOURCE_DIR) + "/assets/models/" + name;
}
