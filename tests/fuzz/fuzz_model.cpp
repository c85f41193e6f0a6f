// libFuzzer harness of the model readers: any bytes give a model or an Error, nothing else.
//
//   fuzz_model --format=csg -timeout=10 -rss_limit_mb=3000 CORPUS_FOLDER
//
// Formats are those of models, and those of files that a .csg model imports: dxf, svg, and dat and png of
// surface(). The latter are written to a file of this process, which a model then imports. Files that an
// input itself imports are outside: its folder does not exist.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "mortise/model.hpp"

namespace {

std::string format = "csg";
std::string imported_file;  // empty: the input is a model

void remove_imported_file() { std::remove(imported_file.c_str()); }

/// The input as what a model imports, in one of a few ways that its size chooses.
mortise::Model import_of(const std::string& content, const mortise::ReadOptions& options) {
    std::ofstream(imported_file, std::ios::binary) << content;
    const std::string file = "(file = \"" + imported_file + "\"";
    const std::string center = content.size() % 3 == 0 ? ", center = true" : "";
    std::string text;
    if (format == "dat" || format == "png") {
        text = "surface" + file + center + ");";
    } else {
        const std::string import =
            "import" + file + center + (content.size() % 5 == 0 ? ", $fn = 7);" : ");");
        switch (content.size() / 2 % 4) {
            case 0: text = "linear_extrude(height = 2) { " + import + " }"; break;
            case 1: text = "linear_extrude(height = 2, twist = 30, scale = 0.5) { " + import + " }"; break;
            case 2: text = "linear_extrude(height = 2) { offset(delta = 0.1) { " + import + " } }"; break;
            default:
                text = "rotate_extrude(angle = 90) { intersection() { square(size = [1e3, 1e3]); " + import +
                       " } }";
        }
    }
    return mortise::parse_model(text, "csg", "no-such-folder/model.csg", options);
}

}  // namespace

/// Fontconfig keeps some memory of its own when it loads its configuration.
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
    constexpr std::string_view kOption = "--format=";
    for (int k = 1; k < *argc; ++k) {
        const std::string_view argument = (*argv)[k];
        if (argument.substr(0, kOption.size()) == kOption) format = argument.substr(kOption.size());
    }
    if (format == "dxf" || format == "svg" || format == "dat" || format == "png") {
        const std::string name = "fuzz_model_" + std::to_string(getpid()) + "." + format;
        imported_file = (std::filesystem::temp_directory_path() / name).string();
        std::atexit(remove_imported_file);
    }
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    mortise::ReadOptions options;
    // Both ways of every option, chosen by the input so that a finding repeats.
    if (size % 2 == 1) options.facets = mortise::Facets::kExact;
    const bool is_function = format == "vm" || format == "frep" || format == "formula";
    if (is_function && size % 2 == 1) options.extrude = 1;
    try {
        if (imported_file.empty()) {
            mortise::parse_model(text, format, "no-such-folder/model." + format, options);
        } else {
            import_of(text, options);
        }
    } catch (const mortise::Error& error) {
        const mortise::ExitCode code = error.code();
        if (code == mortise::ExitCode::kInput || code == mortise::ExitCode::kFiles) return 0;
        // The height fits functions of x and y only.
        if (code == mortise::ExitCode::kUsage && options.extrude != 0) return 0;
        std::fprintf(stderr, "unexpected error: %s\n", error.what());
        std::abort();
    }
    return 0;
}
