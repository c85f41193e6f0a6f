// `mortise MODEL -o FILE`: read, mesh, check, write, report.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/quality_text.hpp"
#include "host/cli/refusals.hpp"
#include "host/cli/signals.hpp"
#include "mortise/io.hpp"

namespace mortise::cli {
namespace {

constexpr double kChecking = 0.8;  // progress when the mesh is there
constexpr double kWriting = 0.9;

constexpr double kWorthTelling = 0.001;  // seconds

std::string seconds_text(double seconds) {
    char text[40];
    std::snprintf(text, sizeof text, "%.3f", seconds);
    return text;
}

/// Runs one stage of the command line and appends its times.
template <class Action>
void timed(const char* stage, std::vector<StageTime>& stages, std::uint64_t items, const Action& action) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    action();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
    stages.push_back({stage, seconds.count(),
                      static_cast<double>(std::clock() - cpu) / static_cast<double>(CLOCKS_PER_SEC), items});
}

/// "1200 at level 5, 340 at level 6"
std::string list_levels(const std::vector<std::uint64_t>& leaves) {
    std::string text;
    for (std::size_t level = 0; level < leaves.size(); ++level) {
        if (leaves[level] == 0) continue;
        text +=
            (text.empty() ? "" : ", ") + std::to_string(leaves[level]) + " at level " + std::to_string(level);
    }
    return text;
}

std::string summary(const Arguments& arguments, const Mesh& mesh, const MeshReport& report,
                    const MeshFigures& figures) {
    std::string text = arguments.file + ": " + std::to_string(mesh.element_count()) + " elements, " +
                       std::to_string(mesh.node_count()) + " nodes; level " + std::to_string(report.level) +
                       ", cell size " + short_number(report.cell_size) + "\n";
    if (!report.leaves.empty()) {
        text += "  cells      " + list_levels(report.leaves);
        if (report.transition_cells > 0) {
            const double each =
                static_cast<double>(figures.kinds[3]) / static_cast<double>(report.transition_cells);
            text += "; " + std::to_string(report.transition_cells) + " inside beside smaller ones";
            if (figures.kinds[3] > 0) text += ", of " + short_number(each, 3) + " elements each";
        }
        text += "\n";
    }
    text += "  elements   " + list_elements(figures.elements) + "\n";
    text += "  worst      scaled Jacobian " + list_jacobians(figures.elements, figures.min_scaled_jacobian) +
            "\n";
    double total = 0;
    std::string stages;
    for (const StageTime& stage : report.stages) {
        total += stage.wall_seconds;
        if (stage.wall_seconds < kWorthTelling) continue;
        stages += (stages.empty() ? ": " : ", ") + stage.stage + " " + seconds_text(stage.wall_seconds);
    }
    text += "  time       " + seconds_text(total) + " s" + stages + "\n";
    text += "  device     " + report.device + "\n";
    std::string files;
    for (const std::string& path : arguments.outputs) files += (files.empty() ? "" : ", ") + path;
    for (const std::string& path : {arguments.picture, arguments.report, arguments.features}) {
        if (!path.empty()) files += ", " + path;
    }
    return text + "  written    " + files + "\n";
}

void check_outputs(const Arguments& arguments) {
    for (const std::string& path : arguments.outputs) check_mesh_output(path);
    if (!arguments.picture.empty()) check_other_output("--picture", arguments.picture, ".png");
    if (!arguments.report.empty()) check_other_output("--report", arguments.report, ".json");
    if (!arguments.features.empty()) check_other_output("--features", arguments.features, ".vtp");
}

}  // namespace

ExitCode mesh_command(const Arguments& arguments) {
    check_outputs(arguments);
    Progress progress(arguments.quiet);
    MeshOptions options = arguments.options;
    options.progress = [&progress](const char* stage, double fraction) {
        report_aborts();  // the driver is open from some stage on
        progress.show(stage, fraction * kChecking);
        return true;
    };

    std::vector<StageTime> before, after;
    Model model;
    timed("read", before, 1, [&] { model = read_model(arguments.file, arguments.read); });
    // Said before the work, in case that fails.
    for (const std::string& warning : model.warnings) progress.warn(warning);
    MeshReport report;
    const Mesh mesh = generate_mesh(model, options, &report);
    for (const std::string& warning : report.warnings) progress.warn(warning);

    MeshFigures figures;
    progress.show("figures", kChecking);
    timed("figures", after, mesh.element_count(),
          [&] { figures = figures_of(mesh, report.scaled_jacobians); });
    refuse_inverted(figures);
    CheckReport check;
    if (arguments.check) {
        progress.show("check", kChecking);
        timed("check", after, mesh.element_count(), [&] { check = check_mesh(mesh); });
        refuse_defects(check);
    }
    progress.show("write", kWriting);
    timed("write", after, mesh.element_count(), [&] {
        for (const std::string& path : arguments.outputs) write_mesh(mesh, path, report.scaled_jacobians);
    });
    if (!arguments.features.empty()) {
        timed("write features", after, report.features.curves.size(),
              [&] { write_features(mesh, report.features, arguments.features); });
    }
    if (!arguments.picture.empty()) {
        timed("picture", after, mesh.facets.size(), [&] { write_picture(mesh, arguments.picture); });
    }
    report.stages.insert(report.stages.begin(), before.begin(), before.end());
    report.stages.insert(report.stages.end(), after.begin(), after.end());
    progress.clear();

    if (arguments.json || !arguments.report.empty()) {
        Json document = mesh_document(mesh, report, figures);
        document["model"] = arguments.file;
        document["outputs"] = arguments.outputs;
        if (arguments.check) document["check"] = check_document(check);
        if (report.quality) document["quality"] = quality_document(*report.quality, &report.features);
        const std::string text = to_text(document);
        if (!arguments.report.empty()) write_text(arguments.report, text);
        if (arguments.json) print(text);
    }
    if (!arguments.json && !arguments.quiet) print(summary(arguments, mesh, report, figures));
    if (!arguments.json && report.quality) print(quality_text(*report.quality, &report.features));
    refuse_below(mesh, report.scaled_jacobians, arguments.quality_floor);
    return ExitCode::kOk;
}

}  // namespace mortise::cli
