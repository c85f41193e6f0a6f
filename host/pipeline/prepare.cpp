#include "host/pipeline/prepare.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/cnio/extract.hpp"
#include "host/common/message_text.hpp"
#include "host/octree/coincident.hpp"
#include "host/octree/poles.hpp"
#include "host/pipeline/findings.hpp"
#include "host/pipeline/grading.hpp"
#include "host/pipeline/memory_limit.hpp"
#include "host/pipeline/names.hpp"
#include "host/pipeline/programs.hpp"
#include "host/pipeline/snap.hpp"
#include "host/pipeline/thin_solids.hpp"
#include "host/probe/overlaps.hpp"
#include "host/reposition/reposition.hpp"
#include "host/triangles/divide.hpp"

namespace mortise::pipeline {
namespace {

/// For each of MeshOptions::smooth. In a round of repositioning a node moves only if no other around it goes
/// before it; with four rounds a few elements of a level-9 sphere were left, with eight none.
constexpr int kRoundsOfMoves = 2;
/// Surfaces closer than this everywhere are one: edges of the finest cells.
constexpr double kNearSurface = 1e-4;
/// Part of the merge distance within which surfaces that are alike are one from the start. A whole face is
/// elsewhere then, so only by what rounding leaves.
constexpr double kMergedAtOnce = 0.04;
/// Rounded solids thinner than this get a surface for each side, cells.
constexpr double kThinSolid = 1.6;
/// What classification takes for each cell at the boundary, at least: as much where two regions meet, 380
/// bytes on a ball.
constexpr std::uint64_t kClassifyBytes = 150;

/// Model coordinates must tell apart the lattice steps that keep simplices from being flat (cnio::kMinHeight,
/// 6e-8 of a cell): farther from the origin, double precision would turn valid elements over. And squares of
/// volumes must not become 0.
void check_precision(const Root& root, int finest_level, const std::string& source) {
    constexpr double kMostCells = 2.5e8;
    constexpr double kSmallestCell = 1e-45;
    const double cell = std::ldexp(root.side, -finest_level);
    if (cell < kSmallestCell) {
        throw Error(ExitCode::kInput, source + ": cells of " + rounded_text(cell) +
                                          " are too small for double precision; choose other units");
    }
    double reach = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        reach = std::max({reach, std::fabs(root.origin[j]), std::fabs(root.origin[j] + root.side)});
    }
    if (reach <= kMostCells * cell) return;
    throw Error(ExitCode::kInput, source + ": coordinates up to " + rounded_text(reach) +
                                      " are too far from the origin for cells of " + rounded_text(cell) +
                                      "; move the model to the origin");
}

/// Cells as large as the model make a caricature of it; much larger ones are a slip in the units.
void check_cell_size(double extent, double finest, const MeshOptions& options, const std::string& source,
                     MeshReport& out) {
    constexpr double kLeastExtent = 1.0 / 16;  ///< cells
    if (extent >= finest) return;
    const std::string text = "cells of size " + rounded_text(finest) +
                             " are larger than the model, which is " + rounded_text(extent) + " long";
    if (extent < kLeastExtent * finest) {
        throw Error(ExitCode::kUsage, text + "; use cells of " + rounded_text(extent / 2) +
                                          " at most, or --level instead of a size");
    }
    warn_or_refuse(text + ": the mesh shows little of its shape; use smaller ones", options, source, out);
}

double longest(const Box3& box) {
    double extent = 0;
    for (std::size_t j = 0; j < 3; ++j) extent = std::max(extent, box.max[j] - box.min[j]);
    return extent;
}

Root find_root(const tape::CompiledModel& compiled, const Box3& bounds, const MeshOptions& options,
               const std::vector<PeriodicAxis>& periodic, MeshReport& out) {
    const Root root = choose_root(compiled, bounds, options, periodic, out.warnings);
    if (root.level <= octree::kMaxUniformLevel) return root;
    const double finest =
        longest(bounds) / (std::ldexp(1.0, octree::kMaxUniformLevel) - 2);  // margins of a cell
    throw Error(ExitCode::kUsage, "cells of size " + rounded_text(options.size) +
                                      " are too small for this model: those of level " +
                                      std::to_string(octree::kMaxUniformLevel) +
                                      ", the finest for cells of one size, have " + rounded_text(finest) +
                                      "; use larger cells, or small ones where they are needed "
                                      "(--refine, --size-of, --size-at)");
}

void check_layers(const LayerOptions& layers, const tape::CompiledModel& compiled,
                  const std::vector<PeriodicAxis>& periodic) {
    if (layers.count == 0) return;
    check_names(layers.on, compiled);
    if (!periodic.empty())
        throw Error(ExitCode::kUsage,
                    "layers do not go with periodic planes yet; leave the layers (--layers) out, or take "
                    "'identify periodic' out of the model");
}

/// From the model to its surfaces in the root box. Returns what sizes cells are to have.
Sizes bind_model(const Model& model, const MeshOptions& options, Prepared& result, MeshReport& out) {
    check_model(model);
    const Box3* const clip = options.box ? &*options.box : nullptr;
    result.compiled = tape::compile(model, clip);
    const tape::CompiledModel& compiled = result.compiled;
    const Box3 bounds = tape::find_bounds(model, compiled, clip, &out.warnings);
    result.periodic = periodic_axes(compiled, model, &out.warnings);
    check_layers(options.layers, compiled, result.periodic);
    const Root root = result.root = find_root(compiled, bounds, options, result.periodic, out);
    if (const std::optional<Model> parted = part_thin_solids(model, kThinSolid * root.cell()))
        result.compiled = tape::compile(*parted, clip);
    tape::BoundModel& bound = result.bound;
    bound = tape::bind(compiled, root.origin, root.side);
    std::optional<Sizes> planned;
    planned.emplace(plan_sizes(options, compiled, bound, bounds, root.level));
    const double finest = std::ldexp(1.0, -planned->levels.finest());  // edge, in the root box's
    check_cell_size(longest(bounds), root.side * finest, options, model.source, out);
    if (!options.strict) {
        // Two surfaces that no cell can tell apart would only make slivers.
        const double alike = kMergedAtOnce * options.merge_distance;
        tape::BoundModel merged =
            tape::bind(compiled, root.origin, root.side, {kNearSurface * finest, alike * finest});
        const auto told = [&out](std::uint64_t count, const std::string& what, const std::string& kept) {
            if (count == 0) return;
            out.warnings.push_back(counted(count, "surface that lies ", "surfaces that lie ") + what +
                                   (count == 1 ? " was" : " were") + " taken as one with it; " + kept +
                                   " keeps them apart");
        };
        told(merged.nearly_equal, "within 1/10000 of a cell of another", "--strict");
        told(merged.alike, "along another, " + rounded_text(alike) + " cells from it at most,", "--merge 0");
        if (merged.nearly_equal + merged.alike > 0) {
            bound = std::move(merged);
            planned.emplace(plan_sizes(options, compiled, bound, bounds, root.level));
        }
    }
    check_precision(root, planned->levels.finest(), model.source);
    return std::move(*planned);
}

void divide_polyhedra(const Model& model, const MeshOptions& options, const Levels& levels, Stages& stages,
                      tape::BoundModel& bound, MeshReport& out) {
    stages.begin("polyhedra");
    const triangles::Division division =
        triangles::divide(bound, levels.base, levels.finest(), options.threads);
    stages.end(division.nodes);
    if (division.crowded == 0) return;
    warn_or_refuse(std::to_string(division.crowded) +
                       " cells hold more faces of triangles than a cell can show; small ones are left out; "
                       "--refine, or smaller cells, would keep them",
                   options, model.source, out);
}

/// Which leaves are simple; vertices that snap. `complex`: leaves that are not, whatever they look like.
void classify(device::Device& device, const MeshOptions& options, std::vector<std::uint32_t> complex,
              Stages& stages, Prepared& result) {
    octree::Octree& tree = result.tree;
    const device::KernelsEnd kernels_end(device);
    if (options.memory > 0) {
        octree::share_memory(device, tree, result.on_device);
        check_memory(memory_now() + kClassifyBytes * tree.nio.size(), kBoundaryCells, options);
    }
    snio::Classifier classifier(device, tree, result.on_device, options.templates, options.snap, complex);
    // Not where surfaces or cells must match others across the model.
    const bool snaps_all = options.templates && options.snap && result.periodic.empty();
    if (snaps_all) {
        Snapping snapping(classifier, result, options.memory == 0 && options.pieces <= 1, options.threads);
        stages.end(0);
        stages.begin("snap");
        stages.end(snapping.find(std::move(complex)));
        stages.begin("classify");
        snapping.classify();
        stages.end(tree.nio.size());
        stages.begin("extract");
        snapping.extract();
        stages.end(0);
    } else {
        result.classification = classifier.finish({}, {}, {});
        stages.end(tree.nio.size());
        stages.begin("extract");
        tree.crowded = cnio::find_crowded(result.bound, tree, result.classification.cnio, options.threads);
        stages.end(0);
    }
}

/// Leaves inside that lie beside smaller ones.
std::uint64_t inner_transitions(const octree::Octree& tree) {
    return static_cast<std::uint64_t>(
        std::count_if(tree.transitions.begin(), tree.transitions.end(),
                      [&tree](std::uint32_t leaf) { return tree.nio[leaf].tape_length == 0; }));
}

}  // namespace

