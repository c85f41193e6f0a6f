// See files.hpp.
#include "host/cli/files.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "host/common/lower_case.hpp"
#include "host/io/temporary_file.hpp"
#include "mortise/error.hpp"

namespace mortise::cli {
namespace {

/// Permissions do not tell everything (full disks, special file systems): makes a file and removes it.
void try_folder(const std::string& path) { const io::TemporaryFile attempt(path); }

}  // namespace

MeshTraits traits_of(const MeshOptions& options) {
    return {options.hanging, options.second_order, !options.tetrahedra};
}

void check_mesh_output(const std::string& path) {
    check_writable(path);
    if (!is_mesh_folder(path)) try_folder(path);
}

void check_mesh_outputs(const std::vector<std::string>& paths, const MeshOptions& options) {
    for (const std::string& path : paths) {
        check_mesh_format(path, traits_of(options));
        check_mesh_output(path);
    }
}

void check_other_output(const std::string& option, const std::string& path, const std::string& extension) {
    const std::filesystem::path name(path);
    if (lower_case(name.extension().string()) != extension) {
        throw Error(ExitCode::kUsage, option + " '" + path + "': expected a name that ends in " + extension);
    }
    try_folder(path);
}

bool is_same_file(const std::string& first, const std::string& second) {
    const auto place = [](const std::string& name) {
        std::error_code ignored;
        return std::filesystem::weakly_canonical(std::filesystem::absolute(name, ignored), ignored);
    };
    return first == second || place(first) == place(second);
}

void write_text(const std::string& path, const std::string& text) {
    io::TemporaryFile file(path);
    file.write(text);
    file.commit();
}

void print(const std::string& text) {
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
        throw Error(ExitCode::kFiles,
                    std::string("cannot write to the standard output: ") + std::strerror(errno));
    }
}

}  // namespace mortise::cli
