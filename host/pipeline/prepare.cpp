#include "host/pipeline/prepare.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "host/cnio/extract.hpp"
#include "host/octree/coincident.hpp"
#include "host/octree/poles.hpp"
#include "host/pipeline/grading.hpp"
#include "host/pipeline/memory_limit.hpp"
#include "host/pipeline/message_text.hpp"
#include "host/pipeline/programs.hpp"
#include "host/pipeline/snap.hpp"
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
/// What classification takes for each cell at the boundary, at least: as much where two regions meet, 380
/// bytes on a ball.
constexpr std::uint64_t kClassifyBytes = 150;

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
    throw Error(ExitCode::kInput, source + ": coordinates up to " + number_text(reach) +
                                      " are too far from the origin for cells of " + number_text(cell) +
                                      "; move the model to the origin");
}

/// One line on the features smaller than a cell: how many, the largest, and which cells would show them.
std::string describe_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine) {
    std::size_t lost = 0;
    double thinnest = root.side;
    const MissedFeature* largest = nullptr;
    for (const MissedFeature& feature : missed) {
        if (!feature.kept) ++lost;
        thinnest = std::min(thinnest, feature.thickness);
        if (largest == nullptr || (largest->kept && !feature.kept)) largest = &feature;
    }
    // A ball holds a vertex of the grid, wherever it lies, if its diameter is that of a cell. What rises from
    // other material is seen by coarser cells as a rule.
    int level = root.level;
    while (level < kMaxLevel && std::ldexp(root.side, -level) * std::sqrt(3.0) > thinnest) ++level;
    std::string text = std::to_string(missed.size()) + " feature" + (missed.size() == 1 ? "" : "s") +
                       " between the vertices of the grid, ";
    text += lost == 0 ? "kept coarsely" : std::to_string(lost) + " of them lost";
    text += std::string("; the largest") + (lost == 0 ? "" : " lost") + ": " +
            (largest->material ? "material, " : "a hole, ") + number_text(largest->size) + " long and " +
            number_text(largest->thickness) + " thick, at " + place_text(largest->position) + "; ";
    if (level <= root.level + refine)
        return text + "--refine " + std::to_string(refine) +
               " allows cells as small as that already; what narrows to a tip is never shown whole";
    text += "--refine " + std::to_string(level - root.level);
    if (level <= octree::kMaxUniformLevel) text += ", or level " + std::to_string(level) + ",";
    text += std::string(" makes cells as small as ") + (missed.size() == 1 ? "it" : "the thinnest of them");
    if (level == root.level + refine + 1) return text;
    return text + "; --refine " + std::to_string(refine + 1) + " may do";
}

/// A line for each pair of regions that overlap; behind the first few, one for all others.
void report_overlaps(const std::vector<probe::Overlap>& overlaps, const Model& model,
                     const MeshOptions& options, MeshReport& out) {
    constexpr std::size_t kMostLines = 5;
    for (std::size_t k = 0; k < std::min(overlaps.size(), kMostLines); ++k) {
        const probe::Overlap& overlap = overlaps[k];
        const auto name = [&model](std::int32_t region) {
            return "'" + model.regions[static_cast<std::size_t>(region) - 1].name + "'";
        };
        const std::string first = name(overlap.first);
        const std::string second = name(overlap.second);
        const std::string text = "the regions " + first + " and " + second + " overlap, around " +
                                 place_text(overlap.at) + " by " + number_text(2 * overlap.depth) +
                                 " or more; what both claim belongs to " + first + "; cut it from " + second +
                                 " if that is meant ('and not'), or move them apart";
        if (options.strict) throw Error(ExitCode::kMeshing, model.source + ": strict: " + text);
        out.warnings.push_back(text);
    }
    if (overlaps.size() > kMostLines) {
        const std::size_t others = overlaps.size() - kMostLines;
        out.warnings.push_back(std::to_string(others) + (others == 1 ? " other pair of regions overlaps"
                                                                     : " other pairs of regions overlap"));
    }
}

