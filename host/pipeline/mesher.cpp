// The order of the stages: the only code that knows two of them.
#include "mortise/mesher.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>

#include "host/assembly/assembly.hpp"
#include "host/cnio/extract.hpp"
#include "host/device/device.hpp"
#include "host/features/features.hpp"
#include "host/improve/improve.hpp"
#include "host/jacobian/jacobian.hpp"
#include "host/octree/coincident.hpp"
#include "host/octree/octree.hpp"
#include "host/pipeline/grading.hpp"
#include "host/pipeline/root_box.hpp"
#include "host/probe/probe.hpp"
#include "host/report/report.hpp"
#include "host/snio/classify.hpp"
#include "host/tape/compile.hpp"
#include "host/tetrahedra/split.hpp"
#include "host/triangles/divide.hpp"

namespace mortise {
namespace {

using pipeline::Root;

/// Surfaces closer than this everywhere are one: edges of the finest cells.
constexpr double kMergeDistance = 1e-4;

double process_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Times the stages of one run and reports progress.
class Stages {
  public:
    Stages(const MeshOptions& options, MeshReport& report) : options_(options), report_(report) {}

    void begin(const char* stage, double progress) {
        end(0);
        if (options_.progress && !options_.progress(stage, progress)) {
            throw Error(ExitCode::kMeshing, "interrupted");
        }
        stage_ = stage;
        wall_ = std::chrono::steady_clock::now();
        cpu_ = process_seconds();
    }

    void end(std::uint64_t items) {
        if (stage_ == nullptr) return;
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_;
        report_.stages.push_back({stage_, wall.count(), process_seconds() - cpu_, items});
        stage_ = nullptr;
    }

