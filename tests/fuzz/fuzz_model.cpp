// libFuzzer harness of the model readers: any bytes give a model or an Error, nothing else.
//
//   fuzz_model --format=csg -timeout=10 -rss_limit_mb=3000 CORPUS_FOLDER
//
// Files that a model imports are outside: its folder does not exist.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "mortise/model.hpp"

namespace {

std::string format = "csg";

}  // namespace

/// Fontconfig keeps some memory of its own when it loads its configuration.
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
    constexpr std::string_view kOption = "--format=";
    for (int k = 1; k < *argc; ++k) {
        const std::string_view argument = (*argv)[k];
        if (argument.substr(0, kOption.size()) == kOption) format = argument.substr(kOption.size());
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
        mortise::parse_model(text, format, "no-such-folder/model." + format, options);
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
