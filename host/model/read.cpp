// read_model and parse_model: fetch the text, choose the reader.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/model/readers.hpp"
#include "host/model/triangle_files.hpp"
#include "mortise/model.hpp"

namespace mortise {
namespace {

std::string lower_case(std::string text) {
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

std::string read_text(const std::string& path) {
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

[[noreturn]] void unknown_format(const std::string& source, const std::string& format) {
    throw Error(ExitCode::kInput, source + ": unknown model format '" + format +
                                      "'; expected .csg (OpenSCAD), .geo (Netgen), .stl, .obj or .off");
}

bool is_known_format(const std::string& format) {
    return format == "csg" || format == "geo" || model_reader::is_triangle_format(format);
}

}  // namespace

Model read_model(const std::string& path, const ReadOptions& options) {
    std::string format = lower_case(std::filesystem::path(path).extension().string());
    if (!format.empty()) format.erase(0, 1);
    // A missing file is a missing file, whatever its name.
    const std::string text = read_text(path);
    if (!is_known_format(format)) unknown_format(path, format);
    return parse_model(text, format, path, options);
}

Model parse_model(const std::string& text, const std::string& format, const std::string& source,
                  const ReadOptions& options) {
    if (!is_known_format(format)) unknown_format(source, format);
    if (format == "geo") return model_reader::read_geo(text, source);
    const std::string stem = std::filesystem::path(source).stem().string();
    const std::string region = stem.empty() ? "solid" : stem;
    if (model_reader::is_triangle_format(format)) {
        return model_reader::read_triangle_model(text, format, source, region);
    }
    return model_reader::read_csg(text, source, region, options.facets);
}

}  // namespace mortise
