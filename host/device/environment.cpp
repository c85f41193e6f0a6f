// See environment.hpp. POSIX only: mkdtemp and unlink-safe temporary names.
#include "host/device/environment.hpp"

#include <stdlib.h>  // setenv, mkdtemp
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <sstream>
#include <system_error>
#include <vector>

namespace mortise::device {
namespace {

namespace fs = std::filesystem;

/// Value of an environment variable; unset and empty are the same.
std::string variable(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? std::string() : std::string(value);
}

/// ~/.cache or what stands for it, with `name` appended; empty if neither variable is set.
std::string below_user_cache(const char* name) {
    const std::string xdg = variable("XDG_CACHE_HOME");
    if (!xdg.empty()) return (fs::path(xdg) / name).string();
    const std::string home = variable("HOME");
    return home.empty() ? std::string() : (fs::path(home) / ".cache" / name).string();
}

}  // namespace

bool is_writable_folder(const std::string& folder) {
    if (folder.empty()) return false;
    std::error_code error;
    fs::create_directories(folder, error);
    std::string name = folder + "/writable-XXXXXX";
    const int file = mkstemp(name.data());
    if (file < 0) return false;
    close(file);
    unlink(name.c_str());
    return true;
}

std::string pocl_cache_folder() {
    const std::string chosen = variable("POCL_CACHE_DIR");
    if (!chosen.empty()) return chosen;
    return below_user_cache("pocl/kcache");
}

void prepare_environment() {
    static std::once_flag once;
    std::call_once(once, [] {
        const char* const chosen = std::getenv("POCL_CACHE_DIR");
        if (chosen != nullptr && *chosen == '\0') unsetenv("POCL_CACHE_DIR");
        setenv("POCL_WORK_GROUP_SPECIALIZATION", "0", 0);
        setenv("POCL_WORK_GROUP_METHOD", "loops", 0);
        if (is_writable_folder(pocl_cache_folder())) return;
        std::error_code error;
        std::string folder = (fs::temp_directory_path(error) / "mortise-pocl-XXXXXX").string();
        if (mkdtemp(folder.data()) != nullptr) {
            setenv("POCL_CACHE_DIR", folder.c_str(), 1);
            static std::string to_remove;
            to_remove = folder;
            std::atexit([] {
                std::error_code ignored;
                fs::remove_all(to_remove, ignored);
            });
        }
    });
}

void limit_driver_threads(int threads) {
    setenv("POCL_MAX_PTHREAD_COUNT", std::to_string(threads).c_str(), 0);
}

std::string find_on_path(const std::string& program) {
    std::istringstream folders(variable("PATH"));
    std::string folder;
    while (std::getline(folders, folder, ':')) {
        const std::string candidate = (folder.empty() ? "." : folder) + "/" + program;
        if (access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    return {};
}

std::string cache_folder() {
    const std::string chosen = variable("MORTISE_CACHE");
    return chosen.empty() ? below_user_cache("mortise") : chosen;
}

}  // namespace mortise::device
