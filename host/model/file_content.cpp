#include "host/model/file_content.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "host/common/lower_case.hpp"
#include "mortise/error.hpp"

namespace mortise::model_reader {

std::string read_file(const std::string& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
        throw Error(ExitCode::kFiles, path + ": is a folder; expected a model file");
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::string text;
    if (file.is_open()) {
        // Files of known size in one piece; pipes grow as they come.
        const std::uintmax_t size = std::filesystem::file_size(path, ignored);
        constexpr std::size_t kPart = 1 << 16;
        std::size_t part = ignored ? kPart : static_cast<std::size_t>(size) + 1;
        while (file) {
            const std::size_t before = text.size();
            text.resize(before + part);
            file.read(&text[before], static_cast<std::streamsize>(part));
            text.resize(before + static_cast<std::size_t>(file.gcount()));
            part = std::max(kPart, before);
        }
    }
    if (!file.is_open() || file.bad()) {
        const std::string cause = errno != 0 ? std::strerror(errno) : "input error";
        throw Error(ExitCode::kFiles, path + ": cannot be read: " + cause);
    }
    return text;
}

std::string format_of(const std::string& path) {
    return format_named(std::filesystem::path(path).extension().string());
}

std::string format_named(std::string extension) {
    if (!extension.empty() && extension.front() == '.') extension.erase(0, 1);
    return lower_case(std::move(extension));
}

}  // namespace mortise::model_reader