void refuse_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine,
                   const std::string& source) {
    if (std::all_of(missed.begin(), missed.end(), [](const MissedFeature& f) { return f.kept; })) return;
    throw Error(ExitCode::kMeshing, source + ": strict: " + describe_missed(missed, root, refine));
}

}  // namespace

void check_work_group(int size) {
    if (size >= 0) return;
    throw Error(ExitCode::kUsage, "work-group size " + std::to_string(size) +
                                      " is out of range; use 0 for the device's default, or a size from 1");
}

void check_options(const MeshOptions& options) {
    if (options.level < 0 || options.level > octree::kMaxUniformLevel) {
        throw Error(ExitCode::kUsage, "level " + std::to_string(options.level) +
                                          " is out of range; use 1 to " +
                                          std::to_string(octree::kMaxUniformLevel));
    }
    if (!(options.size >= 0) || !std::isfinite(options.size)) {
        throw Error(ExitCode::kUsage,
                    "cell size " + number_text(options.size) + " is out of range; use a positive length");
    }
    if (options.level > 0 && options.size > 0) {
        throw Error(ExitCode::kUsage, "level " + std::to_string(options.level) + " and cell size " +
                                          number_text(options.size) + " are both given; leave one of them 0");
    }
    if (options.smooth < 0 || options.smooth > kMostSmooth) {
        throw Error(ExitCode::kUsage, "smoothing by " + std::to_string(options.smooth) +
                                          " rounds is out of range; use 0 to " + std::to_string(kMostSmooth));
    }
    if (options.threads < 0) {
        throw Error(ExitCode::kUsage, "threads " + std::to_string(options.threads) +
                                          " is out of range; use 0 for all cores, or a count from 1");
    }
    check_work_group(options.work_group_size);
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
    if (!(options.merge_distance >= 0 && options.merge_distance <= kMostMergeDistance)) {
        throw Error(ExitCode::kUsage, "features merge within " + number_text(options.merge_distance) +
                                          " cells, which is out of range; use 0 to " +
                                          number_text(kMostMergeDistance));
    }
    if (!(options.min_angle >= kLeastMinAngle && options.min_angle <= kMostMinAngle)) {
        throw Error(ExitCode::kUsage, "smallest angle " + number_text(options.min_angle) +
                                          " is out of range; use " + number_text(kLeastMinAngle) + " to " +
                                          number_text(kMostMinAngle) + " degrees");
    }
    if (options.hanging && options.tetrahedra)
        throw Error(ExitCode::kUsage, "hanging nodes are those of hexahedra; leave them or tetrahedra away");
    if (options.min_angle > kLeastMinAngle && !options.improve)
        throw Error(ExitCode::kUsage, "a smallest angle needs elements to be improved");
    bool positive = options.size_min >= 0 && options.size_max >= 0 && options.curvature_elements >= 0 &&
                    std::isfinite(options.size_min + options.size_max + options.curvature_elements);
    for (const auto& [name, size] : options.named_sizes)
        positive = positive && size > 0 && std::isfinite(size);
    for (const SizeSource& source : options.sizes) {
        positive = positive && source.size > 0 && source.grading >= 0 && std::isfinite(source.size) &&
                   std::isfinite(source.grading) && std::isfinite(source.at[0] + source.at[1] + source.at[2]);
    }
    if (!positive) throw Error(ExitCode::kUsage, "cell sizes must be positive and finite");
    if (options.size_max > 0 && options.size_min > options.size_max) {
        throw Error(ExitCode::kUsage, "the smallest cell size " + number_text(options.size_min) +
                                          " is above the largest, " + number_text(options.size_max) +
                                          "; give size_min (--size-min) up to size_max (--size-max)");
    }
    if (!options.box) return;
    for (std::size_t j = 0; j < 3; ++j) {
        if (!(options.box->min[j] < options.box->max[j]) ||
            !std::isfinite(options.box->max[j] - options.box->min[j])) {
            throw Error(ExitCode::kUsage, std::string("the box is empty along ") + "xyz"[j] +
                                              "; give its minimum corner, then its maximum corner");
        }
    }
}

