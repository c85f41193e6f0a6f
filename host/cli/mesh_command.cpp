// `mortise MODEL -o FILE`: read, mesh, check, write, report.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/kernels_ahead.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/quality_text.hpp"
#include "host/cli/refusals.hpp"
#include "host/cli/signals.hpp"
#include "host/cli/text.hpp"
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

/// The most memory that this process has had, bytes.
std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) << 10;
}

/// `check`: none if it was not asked for.
std::string summary(const Arguments& arguments, const MeshReport& report, const MeshFigures& figures,
                    const CheckReport* check) {
    std::string text = arguments.file + ": " + std::to_string(figures.element_count()) + " elements, " +
                       std::to_string(figures.nodes) + " nodes; level " + std::to_string(report.level) +
                       ", cell size " + rounded_text(report.cell_size, 4) + "\n";
    if (!report.leaves.empty()) {
        text += "  cells      " + list_levels(report.leaves);
        if (report.transition_cells > 0) {
            text += "; " + std::to_string(report.transition_cells) + " inside beside smaller ones";
            // What is left of templates: cells with hanging nodes are an element each.
            const std::uint64_t divided = report.transition_cells - report.hanging_cells;
            if (report.hanging_cells > 0)
                text += ", " + std::to_string(report.hanging_cells) + " of them hexahedra with hanging nodes";
            if (divided > 0 && figures.kinds[3] > report.hanging_cells)
                text += std::string(report.hanging_cells > 0 ? ", the others" : ",") + " of " +
                        rounded_text(static_cast<double>(figures.kinds[3] - report.hanging_cells) /
                                         static_cast<double>(divided),
                                     3) +
                        " elements each";
        }
        text += "\n";
    }
    text += "  elements   " + list_elements(figures.elements) + "\n";
    if (report.middle_nodes > 0) {
        text += "  order 2    " + std::to_string(report.middle_nodes) + " nodes in the middles of edges; " +
                std::to_string(report.curved_edges) + " edges are curved";
        if (report.relaxed_edges > 0)
            text += ", " + std::to_string(report.relaxed_edges) +
                    " less than the model, for the shape of elements there";
        text += "\n";
    }
    if (report.layers.facets > 0) {
        text += "  layers     " + std::to_string(report.layers.elements) + " elements, " +
                rounded_text(report.layers.thickness, 3) + " thick in the mean, on " +
                std::to_string(report.layers.facets - report.layers.bare) + " of " +
                std::to_string(report.layers.facets) + " facets\n";
    }
    for (const MeshFigures::Periodic& pair : figures.periodic)
        text += "  periodic   " + std::to_string(pair.nodes) + " nodes are copies of others, moved by " +
                place_text(pair.shift) + "\n";
    text += "  worst      scaled Jacobian " + list_jacobians(figures.elements, figures.min_scaled_jacobian);
    if (figures.worst_place) text += "; the lowest at " + place_text(*figures.worst_place);
    text += "\n";
    if (check != nullptr) {
        text += "  check      valid; volume " + rounded_text(check->volume, 9) + ", area " +
                rounded_text(check->boundary_area, 9) + ", Euler characteristic " +
                std::to_string(check->euler_characteristic) + ", " + counted(check->components, "component") +
                touching_text(*check) + "\n";
    }
    double total = 0;
    std::string stages;
    for (const StageTime& stage : report.stages) {
        total += stage.wall_seconds;
        if (stage.wall_seconds < kWorthTelling) continue;
        stages += (stages.empty() ? ": " : ", ") + stage.stage + " " + seconds_text(stage.wall_seconds);
    }
    text += "  time       " + seconds_text(total) + " s" + stages + "\n";
    text += "  device     " + report.device + "\n";
    if (arguments.in_parts) text += "  memory     " + std::to_string(peak_memory() >> 20) + " MiB at most\n";
    std::string files;
    for (const std::string& path : arguments.outputs) files += (files.empty() ? "" : ", ") + path;
    for (const std::string& path : {arguments.picture, arguments.report, arguments.features}) {
        if (!path.empty()) files += ", " + path;
    }
    return text + "  written    " + files + "\n";
}

void check_outputs(const Arguments& arguments) {
    check_mesh_outputs(arguments.outputs, arguments.options);
    if (!arguments.picture.empty()) check_other_output("--picture", arguments.picture, ".png");
    if (!arguments.report.empty()) check_other_output("--report", arguments.report, ".json");
    if (!arguments.features.empty()) check_other_output("--features", arguments.features, ".vtp");
}

/// What is told of a mesh once it is written.
struct Outcome {
    MeshReport report;
    MeshFigures figures;
    CheckReport check;
    std::string below_floor;        ///< empty: the quality floor is met
    std::vector<StageTime> stages;  ///< after those of the report
};