  private:
    const MeshOptions& options_;
    MeshReport& report_;
    const char* stage_ = nullptr;
    std::chrono::steady_clock::time_point wall_;
    double cpu_ = 0;
};

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

/// Model coordinates must tell apart the lattice steps that keep simplices from being flat (cnio::kMinHeight,
/// 6e-8 of a cell): farther from the origin, double precision would turn valid elements over.
void check_precision(const Root& root, int finest_level, const std::string& source) {
    constexpr double kMostCells = 2.5e8;
    const double cell = std::ldexp(root.side, -finest_level);
    double reach = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        reach = std::max({reach, std::fabs(root.origin[j]), std::fabs(root.origin[j] + root.side)});
    }
    if (reach <= kMostCells * cell) return;
    throw Error(ExitCode::kInput, source + ": coordinates up to " + number(reach) +
                                      " are too far from the origin for cells of " + number(cell) +
                                      "; move the model to the origin");
}

/// One line on the features smaller than a cell: how many, the largest, and which cells would show them all.
std::string describe_missed(const std::vector<MissedFeature>& missed, const Root& root) {
    std::size_t lost = 0;
    double thinnest = root.side;
    const MissedFeature* largest = nullptr;
    for (const MissedFeature& feature : missed) {
        if (!feature.kept) ++lost;
        thinnest = std::min(thinnest, feature.thickness);
        if (largest == nullptr || (largest->kept && !feature.kept)) largest = &feature;
    }
    // A ball holds a vertex of the grid, wherever it lies, if its diameter is that of a cell.
    int level = root.level;
    while (level < kMaxLevel && std::ldexp(root.side, -level) * std::sqrt(3.0) > thinnest) ++level;
    std::string text = std::to_string(missed.size()) + " feature" + (missed.size() == 1 ? "" : "s") +
                       " between the vertices of the grid, ";
    text += lost == 0 ? "kept coarsely" : std::to_string(lost) + " of them lost";
    text += std::string("; the largest") + (lost == 0 ? "" : " lost") + ": " +
            (largest->material ? "material, " : "a hole, ") + number(largest->size) + " long and " +
            number(largest->thickness) + " thick, at (" + number(largest->position[0]) + ", " +
            number(largest->position[1]) + ", " + number(largest->position[2]) + "); level " +
            std::to_string(level) + ", or --refine " + std::to_string(level - root.level) +
            ", would resolve ";
    return text + (missed.size() == 1 ? "it" : "them all");
}

void refuse_missed(const std::vector<MissedFeature>& missed, const Root& root, const std::string& source) {
    if (std::all_of(missed.begin(), missed.end(), [](const MissedFeature& f) { return f.kept; })) return;
    throw Error(ExitCode::kMeshing, source + ": strict: " + describe_missed(missed, root));
}

void check_options(const MeshOptions& options) {
    if (options.level < 0 || options.level > octree::kMaxUniformLevel) {
        throw Error(ExitCode::kUsage, "level " + std::to_string(options.level) +
                                          " is out of range; use 1 to " +
                                          std::to_string(octree::kMaxUniformLevel));
    }
    if (!(options.size >= 0) || !std::isfinite(options.size)) {
        throw Error(ExitCode::kUsage,
                    "cell size " + number(options.size) + " is out of range; use a positive length");
    }
    if (options.pieces < 1 || options.pieces > 4096) {
        throw Error(ExitCode::kUsage,
                    "pieces " + std::to_string(options.pieces) + " is out of range; use 1 to 4096");
    }
    if (options.refine < 0 || options.refine > kMaxLevel || options.interior_coarsening < 0) {
        throw Error(ExitCode::kUsage, "refinement by " + std::to_string(options.refine) +
                                          " and coarsening by " +
                                          std::to_string(options.interior_coarsening) +
                                          " levels is out of range; use 0 to " + std::to_string(kMaxLevel));
    }
    bool positive = options.size_min >= 0 && options.size_max >= 0 && options.curvature_elements >= 0 &&
                    std::isfinite(options.size_min + options.size_max + options.curvature_elements);
    for (const auto& [name, size] : options.named_sizes)
        positive = positive && size > 0 && std::isfinite(size);
    for (const SizeSource& source : options.sizes) {
        positive = positive && source.size > 0 && source.grading >= 0 && std::isfinite(source.size) &&
                   std::isfinite(source.grading) && std::isfinite(source.at[0] + source.at[1] + source.at[2]);
    }
    if (!positive) throw Error(ExitCode::kUsage, "cell sizes must be positive and finite");
    if (!options.box) return;
    for (std::size_t j = 0; j < 3; ++j) {
        if (!(options.box->min[j] < options.box->max[j]) ||
            !std::isfinite(options.box->max[j] - options.box->min[j])) {
            throw Error(ExitCode::kUsage, std::string("the box is empty along ") + "xyz"[j] +
                                              "; give its minimum corner, then its maximum corner");
        }
    }
}

/// Facets carry bound surfaces; the mesh lists names, each once and only those in use.
void name_surfaces(const tape::CompiledModel& compiled, const tape::BoundModel& model, Mesh& mesh) {
    std::vector<std::uint32_t> place(compiled.surface_names.size(), 0xffffffffu);
    std::vector<bool> present(compiled.surface_names.size(), false);
    for (const std::uint32_t surface : mesh.facets.surface) present[model.surface_name[surface]] = true;
    for (std::size_t i = 0; i < present.size(); ++i) {
        if (!present[i]) continue;
        place[i] = static_cast<std::uint32_t>(mesh.surface_names.size());
        mesh.surface_names.push_back(compiled.surface_names[i]);
    }
    for (std::uint32_t& surface : mesh.facets.surface) surface = place[model.surface_name[surface]];
}

/// Names the surfaces and classifies the nodes; the quality report if it is wanted.
void describe_mesh(const tape::CompiledModel& compiled, const tape::BoundModel& bound, const LeafGrid& leaves,
                   const MeshOptions& options, Stages& stages, Mesh& mesh, MeshReport& out) {
    stages.begin("features", 0.96);
    const std::vector<std::uint32_t> facet_surface = mesh.facets.surface;
    name_surfaces(compiled, bound, mesh);
    out.features = features::find_features(mesh, facet_surface, bound, leaves.level);
    mesh.model_dimension = out.features.model_dimension;
    stages.end(mesh.facets.size());
    if (!options.quality) return;
    stages.begin("quality", 0.97);
    out.quality = report::assess(mesh, facet_surface, bound, out.features,
                                 {leaves.level, kWorstElements, options.threads, &leaves});
    stages.end(mesh.element_count());
}

/// A region without elements: named in the file, but not in the mesh.
void warn_of_empty_regions(const Mesh& mesh, const std::string& source, MeshReport& report) {
    std::vector<bool> present(mesh.region_names.size() + 1, false);
    for (const ElementBlock& block : mesh.elements) {
        for (const std::uint16_t region : block.region) present[region] = true;
    }
    for (std::size_t r = 1; r < present.size() && mesh.element_count() > 0; ++r) {
        if (present[r]) continue;
        report.warnings.push_back(source + ": region '" + mesh.region_names[r - 1] +
                                  "' has no elements: it is empty, covered by regions before it, or thinner "
                                  "than the cells");
    }
}

/// What the report wants of all extractions.
struct Extracted {
    cnio::CellCounters counters;
    std::uint64_t troubled = 0;
};

/// Extraction and assembly, range by range of the Morton order; the pieces do not know each other until they
/// are merged.
Extracted mesh_pieces(device::Device& device, const MeshOptions& options, const tape::BoundModel& bound,
                      const octree::Octree& tree, octree::DeviceTree& on_device,
                      const snio::Classification& classification, const std::vector<probe::Apex>& apexes,
                      Stages& stages, Mesh* mesh) {
    Extracted result;
    const std::uint64_t words = tree.words();
    const std::uint64_t count = std::min<std::uint64_t>(static_cast<std::uint64_t>(options.pieces), words);
    const octree::InRegions in_regions(tree);
    std::vector<assembly::Piece> pieces;
    for (std::uint64_t p = 0; p < count; ++p) {
        assembly::MortonRange range;
        if (p > 0) range.begin = tree.code_of_word(words * p / count);
        if (p + 1 < count) range.end = tree.code_of_word(words * (p + 1) / count);
        const double done = static_cast<double>(p) / static_cast<double>(count);
        stages.begin("extract", 0.4 + 0.5 * done);
        const std::vector<std::uint32_t> leaves =
            count == 1 ? classification.cnio : assembly::leaves_needed(tree, classification.cnio, range);
        const cnio::Extraction extraction = cnio::extract(bound, tree, leaves, apexes, options.threads);
        result.counters.refused += extraction.counters.refused;
        result.counters.unresolved += extraction.counters.unresolved;
        result.troubled += extraction.troubled;
        stages.end(leaves.size());
        stages.begin("assemble", 0.4 + 0.5 * done + 0.3 / static_cast<double>(count));
        pieces.push_back(assembly::assemble(device, {bound, tree, on_device, classification, extraction,
                                                     in_regions, options.threads, range}));
        stages.end(pieces.back().mesh.element_count());
    }
    stages.begin("merge", 0.92);
    *mesh = assembly::merge(std::move(pieces));
    stages.end(mesh->element_count());
    return result;
}

}  // namespace