Prepared prepare(const std::function<device::Device&()>& open_device, const Model& model,
                 const MeshOptions& options, Stages& stages, MeshReport& out) {
    Prepared result;
    stages.begin("compile", 0);
    check_model(model);
    result.compiled = tape::compile(model, options.box ? &*options.box : nullptr);
    const tape::CompiledModel& compiled = result.compiled;
    const Box3 bounds =
        tape::find_bounds(model, compiled, options.box ? &*options.box : nullptr, &out.warnings);
    result.periodic = periodic_axes(compiled, model, &out.warnings);
    const Root root = result.root = choose_root(compiled, bounds, options, result.periodic, out.warnings);
    if (root.level > octree::kMaxUniformLevel) {
        double extent = 0;
        for (std::size_t j = 0; j < 3; ++j) extent = std::max(extent, bounds.max[j] - bounds.min[j]);
        const double finest = extent / (std::ldexp(1.0, octree::kMaxUniformLevel) - 2);  // margins of a cell
        throw Error(ExitCode::kUsage, "cells of size " + number_text(options.size) +
                                          " are too small for this model: those of level " +
                                          std::to_string(octree::kMaxUniformLevel) +
                                          ", the finest for cells of one size, have " + number_text(finest) +
                                          "; use larger cells, or small ones where they are needed "
                                          "(--refine, --size-of, --size-at)");
    }
    tape::BoundModel& bound = result.bound;
    bound = tape::bind(compiled, root.origin, root.side);
    std::optional<Sizes> planned;
    planned.emplace(plan_sizes(options, compiled, bound, bounds, root.level));
    if (!options.strict) {
        // Two surfaces that no cell can tell apart would only make slivers.
        const double cell = std::ldexp(1.0, -planned->levels.finest());
        const double alike = kMergedAtOnce * options.merge_distance;
        tape::BoundModel merged =
            tape::bind(compiled, root.origin, root.side, {kNearSurface * cell, alike * cell});
        const auto told = [&out](std::uint64_t count, const std::string& what, const std::string& kept) {
            if (count == 0) return;
            out.warnings.push_back(
                std::to_string(count) + (count == 1 ? " surface that lies " : " surfaces that lie ") + what +
                (count == 1 ? " was" : " were") + " taken for it; " + kept + " keeps them apart");
        };
        told(merged.nearly_equal, "within 1/10000 of a cell of another", "--strict");
        told(merged.alike, "along another, " + number_text(alike) + " cells from it at most,", "--merge 0");
        if (merged.nearly_equal + merged.alike > 0) {
            bound = std::move(merged);
            planned.emplace(plan_sizes(options, compiled, bound, bounds, root.level));
        }
    }
    const Sizes& sizes = *planned;
    const Levels& levels = sizes.levels;
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
    device::Device& device = open_device();
    device.load_ahead(kLaterPrograms);
    out.device = device.info().name;
    stages.end(1);

    stages.begin("octree", 0.05);
    octree::Octree& tree = result.tree;
    tree = build_tree(device, options, bound, sizes, result.periodic, &result.on_device);
    octree::drop_coincident(device, bound, tree, result.on_device, options.threads);
    octree::find_poles(bound, tree, options.threads);
    stages.end(tree.cells_evaluated);

    stages.begin("probe", 0.28);
    probe::Probe probed = probe::find_features(bound, tree, options.threads);
    out.missed = std::move(probed.features);
    if (options.strict) refuse_missed(out.missed, root, options.refine, model.source);
    stages.end(probed.probed);

    if (model.regions.size() > 1) {
        stages.begin("overlaps", 0.29);
        const std::vector<probe::Overlap> overlaps = probe::find_overlaps(bound, tree, options.threads);
        report_overlaps(overlaps, model, options, out);
        stages.end(overlaps.size());
    }

    stages.begin("classify", 0.3);
    out.in_cells = tree.in_count;
    out.nio_cells = tree.nio.size();
    result.transition_cells = static_cast<std::uint64_t>(
        std::count_if(tree.transitions.begin(), tree.transitions.end(),
                      [&tree](std::uint32_t leaf) { return tree.nio[leaf].tape_length == 0; }));
    std::vector<std::uint32_t> complex = probed.leaves;
    for (const octree::LeafPole& pole : tree.leaf_poles) complex.push_back(tree.nio_index(pole.morton));
    complex.insert(complex.end(), tree.transitions.begin(), tree.transitions.end());
    const device::KernelsEnd kernels_end(device);
    if (options.memory > 0) {
        octree::share_memory(device, tree, result.on_device);
        check_memory(memory_now() + kClassifyBytes * tree.nio.size(), kBoundaryCells, options);
    }
    result.apexes = std::move(probed.apexes);
    snio::Classifier classifier(device, tree, result.on_device, options.templates, options.snap, complex);
    // Not where surfaces or cells must match others across the model.
    const bool snaps_all = options.templates && options.snap && result.periodic.empty();
    if (snaps_all) {
        Snapping snapping(classifier, result, options.memory == 0 && options.pieces <= 1, options.threads);
        stages.end(0);
        stages.begin("snap", 0.31);
        stages.end(snapping.find(std::move(complex)));
        stages.begin("classify", 0.32);
        snapping.classify();
        stages.end(tree.nio.size());
        stages.begin("extract", 0.33);
        snapping.extract();
        stages.end(0);
    } else {
        result.classification = classifier.finish({}, {}, {});
        stages.end(tree.nio.size());
        stages.begin("extract", 0.33);
        tree.crowded = cnio::find_crowded(bound, tree, result.classification.cnio, options.threads);
        stages.end(0);
    }
    result.leaves = leaf_grid(tree);
    return result;
}

