// See kernel_cache.hpp. Linux only: dladdr and /proc tell where this code is.
#include "host/device/kernel_cache.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "host/device/environment.hpp"

namespace mortise::device {
namespace {

namespace fs = std::filesystem;

/// The folder of the program, or of the shared library, that holds this function; empty if it is not known.
fs::path own_folder() {
    std::error_code error;
    Dl_info place{};
    if (dladdr(reinterpret_cast<const void*>(&installed_kernel_folders), &place) != 0) {
        // Of a program this is how it was called, which may be a mere name.
        const fs::path file = place.dli_fname;
        const fs::path found = file.has_parent_path() ? fs::canonical(file, error) : fs::path();
        if (!found.empty()) return found.parent_path();
    }
    return fs::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace

std::vector<std::string> installed_kernel_folders() {
    const char* const chosen = std::getenv("MORTISE_COMPILED_KERNELS");
    if (chosen != nullptr && *chosen != '\0') return {chosen};
    const fs::path here = own_folder();
    if (here.empty()) return {};
    std::vector<std::string> folders;
    for (const char* const way : {".", "mortise", MORTISE_PROGRAM_TO_LIBRARIES "/mortise"})
        folders.push_back((here / way / "compiled-kernels").lexically_normal().string());
    return folders;
}

std::string chosen_cache_folder(const DeviceOptions& options) {
    if (!options.disk_cache) return {};
    return options.cache_folder.empty() ? cache_folder() : options.cache_folder;
}

DiskCache kernel_cache(const DeviceOptions& options) {
    const bool uses_installed = options.disk_cache && options.cache_folder.empty();
    return DiskCache(chosen_cache_folder(options),
                     uses_installed ? installed_kernel_folders() : std::vector<std::string>{});
}

}  // namespace mortise::device