Outcome mesh_whole(const Arguments& arguments, const Model& model, const MeshOptions& options,
                   Progress& progress) {
    Outcome out;
    MeshReport& report = out.report;
    std::vector<StageTime>& stages = out.stages;
    const Mesh mesh = generate_mesh(model, options, &report);
    for (const std::string& warning : report.warnings) progress.warn(warning);

    progress.show("figures", kChecking);
    timed("figures", stages, mesh.element_count(),
          [&] { out.figures = figures_of(mesh, report.scaled_jacobians, options.threads); });
    refuse_inverted(out.figures);
    if (warn_of_slivers(out.figures, options, report)) progress.warn(report.warnings.back());
    if (arguments.check) {
        progress.show("check", kChecking);
        timed("check", stages, mesh.element_count(), [&] { out.check = check_mesh(mesh, options.threads); });
        refuse_defects(out.check);
    }
    progress.show("write", kWriting);
    MeshFileOptions file_options = arguments.file_options;
    file_options.walls = report.layers.surfaces;
    timed("write", stages, mesh.element_count(), [&] {
        for (const std::string& path : arguments.outputs)
            write_mesh(mesh, path, report.scaled_jacobians, file_options);
    });
    if (!arguments.features.empty()) {
        timed("write features", stages, report.features.curves.size(),
              [&] { write_features(mesh, report.features, arguments.features, file_options); });
    }
    if (!arguments.picture.empty()) {
        timed("picture", stages, mesh.facets.size(),
              [&] { write_picture(mesh, arguments.picture, arguments.picture_options); });
    }
    out.below_floor = below_floor(mesh, report.scaled_jacobians, arguments.quality_floor);
    return out;
}

/// Counts what passes on its way into the files.
class CountingSink : public MeshSink {
  public:
    CountingSink(const std::vector<std::string>& paths, const MeshFileOptions& options, double floor,
                 int threads)
        : floor_(floor), threads_(threads) {
        for (const std::string& path : paths)
            files_.push_back(std::make_unique<MeshFileStream>(path, options));
    }

    void begin(const MeshTotals& totals, const Mesh& outline) override {
        figures.add_outline(outline);
        for (const auto& file : files_) file->begin(totals, outline);
    }
    void add(const Mesh& part, const std::vector<float>& scaled_jacobians) override {
        figures.add_elements(part, scaled_jacobians, threads_);
        below += count_below(scaled_jacobians, floor_);
        for (const auto& file : files_) file->add(part, scaled_jacobians);
    }
    void commit() {
        for (const auto& file : files_) file->commit();
    }

    MeshFigures figures;
    std::uint64_t below = 0;

  private:
    double floor_;
    int threads_;
    std::vector<std::unique_ptr<MeshFileStream>> files_;
};

Outcome mesh_in_parts(const Arguments& arguments, const Model& model, const MeshOptions& options,
                      Progress& progress) {
    Outcome out;
    CountingSink sink(arguments.outputs, arguments.file_options, arguments.quality_floor, options.threads);
    Mesher(options.device, options.work_group_size).stream(model, options, sink, &out.report);
    for (const std::string& warning : out.report.warnings) progress.warn(warning);
    out.figures = sink.figures;
    refuse_inverted(out.figures);
    if (warn_of_slivers(out.figures, options, out.report)) progress.warn(out.report.warnings.back());
    progress.show("join", kWriting);
    timed("join", out.stages, out.figures.element_count(), [&] { sink.commit(); });
    const auto& worst = out.figures.min_scaled_jacobian;
    const auto type = std::min_element(worst.begin(), worst.end());
    out.below_floor =
        below_floor(sink.below, out.figures.element_count(), arguments.quality_floor,
                    "of the " + std::string(kElementNames[static_cast<std::size_t>(type - worst.begin())]) +
                        ": scaled Jacobian " + rounded_text(*type, 4));
    return out;
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

    std::vector<StageTime> before;
    Model model;
    timed("read", before, 1, [&] { model = read_model(arguments.file, arguments.read); });
    // Said before the work, in case that fails.
    for (const std::string& warning : model.warnings) progress.warn(warning);
    std::size_t programs = 0;
    timed("kernels", before, 0, [&] { programs = build_kernels_ahead(options, progress); });
    before.back().items = programs;
    if (programs == 0) before.pop_back();
    Outcome out = arguments.in_parts ? mesh_in_parts(arguments, model, options, progress)
                                     : mesh_whole(arguments, model, options, progress);
    MeshReport& report = out.report;
    report.stages.insert(report.stages.begin(), before.begin(), before.end());
    report.stages.insert(report.stages.end(), out.stages.begin(), out.stages.end());
    progress.clear();

    if (arguments.json || !arguments.report.empty()) {
        Json document = mesh_document(report, out.figures);
        document["model"] = arguments.file;
        document["outputs"] = arguments.outputs;
        document["peak_memory_bytes"] = peak_memory();
        if (arguments.check) document["check"] = check_document(out.check);
        if (report.quality) document["quality"] = quality_document(*report.quality, &report.features);
        const std::string text = to_text(document);
        if (!arguments.report.empty()) write_text(arguments.report, text);
        if (arguments.json) print(text);
    }
    if (!arguments.json && !arguments.quiet)
        print(summary(arguments, report, out.figures, arguments.check ? &out.check : nullptr));
    if (!arguments.json && report.quality) print(quality_text(*report.quality, &report.features));
    refuse_below(out.below_floor);
    return ExitCode::kOk;
}

}  // namespace mortise::cli
