// read_model and parse_model: fetch the text, choose the reader.
#include <filesystem>

#include "host/model/csg/scad_program.hpp"
#include "host/model/file_content.hpp"
#include "host/model/readers.hpp"
#include "host/model/triangles/triangle_files.hpp"
#include "mortise/model.hpp"

namespace mortise {
namespace {

[[noreturn]] void unknown_format(const std::string& source, const std::string& format) {
    if (format == "dxf" || format == "svg") {
        throw Error(ExitCode::kInput,
                    source +
                        ": a plane drawing, not a solid; import it in a .csg or .scad file: "
                        "linear_extrude(height = 1) import(\"" +
                        std::filesystem::path(source).filename().string() + "\");");
    }
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

/// Messages name the .scad file and the place in its converted text.
Model read_scad(const std::string& text, const std::string& path, const ReadOptions& options) {
    model_reader::ConvertedScad converted = model_reader::convert_scad(path, text, options);
    ReadOptions others = options;
    others.definitions.clear();
    Model model = parse_model(converted.csg, "csg", path + " (as .csg)", others);
    model.source = path;
    model.regions.front().name = std::filesystem::path(path).stem().string();
    model.warnings.insert(model.warnings.begin(), converted.warnings.begin(), converted.warnings.end());
    return model;
}

}  // namespace

Model read_model(const std::string& path, const ReadOptions& options) {
    const std::string format = model_reader::format_of(path);
    // A missing file is a missing file, whatever its name.
    std::error_code ignored;
    const bool is_known = format == "scad" || is_known_format(format);
    if (!is_known && std::filesystem::exists(path, ignored) &&
        !std::filesystem::is_directory(path, ignored)) {
        unknown_format(path, format);
    }
    const std::string text = model_reader::read_file(path);
    if (format == "scad") return read_scad(text, path, options);
    return parse_model(text, format, path, options);
}

Model parse_model(const std::string& text, const std::string& given, const std::string& source,
                  const ReadOptions& options) {
    const std::string format = model_reader::format_named(given);
    if (format == "scad") {
        throw Error(ExitCode::kInput, source + ": a .scad file is read by its path only");
    }
    if (!is_known_format(format)) unknown_format(source, given);
    if (!options.definitions.empty()) {
        throw Error(ExitCode::kUsage, source + ": --define is for OpenSCAD's .scad files only");
    }
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
