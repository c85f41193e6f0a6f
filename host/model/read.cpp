// read_model and parse_model: fetch the text, choose the reader.
#include <filesystem>

#include "host/model/file_content.hpp"
#include "host/model/readers.hpp"
#include "host/model/triangles/triangle_files.hpp"
#include "mortise/model.hpp"

namespace mortise {
namespace {

[[noreturn]] void unknown_format(const std::string& source, const std::string& format) {
    throw Error(ExitCode::kInput,
                source + ": unknown model format '" + format +
                    "'; expected .csg (OpenSCAD), .geo (Netgen), .stl, .obj, .off, .formula, "
                    ".vm (Fidget) or .frep (libfive)");
}

bool is_function(const std::string& format) {
    return format == "vm" || format == "frep" || format == "formula";
}

bool is_known_format(const std::string& format) {
    return format == "csg" || format == "geo" || model_reader::is_triangle_format(format) ||
           is_function(format);
}

}  // namespace

Model read_model(const std::string& path, const ReadOptions& options) {
    const std::string format = model_reader::format_of(path);
    // A missing file is a missing file, whatever its name.
    const std::string text = model_reader::read_file(path);
    if (!is_known_format(format)) unknown_format(path, format);
    return parse_model(text, format, path, options);
}

Model parse_model(const std::string& text, const std::string& format, const std::string& source,
                  const ReadOptions& options) {
    if (!is_known_format(format)) unknown_format(source, format);
    if (options.extrude != 0 && !is_function(format)) {
        throw Error(ExitCode::kUsage,
                    source + ": --extrude is for functions of x and y (.vm, .frep, .formula) only");
    }
    if (format == "geo") return model_reader::read_geo(text, source);
    const std::string stem = std::filesystem::path(source).stem().string();
    const std::string region = stem.empty() ? "solid" : stem;
    if (model_reader::is_triangle_format(format)) {
        return model_reader::read_triangle_model(text, format, source, region);
    }
    if (format == "vm") return model_reader::read_vm(text, source, region, options);
    if (format == "frep") return model_reader::read_frep(text, source, region, options);
    if (format == "formula") return model_reader::read_formula(text, source, region, options);
    return model_reader::read_csg(text, source, region, options.facets);
}

}  // namespace mortise
