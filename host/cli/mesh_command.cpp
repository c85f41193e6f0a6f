// `mortise MODEL -o FILE`: read, mesh, check, write, report.
#include <algorithm>
#include <chrono>
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
#include "host/cli/summary.hpp"
#include "host/cli/text.hpp"
#include "mortise/io.hpp"

namespace mortise::cli {
namespace {

constexpr double kChecking = 0.8;  // progress when the mesh is there
constexpr double kWriting = 0.9;

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
