#include "host/model/file_content.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "mortise/error.hpp"

namespace mortise::model_reader {

std::string read_file(const std::string& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
        throw Error(ExitCode::kFiles, path + ": is a folder; expected a model file");
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (file && file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
    if (!file.is_open() || file.bad() || text.bad()) {
        const std::string cause = errno != 0 ? std::strerror(errno) : "input error";
        throw Error(ExitCode::kFiles, path + ": cannot be read: " + cause);
    }
    return text.str();
}

std::string format_of(const std::string& path) {
    std::string format = std::filesystem::path(path).extension().string();
    for (char& c : format) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    if (!format.empty()) format.erase(0, 1);
    return format;
}

}  // namespace mortise::model_reader
