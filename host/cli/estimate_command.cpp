// `mortise MODEL --dry-run`: what a run would make and take.
#include <cmath>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/kernels_ahead.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/signals.hpp"
#include "host/cli/text.hpp"

namespace mortise::cli {
namespace {

constexpr std::uint64_t kMostNodes = 0xfffffffeu;  ///< of a mesh: NodeId

/// Two digits.
std::string rough(double value) {
    if (value < 100) return rounded_text(value, 2);
    const double step = std::pow(10, std::floor(std::log10(value)) - 1);
    return std::to_string(std::llround(std::round(value / step) * step));
}

std::string rough_count(double value) {
    if (value >= 1e9) return rough(value / 1e9) + " billion";
    return value >= 1e6 ? rough(value / 1e6) + " million" : rough(value);
}

std::string bytes_text(double bytes) {
    return bytes >= 1e9 ? rough(bytes / 1e9) + " GB" : rough(bytes / 1e6) + " MB";
}

std::string estimate_text(const Arguments& arguments, const MeshEstimate& estimate) {
    const std::string about = estimate.is_exact ? "" : "about ";
    const auto count = [&](std::uint64_t value) {
        return estimate.is_exact ? std::to_string(value) : rough_count(static_cast<double>(value));
    };
    std::string text = arguments.file + ": " + about + count(estimate.elements) + " elements, " +
                       count(estimate.nodes) + " nodes; level " + std::to_string(estimate.level);
    if (estimate.finest_level != estimate.level) text += " to " + std::to_string(estimate.finest_level);
    text += ", cell size " + rounded_text(estimate.cell_size, 4) + "\n";
    text += "  cells      " + count(estimate.in_cells) + " inside, " + count(estimate.nio_cells) +
            " at the boundary\n";
    text += "  memory     about " + bytes_text(static_cast<double>(estimate.memory_bytes)) + "\n";
    const auto file_bytes = static_cast<double>(estimate.file_bytes);
    text += "  file       about " + bytes_text(file_bytes / 4) + " as .vtu, " + bytes_text(file_bytes) +
            " with --no-compress\n";
    return text + "  time       about " + rough(estimate.seconds) + " s, and writing files\n";
}

Json estimate_document(const Arguments& arguments, const MeshEstimate& estimate) {
    return {{"model", arguments.file},
            {"level", estimate.level},
            {"finest_level", estimate.finest_level},
            {"cell_size", estimate.cell_size},
            {"cells", {{"in", estimate.in_cells}, {"nio", estimate.nio_cells}}},
            {"elements", estimate.elements},
            {"nodes", estimate.nodes},
            {"memory_bytes", estimate.memory_bytes},
            {"file_bytes", estimate.file_bytes},
            {"seconds", estimate.seconds},
            {"is_exact", estimate.is_exact},
            {"warnings", estimate.warnings}};
}

}  // namespace

ExitCode estimate_command(const Arguments& arguments) {
    check_mesh_outputs(arguments.outputs, arguments.options);
    if (!arguments.report.empty()) check_other_output("--report", arguments.report, ".json");
    Progress progress(arguments.quiet);
    MeshOptions options = arguments.options;
    options.progress = [&progress](const char* stage, double fraction) {
        report_aborts();  // the driver is open from some stage on
        progress.show(stage, fraction);
        return true;
    };
    const Model model = read_model(arguments.file, arguments.read);
    for (const std::string& warning : model.warnings) progress.warn(warning);
    build_kernels_ahead(options, progress);
    const MeshEstimate estimate = Mesher(options.device, options.work_group_size).estimate(model, options);
    for (const std::string& warning : estimate.warnings) progress.warn(warning);
    if (estimate.nodes > kMostNodes)
        progress.warn("a mesh has " + rough_count(static_cast<double>(kMostNodes)) +
                      " nodes at most; use larger cells");
    progress.clear();
    const std::string document = to_text(estimate_document(arguments, estimate));
    if (!arguments.report.empty()) write_text(arguments.report, document);
    if (arguments.json) print(document);
    if (!arguments.json && !arguments.quiet) print(estimate_text(arguments, estimate));
    return ExitCode::kOk;
}

}  // namespace mortise::cli