CellCounts count_cells(const std::function<device::Device&()>& open_device, const Model& model,
                       const MeshOptions& options, int most_levels, Stages& stages, MeshReport& out) {
    Prepared prepared;
    tape::BoundModel& bound = prepared.bound;
    stages.begin("compile");
    const Sizes sizes = bind_model(model, options, prepared, out);
    CellCounts counts;
    counts.level = sizes.levels.base;
    counts.finest_level = sizes.levels.finest();
    counts.cell_size = prepared.root.cell();
    counts.is_uniform = sizes.levels.is_uniform();
    if (counts.level > most_levels) return counts;
    if (!bound.polyhedra.empty()) divide_polyhedra(model, options, sizes.levels, stages, bound, out);
    stages.begin("device");
    device::Device& device = open_device();
    stages.begin("octree");
    const octree::Octree tree =
        build_tree(device, options, bound, sizes, prepared.periodic, &prepared.on_device);
    stages.end(tree.cells_evaluated);
    counts.finest_level = tree.level;
    counts.is_counted = true;
    counts.in = static_cast<double>(tree.in_count);
    counts.transitions = static_cast<double>(inner_transitions(tree));
    counts.nio = static_cast<double>(tree.nio.size()) - counts.transitions;
    return counts;
}

Prepared prepare(const std::function<device::Device&()>& open_device, const Model& model,
                 const MeshOptions& options, Stages& stages, MeshReport& out) {
    Prepared result;
    tape::BoundModel& bound = result.bound;
    stages.begin("compile");
    const Sizes sizes = bind_model(model, options, result, out);
    stages.end(bound.surfaces.size());
    if (!bound.polyhedra.empty()) divide_polyhedra(model, options, sizes.levels, stages, bound, out);

    stages.begin("device");
    device::Device& device = open_device();
    device.load_ahead(kLaterPrograms);
    out.device = device.info().name;
    stages.end(1);

    stages.begin("octree");
    octree::Octree& tree = result.tree;
    tree = build_tree(device, options, bound, sizes, result.periodic, &result.on_device);
    octree::drop_coincident(device, bound, tree, result.on_device, options.threads);
    octree::find_poles(bound, tree, options.threads);
    stages.end(tree.cells_evaluated);

    stages.begin("probe");
    probe::Probe probed = probe::find_features(bound, tree, options.threads);
    refuse_flat(probed.flat, result, model.source);
    out.missed = std::move(probed.features);
    if (options.strict) refuse_surely_missed(out.missed, result.root, options.refine, model.source);
    result.apexes = std::move(probed.apexes);
    result.folded = std::move(probed.folded);
    stages.end(probed.probed);

    if (model.regions.size() > 1) {
        stages.begin("overlaps");
        const std::vector<probe::Overlap> overlaps = probe::find_overlaps(bound, tree, options.threads);
        report_overlaps(overlaps, model, options, out);
        stages.end(overlaps.size());
    }

    stages.begin("classify");
    out.in_cells = tree.in_count;
    out.nio_cells = tree.nio.size();
    result.transition_cells = inner_transitions(tree);
    std::vector<std::uint32_t> complex = probed.leaves;
    for (const octree::LeafPole& pole : tree.leaf_poles) complex.push_back(tree.nio_index(pole.morton));
    complex.insert(complex.end(), tree.transitions.begin(), tree.transitions.end());
    classify(device, options, std::move(complex), stages, result);
    result.leaves = leaf_grid(tree);
    return result;
}

improve::Options improvement_options(const Prepared& prepared, const MeshOptions& options) {
    improve::Options result;
    result.level = prepared.tree.level;
    result.smooth = options.smooth;
    result.merge_distance = options.strict ? 0 : options.merge_distance;
    if (options.min_angle > kLeastMinAngle) result.goal = improve::quality_of_angle(options.min_angle);
    result.threads = options.threads;
    result.leaves = &prepared.leaves;
    result.poles = &prepared.tree.poles;
    return result;
}

IndexRuns reposition_nodes(device::Device& device, const Prepared& prepared, const MeshOptions& options,
                           const std::vector<std::uint8_t>* held, Stages& stages, Mesh& mesh) {
    if (options.smooth == 0) return {};
    stages.begin("reposition");
    reposition::Options reposition_options;
    reposition_options.level = prepared.tree.level;
    reposition_options.rounds = kRoundsOfMoves * options.smooth;
    reposition_options.threads = options.threads;
    reposition_options.leaves = &prepared.leaves;
    reposition_options.held = held;
    reposition::Counters counters = reposition::reposition(device, prepared.bound, reposition_options, mesh);
    stages.end(counters.moved);
    return std::move(counters.moved_cubes);
}

}  // namespace mortise::pipeline