void report_cells(const Prepared& prepared, const Extracted& extracted, const Model& model,
                  const MeshOptions& options, MeshReport& out) {
    const Root& root = prepared.root;
    const octree::Octree& tree = prepared.tree;
    out.level = root.level;
    out.cell_size = root.cell();
    out.finest_level = tree.level;
    if (tree.graded) {
        out.leaves.assign(static_cast<std::size_t>(tree.level) + 1, 0);
        for (const std::uint8_t mark : tree.leaf_marks) ++out.leaves[mark & kMarkLevel];
        out.transition_cells = prepared.transition_cells;
    }
    out.root = {root.origin,
                {root.origin[0] + root.side, root.origin[1] + root.side, root.origin[2] + root.side}};
    out.cells_evaluated = tree.cells_evaluated;
    out.cnio_cells = prepared.classification.cnio.size();
    out.snio_cells = out.nio_cells - out.cnio_cells;
    out.refused_splits = extracted.refused;
    out.unresolved = extracted.unresolved;
    out.dropped_features = extracted.troubled;
    out.warnings.insert(out.warnings.begin(), model.warnings.begin(), model.warnings.end());
    if (!out.missed.empty()) out.warnings.push_back(describe_missed(out.missed, root, options.refine));
    if (extracted.troubled > 0) {
        const double edge = octree::Octree::edge_of(tree.level_of(extracted.first_troubled));
        Vec3 at{};
        for (std::size_t j = 0; j < 3; ++j) {
            const double low = gather_bits(extracted.first_troubled >> j) * tree.finest_edge();
            at[j] = root.origin[j] + root.side * (low + 0.5 * edge);
        }
        out.first_dropped = at;
        const std::string text =
            std::to_string(extracted.troubled) + " of " + std::to_string(out.cnio_cells) +
            " complex cells hold features too fine to be kept exactly, the first around " + place_text(at) +
            "; --refine, or smaller cells, would keep more of them";
        if (options.strict) throw Error(ExitCode::kMeshing, model.source + ": strict: " + text);
        out.warnings.push_back(text);
    }
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
    stages.begin("reposition", 0.92);
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

/// Degrees: from here on one element in four and more is short of what is asked.
constexpr double kFewHaveIt = 35;

void report_improvement(const improve::Counters& counters, const MeshOptions& options,
                        const std::string& source, MeshReport& out) {
    out.crumbs = counters.crumbs.count;
    if (out.crumbs > 0) {
        const improve::Point& at = *counters.crumbs.first;
        const std::string text = std::to_string(out.crumbs) +
                                 (out.crumbs == 1 ? " loose piece was" : " loose pieces were") +
                                 " left out, of less than 1/20000 of a cell; the first at " + place_text(at);
        if (options.strict) throw Error(ExitCode::kMeshing, source + ": strict: " + text);
        out.warnings.push_back(text);
    }
    const auto told = [&out](std::uint64_t count, const std::string& which, const std::string& done) {
        if (count == 0) return;
        out.warnings.push_back(std::to_string(count) + (count == 1 ? " node" : " nodes") + which +
                               (count == 1 ? " was " : " were ") + done);
    };
    const std::string distance = number_text(options.merge_distance) + " cells";
    out.merged_nodes = counters.block.merged;
    told(out.merged_nodes, " of features closer than " + distance,
         std::string("merged with others, or elements would be slivers; --merge 0 keeps ") +
             (out.merged_nodes == 1 ? "it" : "them") + " apart");
    out.below_min_angle = counters.below_goal;
    if (out.below_min_angle > 0) {
        out.warnings.push_back(std::to_string(out.below_min_angle) +
                               (out.below_min_angle == 1 ? " element is" : " elements are") +
                               " worse than asked by a smallest angle of " + number_text(options.min_angle) +
                               " degrees: " +
                               (options.min_angle < kFewHaveIt
                                    ? "the model is sharper there, or finer than cells; see --quality"
                                    : "few elements have that much at all their edges; see --quality"));
    }
    out.loosened_nodes = counters.loosened;
    told(out.loosened_nodes, " where features are too fine for good elements",
         "moved off the model's surfaces, by " + number_text(improve::kMostLoose * options.merge_distance) +
             " cells at most" + "; --merge 0 keeps " + (out.loosened_nodes == 1 ? "it" : "them") +
             " there, smaller cells make that needless");
}

void report_hinges(const features::Hinges& hinges, const std::vector<double>& points,
                   const MeshOptions& options, const std::string& source, MeshReport& out) {
    out.hinge_edges = hinges.edges;
    out.hinge_nodes = hinges.nodes;
    if (!hinges.any()) return;
    const auto counted = [](std::uint64_t count, const char* what) {
        return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
    };
    std::string by = hinges.edges > 0 ? counted(hinges.edges, "edge") : "";
    if (hinges.nodes > 0) by += (by.empty() ? "" : " and ") + counted(hinges.nodes, "node");
    const double* at = points.data() + 3 * std::size_t{*hinges.first};
    const std::string text = "the skin of the mesh touches itself at " + by + ", the first at " +
                             place_text({at[0], at[1], at[2]}) +
                             ": a wall or a gap is thinner than the cells there, or parts of the model only "
                             "touch; smaller cells, or --refine, may show which";
    if (options.strict) throw Error(ExitCode::kMeshing, source + ": strict: " + text);
    out.warnings.push_back(text);
}

void warn_of_empty_regions(const std::vector<std::string>& names, const std::vector<bool>& present,
                           const std::string& source, MeshReport& report) {
    for (std::size_t r = 1; r <= names.size(); ++r) {
        if (r < present.size() && present[r]) continue;
        report.warnings.push_back(source + ": region '" + names[r - 1] +
                                  "' has no elements: it is empty, covered by regions before it, or thinner "
                                  "than the cells");
    }
}

void refuse_unpaired(const std::string& source) {
    throw Error(ExitCode::kMeshing,
                source +
                    ": internal error: faces of the mesh do not fit together; please report the model "
                    "(--no-templates, or another --level, may mesh it)");
}

void refuse_empty(const std::string& source) {
    throw Error(ExitCode::kInput, source +
                                      ": the solid is empty, or thinner than the cells everywhere; "
                                      "if it is not empty, use smaller cells, or --refine");
}

}  // namespace mortise::pipeline
