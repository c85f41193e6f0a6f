// See kernel_source.hpp.
#include "host/device/kernel_source.hpp"

#include <cstdlib>
#include <filesystem>

#include "host/device/flatten.hpp"
#include "mortise/error.hpp"

namespace mortise::device {

std::string chosen_kernels_folder(const std::string& wanted) {
    const char* const folder = std::getenv("MORTISE_KERNELS");
    return wanted.empty() && folder != nullptr ? folder : wanted;
}

std::string kernel_source(const std::string& file, const std::string& folder) {
    if (!folder.empty()) {
        std::error_code error;
        if (!std::filesystem::is_directory(folder, error)) {
            throw Error(ExitCode::kDevice,
                        "kernel folder " + folder +
                            " (MORTISE_KERNELS) does not exist; unset it to use the built-in ones");
        }
        if (std::filesystem::exists(std::filesystem::path(folder) / file, error)) {
            return flatten_kernel(file, folder_reader(folder));
        }
    }
    for (std::size_t i = 0; i < kEmbeddedKernelCount; ++i) {
        const EmbeddedKernel& kernel = kEmbeddedKernels[i];
        if (file == kernel.file) return std::string(reinterpret_cast<const char*>(kernel.bytes), kernel.size);
    }
    throw Error(ExitCode::kDevice,
                "kernel file kernels/" + file + " is not built in; build Mortise again after adding it");
}

std::vector<std::string> embedded_kernels() {
    std::vector<std::string> files;
    for (std::size_t i = 0; i < kEmbeddedKernelCount; ++i) files.emplace_back(kEmbeddedKernels[i].file);
    return files;
}

}  // namespace mortise::device
