// The command as a whole, from the start of its process to the finished files; see sections.hpp.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/models.hpp"
#include "bench/print.hpp"
#include "bench/process.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "mortise/error.hpp"

namespace mortise::bench {
namespace {

using nlohmann::json;
using Environment = std::vector<std::pair<std::string, std::string>>;

constexpr const char* kBracket = MORTISE_SOURCE_DIR "/assets/models/bracket.csg";
constexpr const char* kWarmSize = "0.052";  ///< of cells
constexpr int kColdLevel = 5;
constexpr int kMostColdRuns = 3;

/// The section's result where it cannot be measured.
json skipped() {
    std::printf("  skipped: give the program with --mortise PATH\n");
    return {{"skipped", "no program given"}};
}

/// Runs the command to its end and returns its wall time. Throws Error(kMeshing) if it fails.
double time_command(const std::vector<std::string>& arguments, const Environment& environment = {}) {
    const ProgramResult result = run_program(arguments, environment, true);
    if (result.exit_code != 0) {
        throw Error(ExitCode::kMeshing, "'" + arguments.front() + "' ended with exit code " +
                                            std::to_string(result.exit_code) + ": " + result.output);
    }
    return result.wall_seconds;
}

void print_times(const char* what, const Samples& wall) {
    std::printf("  %-34s median of %zu: %s s (%s to %s)\n", what, wall.values.size(),
                short_number(wall.median()).c_str(), short_number(wall.low()).c_str(),
                short_number(wall.high()).c_str());
}

/// Runs with both caches of kernels empty. `compiled_kernels`: a folder of kernels that came with the
/// program.
Samples time_cold(const Settings& settings, const std::filesystem::path& folder,
                  const std::string& compiled_kernels) {
    Samples wall;
    for (int run = 0; run < std::min(settings.command_repeats, kMostColdRuns); ++run) {
        const std::filesystem::path cache = folder / "cache", pocl_cache = folder / "pocl-cache";
        std::filesystem::remove_all(cache);
        std::filesystem::remove_all(pocl_cache);
        std::filesystem::create_directories(pocl_cache);
        wall.values.push_back(time_command({settings.program, kBracket, "--level", std::to_string(kColdLevel),
                                            "-o", (folder / "x.vtu").string()},
                                           {{"MORTISE_CACHE", cache.string()},
                                            {"POCL_CACHE_DIR", pocl_cache.string()},
                                            {"MORTISE_COMPILED_KERNELS", compiled_kernels}}));
    }
    return wall;
}

}  // namespace

json command_section(const Settings& settings) {
    std::printf(
        "Whole command: wall time of `mortise bracket.csg -o x.vtu`, from start to end of the process, file\n"
        "included. Warm: 100,000 elements, kernels from the cache on disk (one run before is not counted).\n"
        "Cold: level %d, both caches empty, with kernels that came with the program (cmake --install) or "
        "none\n",
        kColdLevel);
    if (settings.program.empty()) return skipped();
    const ScratchFolder folder;
    const std::string file = (folder.path() / "x.vtu").string();
    announce("whole command, warm");
    Samples warm;
    for (int run = -1; run < settings.command_repeats; ++run) {
        std::filesystem::remove(file);
        const double seconds = time_command(
            {settings.program, kBracket, "--size", settings.level_limit < 5 ? "1" : kWarmSize, "-o", file});
        if (run >= 0) warm.values.push_back(seconds);
    }
    const std::uintmax_t bytes = std::filesystem::file_size(file);
    print_times("warm", warm);
    const std::string kernels = (folder.path() / "kernels").string();
    announce("whole command, cold, with compiled kernels");
    time_command({settings.program, "kernels", "-o", kernels});
    const Samples installed = time_cold(settings, folder.path(), kernels);
    print_times("cold, with compiled kernels", installed);
    announce("whole command, cold");
    const Samples cold = time_cold(settings, folder.path(), (folder.path() / "none").string());
    print_times("cold, compiling all that it needs", cold);
    return {{"model", "bracket"},
            {"warm_size", kWarmSize},
            {"seconds", to_json(warm)},
            {"file_bytes", bytes},
            {"cold_level", kColdLevel},
            {"cold_seconds", to_json(cold)},
            {"cold_with_compiled_kernels_seconds", to_json(installed)}};
}

json batch_section(const Settings& settings) {
    std::printf(
        "Many small models: `mortise batch` of %d random brackets, from start to end of the process, a .vtu\n"
        "file each; kernels come from the cache\n",
        settings.batch_models);
    if (settings.program.empty()) return skipped();
    announce("batch");
    const ScratchFolder folder;
    const std::filesystem::path list = folder.path() / "list", meshes = folder.path() / "meshes";
    std::ofstream names(list);
    for (int i = 0; i < settings.batch_models; ++i) {
        const std::filesystem::path model = folder.path() / ("bracket" + std::to_string(i) + ".csg");
        std::ofstream(model) << random_bracket(static_cast<std::uint32_t>(i));
        names << model.string() << "\n";
    }
    names.close();
    Samples wall;
    std::uint64_t elements = 0;
    for (int run = -1; run < std::min(settings.repeats, kMostColdRuns); ++run) {
        const ProgramResult result =
            run_program({settings.program, "batch", list.string(), "-o", meshes.string(), "--size",
                         settings.level_limit < 5 ? "1" : kRandomBracketCell, "--json"});
        if (result.exit_code != 0) {
            throw Error(ExitCode::kMeshing, "'" + settings.program + " batch' ended with exit code " +
                                                std::to_string(result.exit_code));
        }
        std::filesystem::remove_all(meshes);
        if (run < 0) continue;
        wall.values.push_back(result.wall_seconds);
        elements = 0;
        std::istringstream lines(result.output);
        for (std::string line; std::getline(lines, line);) {
            const json model = json::parse(line);
            for (const json& count : model.at("elements")) elements += count.get<std::uint64_t>();
        }
    }
    const double per_minute = 60 * settings.batch_models / wall.median();
    const double mean = static_cast<double>(elements) / settings.batch_models;
    print_times("all", wall);
    std::printf("  %s models/minute, of %s elements in the mean\n", short_number(per_minute).c_str(),
                grouped(static_cast<std::uint64_t>(mean)).c_str());
    return {{"models", settings.batch_models},
            {"seconds", to_json(wall)},
            {"models_per_minute", per_minute},
            {"mean_elements", mean}};
}

}  // namespace mortise::bench