struct Mesher::Implementation {
    std::string choice;
    int work_group_size = 0;
    std::optional<device::Device> device;

    device::Device& open() {
        if (!device) {
            device::DeviceOptions options;
            options.work_group_size = work_group_size;
            device.emplace(choice, options);
        }
        return *device;
    }
};

Mesher::Mesher(std::string device, int work_group_size)
    : implementation_(new Implementation{std::move(device), work_group_size, {}}) {}
Mesher::~Mesher() = default;
Mesher::Mesher(Mesher&&) noexcept = default;
Mesher& Mesher::operator=(Mesher&&) noexcept = default;

Mesh generate_mesh(const Model& model, const MeshOptions& options, MeshReport* report) {
    return Mesher(options.device, options.work_group_size).generate(model, options, report);
}

Mesh Mesher::generate(const Model& model, const MeshOptions& options, MeshReport* report) {
    MeshReport local;
    MeshReport& out = report != nullptr ? *report : local;
    out = MeshReport{};
    check_options(options);
    Stages stages(options, out);

    stages.begin("compile", 0);
    const tape::CompiledModel compiled = tape::compile(model, options.box ? &*options.box : nullptr);
    const Box3 bounds = tape::find_bounds(compiled, model.source);
    const Root root = pipeline::choose_root(compiled, bounds, options);
    if (root.level > octree::kMaxUniformLevel) {
        throw Error(ExitCode::kUsage, "cells of size " + number(options.size) + " need level " +
                                          std::to_string(root.level) + "; a uniform tree has at most level " +
                                          std::to_string(octree::kMaxUniformLevel) +
                                          " yet; use larger cells");
    }
    tape::BoundModel bound = tape::bind(compiled, root.origin, root.side);
    std::optional<pipeline::Sizes> planned;
    planned.emplace(pipeline::plan_sizes(options, compiled, bound, bounds, root.level));
    if (!options.strict) {
        // Two surfaces that no cell can tell apart would only make slivers.
        const double distance = std::ldexp(kMergeDistance, -planned->levels.finest());
        tape::BoundModel merged = tape::bind(compiled, root.origin, root.side, distance);
        if (merged.nearly_equal > 0) {
            out.warnings.push_back(
                std::to_string(merged.nearly_equal) +
                " surfaces that lie within 1/10000 of a cell of another were taken for it; "
                "--strict keeps them apart");
            bound = std::move(merged);
            planned.emplace(pipeline::plan_sizes(options, compiled, bound, bounds, root.level));
        }
    }
    const pipeline::Sizes& sizes = *planned;
    const pipeline::Levels& levels = sizes.levels;
    check_precision(root, levels.finest(), model.source);
    stages.end(bound.surfaces.size());
    triangles::Division division;
    if (!bound.polyhedra.empty()) {
        stages.begin("polyhedra", 0.01);
        division = triangles::divide(bound, levels.base, levels.finest(), options.threads);
        stages.end(division.nodes);
    }
    if (division.crowded > 0) {
        const std::string text = std::to_string(division.crowded) +
                                 " cells hold more faces of triangles than a cell can show; small ones are "
                                 "left out; --refine, or smaller cells, would keep them";
        if (options.strict) throw Error(ExitCode::kMeshing, model.source + ": strict: " + text);
        out.warnings.push_back(text);
    }

    stages.begin("device", 0.02);
    device::Device& device = implementation_->open();
    out.device = device.info().name;
    const std::optional<jacobian::Method> jacobian_method = jacobian::wanted_method();
    stages.end(1);

    stages.begin("octree", 0.05);
    octree::DeviceTree on_device;
    octree::Octree tree = pipeline::build_tree(device, options, bound, sizes, &on_device);
    octree::drop_coincident(device, bound, tree, on_device, options.threads);
    stages.end(tree.cells_evaluated);

    stages.begin("probe", 0.28);
    probe::Probe probed = probe::find_features(bound, tree, options.threads);
    out.missed = std::move(probed.features);
    if (options.strict) refuse_missed(out.missed, root, model.source);
    stages.end(probed.probed);

    stages.begin("classify", 0.3);
    out.in_cells = tree.in_count;
    out.nio_cells = tree.nio.size();
    const auto transition_cells = static_cast<std::uint64_t>(
        std::count_if(tree.transitions.begin(), tree.transitions.end(),
                      [&tree](std::uint32_t leaf) { return tree.nio[leaf].tape_length == 0; }));
    std::vector<std::uint32_t> complex = probed.leaves;
    complex.insert(complex.end(), tree.transitions.begin(), tree.transitions.end());
    const snio::Classification classification =
        snio::classify(device, tree, on_device, options.templates, options.snap, complex);
    stages.end(tree.nio.size());

    const LeafGrid leaves = pipeline::leaf_grid(tree);
    Mesh mesh;
    const Extracted extracted =
        mesh_pieces(device, options, bound, tree, on_device, classification, probed.apexes, stages, &mesh);
    if (options.improve) {
        stages.begin("improve", 0.93);
        improve::Counters counters;
        mesh = improve::improve(std::move(mesh), bound,
                                {tree.level, options.smooth, options.threads, &leaves}, &counters);
        stages.end(counters.zone_elements);
    }
    mesh.region_names = compiled.region_names;
    warn_of_empty_regions(mesh, model.source, out);
    if (mesh.element_count() == 0) {
        throw Error(ExitCode::kInput, model.source +
                                          ": the solid is empty, or thinner than the cells everywhere; "
                                          "if it is not empty, use smaller cells, or --refine");
    }

    if (options.tetrahedra) {
        stages.begin("tetrahedra", 0.95);
        mesh = tetrahedra::split(mesh);
        stages.end(mesh.element_count());
    }
    describe_mesh(compiled, bound, leaves, options, stages, mesh, out);
    if (report != nullptr) {
        stages.begin("jacobians", 0.99);
        out.scaled_jacobians = jacobian::scaled_jacobians(
            device, mesh, jacobian_method.value_or(jacobian::usual_method(device, mesh.element_count())));
        stages.end(mesh.element_count());
    }

    out.level = root.level;
    out.cell_size = root.cell();
    out.finest_level = tree.level;
    if (tree.graded) {
        out.leaves.assign(static_cast<std::size_t>(tree.level) + 1, 0);
        for (const std::uint8_t leaf_level : tree.leaf_levels) ++out.leaves[leaf_level];
        out.transition_cells = transition_cells;
    }
    out.root = {root.origin,
                {root.origin[0] + root.side, root.origin[1] + root.side, root.origin[2] + root.side}};
    out.cells_evaluated = tree.cells_evaluated;
    out.cnio_cells = classification.cnio.size();
    out.snio_cells = out.nio_cells - out.cnio_cells;
    out.refused_splits = extracted.counters.refused;
    out.unresolved = extracted.counters.unresolved;
    out.dropped_features = extracted.troubled;
    out.warnings.insert(out.warnings.begin(), model.warnings.begin(), model.warnings.end());
    if (!out.missed.empty()) out.warnings.push_back(describe_missed(out.missed, root));
    if (extracted.troubled > 0) {
        const std::string text = std::to_string(extracted.troubled) + " of " +
                                 std::to_string(out.cnio_cells) +
                                 " complex cells hold features too fine to be kept exactly; --refine, or "
                                 "smaller cells, would keep more of them";
        // A split that is refused leaves out what is flatter than the lattice tells; only a cell that was
        // given up loses features.
        if (options.strict && extracted.counters.unresolved > 0) {
            throw Error(ExitCode::kMeshing, model.source + ": strict: " + text);
        }
        out.warnings.push_back(text);
    }
    return mesh;
}

}  // namespace mortise
