// Cells are counted: the tree is built as the run would build it, or a coarser one where cells of one size
// grow in number as area and volume do. What cells at the boundary give, and what they cost, is the model's,
// its options' and the machine's: meshes of two larger cell sizes tell, by a part that grows as the area does
// (simple cells) and one that grows as the length of edges does (complex ones). Where the model is finer than
// larger cells (lattices), these take longer than the run itself; then a part of it in cells as asked tells.
#include "host/pipeline/estimate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "host/common/box_faces.hpp"
#include "host/pipeline/check_options.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/pipeline/stages.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

/// Trees are built for cells at the boundary of this level at most; in finer ones there are four and eight
/// times as many cells at each level.
constexpr int kFinestTree = 9;
/// A trial has no more cells at the boundary than this; a run that has no more is made as it is.
constexpr double kTrialCells = 40'000;
/// A trial is given up after that: of the larger cells, which tell whether others are worth while, of others.
constexpr double kFirstSeconds = 3, kTrialSeconds = 20;
/// Cells at the boundary of a part of the model, about, and at least, if it is to count.
constexpr double kPartCells = 6'000, kLeastPartCells = 1'000;
constexpr double kMostCut = 0.5;  ///< of a part's facets, on the box that cuts it

// Measured on the models of assets/ and of the corpora at level 7, and on spheres to level 9: runs took 0.75
// to 1.25 times what this gives.
constexpr double kProcessBytes = 120e6;  ///< of the driver and its compiler
constexpr double kBytesPerCell = 550;    ///< at the boundary
constexpr double kMeshCopies = 1.15;     ///< of hexahedra
constexpr double kSplitCopies = 1.3;     ///< of tetrahedra, which are made of these
constexpr double kLayerCopies = 0.5;     ///< more, with layers

/// What a cell inside gives, and one beside smaller ones: measured on balls and brackets.
struct PerCell {
    double elements, transition_elements, nodes, transition_nodes;
};
PerCell per_cell(const MeshOptions& options) {
    if (options.hanging) return {1, 1, 1, 2.8};
    PerCell result = options.tetrahedra ? PerCell{6, 24, 1, 3.8} : PerCell{1, 17, 1, 3.8};
    if (options.second_order) {
        // A grid of cubes has three edges for each vertex, one of cubes cut into six seven.
        result.nodes += options.tetrahedra ? 7 : 3;
        result.transition_nodes = 28;
    }
    return result;
}

/// Nodes of an element inside, and of one at the boundary in the mean: most are tetrahedra, the others have
/// up to eight.
double nodes_of_element(const MeshOptions& options, bool is_inside) {
    if (options.tetrahedra) return options.second_order ? 10 : 4;
    if (is_inside) return options.second_order ? 20 : 8;
    return options.second_order ? 11.5 : 4.6;
}

/// What a mesh of cells of one size has, and took.
struct Trial {
    double cell = 0, in = 0, nio = 0;
    double elements = 0, nodes = 0;
    double element_seconds = 0;  ///< of stages whose time is that of all elements
    double nio_seconds = 0;      ///< of others
    double cut = 0;              ///< share of the facets that lie on MeshOptions::box
};

/// Of the outer boundary.
double share_of_cuts(const Mesh& mesh) {
    double cut = 0, all = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.facets.outside[f] != 0) continue;
        ++all;
        if (is_box_face(mesh.surface_names[mesh.facets.surface[f]])) ++cut;
    }
    return all > 0 ? cut / all : 0;
}

Trial measured(const Mesh& mesh, const MeshReport& report) {
    Trial trial;
    trial.cell = report.cell_size;
    trial.in = static_cast<double>(report.in_cells);
    trial.nio = std::max(1.0, static_cast<double>(report.nio_cells));
    trial.elements = static_cast<double>(mesh.element_count());
    trial.nodes = static_cast<double>(mesh.node_count());
    trial.cut = share_of_cuts(mesh);
    for (const StageTime& stage : report.stages) {
        const Growth growth = growth_of(stage.stage);
        if (growth == Growth::kOnce) continue;
        (growth == Growth::kElements ? trial.element_seconds : trial.nio_seconds) += stage.wall_seconds;
    }
    return trial;
}

/// Something that cells at the boundary have: in all `area` / cell² + `length` / cell.
struct BoundaryLaw {
    double area = 0, length = 0;
    double cells = 0;  ///< their number, times cell²

    BoundaryLaw(const Trial& coarse, double coarse_value, const Trial& fine, double fine_value)
        : cells(fine.nio * fine.cell * fine.cell) {
        const double in_fine = fine_value * fine.cell * fine.cell;
        const double in_coarse = coarse_value * coarse.cell * coarse.cell;
        length = std::clamp((in_coarse - in_fine) / (coarse.cell - fine.cell), 0.0, in_fine / fine.cell);
        area = in_fine - length * fine.cell;
    }
    /// Of as many cells of that size.
    double of(double count, double cell) const { return count / cells * (area + length * cell); }
};

MeshOptions uniform(MeshOptions options, double cell) {
    options.level = 0;
    options.size = cell;
    options.refine = options.interior_coarsening = options.curvature_elements = 0;
    options.sizes.clear();
    options.named_sizes.clear();
    options.size_formula.clear();
    options.size_max = options.size_min = 0;
    options.model_sizes = false;
    options.hanging = options.strict = options.quality = false;
    return options;
}

/// To load the kernels that a run needs.
Model one_ball() {
    Model model;
    Region region;
    region.name = "ball";
    region.root = model.add_primitive(sphere(1));
    model.regions.push_back(std::move(region));
    return model;
}

class Estimator {
  public:
    Estimator(const std::function<device::Device&()>& open_device, const Model& model,
              const MeshOptions& options, const TrialRun& run)
        : open_device_(open_device), model_(model), options_(options), run_(run) {}

    MeshEstimate estimate() {
        const CellCounts cells = count_all();
        const double cell = cells.is_uniform ? cells.cell_size : equal_cell(cells);
        int levels = 0;
        while (cells.nio > kTrialCells * std::ldexp(1.0, 2 * levels)) ++levels;
        warm_up();
        for (; levels > 0; --levels) {  // the model may have no mesh of cells so large
            if (const std::optional<Trials> trials = find_trials(std::ldexp(cell, levels)))
                return extrapolate(cells, cell, *trials);
            if (!is_late_) continue;
            if (const std::optional<Trial> part = try_parts(cells, cell)) return from_part(cells, *part);
            have_parts_failed_ = true;
        }
        if (!have_parts_failed_ && may_have_parts(cells)) {
            if (const std::optional<MeshEstimate> whole = make(cells, 0.55, 0.7, kFirstSeconds))
                return *whole;
            if (const std::optional<Trial> part = try_parts(cells, cell)) return from_part(cells, *part);
        }
        return *make(cells, 0.7, 1, HUGE_VAL);
    }

  private:
    /// The smaller cells, and cells twice as large.
    struct Trials {
        Trial fine, coarse;
    };

    MeshOptions told(MeshOptions options, double begin, double end) const {
        if (!options_.progress) return options;
        options.progress = [this, begin, end](const char* stage, double progress) {
            return options_.progress(stage, begin + (end - begin) * progress);
        };
        return options;
    }

    CellCounts count(const MeshOptions& options) const {
        MeshReport ignored;
        const MeshOptions asked = told(options, 0, 0.5);
        Stages stages(asked, ignored);
        return count_cells(open_device_, model_, asked, kFinestTree, stages, ignored);
    }

    /// Of trees that would be too fine, from a coarser one.
    CellCounts count_all() const {
        CellCounts cells = count(options_);
        CellCounts larger = cells;
        for (int levels = std::max(1, cells.level - kFinestTree); !larger.is_counted; ++levels) {
            MeshOptions options = options_;
            options.level = 0;
            options.size = std::ldexp(cells.cell_size, levels);
            larger = count(options);
        }
        const double lengths = larger.cell_size / cells.cell_size;
        const double area = lengths * lengths, volume = lengths * area;
        cells.nio = area * larger.nio;
        cells.transitions = area * larger.transitions;
        // Of one size: the boundary's cells are half inside.
        cells.in = volume * larger.in + (cells.is_uniform ? 0.5 * (volume - area) * larger.nio : 0);
        return cells;
    }

    /// Cells of one size, of which the boundary would have as many.
    double equal_cell(const CellCounts& cells) const {
        MeshOptions options = uniform(options_, cells.cell_size);
        for (CellCounts even; !even.is_counted; options.size *= 2) {
            even = count(options);
            if (even.is_counted) return even.cell_size * std::sqrt(even.nio / std::max(1.0, cells.nio));
        }
        return cells.cell_size;
    }

    /// None if it takes too long: then is_late_.
    std::optional<Trial> run_within(double seconds, MeshOptions options, MeshReport& report) {
        const auto start = std::chrono::steady_clock::now();
        is_late_ = false;
        options.progress = [&, ask = options.progress](const char* stage, double progress) {
            const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
            is_late_ = passed.count() > seconds;
            return !is_late_ && (!ask || ask(stage, progress));
        };
        try {
            const Mesh mesh = run_(model_, options, report);
            return measured(mesh, report);
        } catch (const Interrupted&) {
            if (!is_late_) throw;
            return std::nullopt;
        }
    }

    /// None if the model has no mesh of such cells, either.
    std::optional<Trial> try_run(const MeshOptions& given, double begin, double end, double seconds) {
        try {
            MeshReport ignored;
            return run_within(seconds, told(given, begin, end), ignored);
        } catch (const Interrupted&) {
            throw;
        } catch (const Error& error) {
            if (error.code() == ExitCode::kDevice) throw;
            return std::nullopt;
        }
    }

    /// So that no trial's time has that of loading kernels.
    void warm_up() {
        MeshOptions options = told(uniform(options_, 0), 0.5, 0.55);
        options.size = 0;
        options.level = 4;
        options.box.reset();
        options.periodic.clear();
        options.layers.on.clear();
        MeshReport ignored;
        run_(one_ball(), options, ignored);
    }

    /// None if the model has no mesh of such cells, or of cells twice as large, or if one takes too long.
    std::optional<Trials> find_trials(double cell) {
        const std::optional<Trial> coarse = try_run(uniform(options_, 2 * cell), 0.55, 0.7, kFirstSeconds);
        if (!coarse) return std::nullopt;
        const std::optional<Trial> fine = try_run(uniform(options_, cell), 0.7, 1, kTrialSeconds);
        if (!fine) return std::nullopt;
        return Trials{*fine, *coarse};
    }

    /// Whether a half along each axis is likely to have kLeastPartCells of them.
    bool may_have_parts(const CellCounts& cells) const {
        return cells.nio >= 8 * kLeastPartCells && options_.periodic.empty() && summarize(model_).bounds;
    }

    /// Of a part of the model in cells as they are: around its middle, or else in a corner. None if none of
    /// these has enough of them, other than on its own faces.
    std::optional<Trial> try_parts(const CellCounts& cells, double cell) {
        const std::optional<Box3> bounds = summarize(model_).bounds;
        if (!bounds || !options_.periodic.empty()) return std::nullopt;
        const double share = std::min(0.5, std::cbrt(kPartCells / cells.nio));
        constexpr unsigned kCorners = 8;
        for (unsigned k = 0; k <= kCorners; ++k) {
            Box3 box = options_.box ? *options_.box : *bounds;
            for (std::size_t j = 0; j < 3; ++j) {
                const double low = std::max(box.min[j], bounds->min[j]);
                const double edge = std::min(box.max[j], bounds->max[j]) - low;
                const double at = k == 0 ? 0.5 : (k - 1) >> j & 1 ? 0.75 : 0.25;
                box.min[j] = low + (at - 0.5 * share) * edge;
                box.max[j] = low + (at + 0.5 * share) * edge;
            }
            MeshOptions options = uniform(options_, cell);
            options.box = box;
            const std::optional<Trial> part = try_run(options, 0.7, 1, kTrialSeconds);
            if (part && part->nio >= kLeastPartCells && part->cut <= kMostCut) return part;
            if (is_late_) break;
        }
        return std::nullopt;
    }

    /// Cells at the boundary are those of the part, but more.
    MeshEstimate from_part(const CellCounts& cells, const Trial& part) const {
        const PerCell each = per_cell(options_), part_each = per_cell(uniform(options_, part.cell));
        const double times = cells.nio / part.nio;
        const double elements = each.elements * cells.in + each.transition_elements * cells.transitions +
                                times * (part.elements - part_each.elements * part.in);
        const double nodes = each.nodes * cells.in + each.transition_nodes * cells.transitions +
                             times * (part.nodes - part_each.nodes * part.in);
        MeshEstimate result = with_sizes(cells, elements, nodes);
        result.seconds = part.element_seconds * elements / part.elements + part.nio_seconds * times;
        return result;
    }

    /// The mesh itself; none if it takes too long.
    std::optional<MeshEstimate> make(const CellCounts& cells, double begin, double end, double seconds) {
        MeshReport report;
        const std::optional<Trial> trial = run_within(seconds, told(options_, begin, end), report);
        if (!trial) return std::nullopt;
        MeshEstimate result = with_sizes(cells, trial->elements, trial->nodes);
        result.seconds = trial->element_seconds + trial->nio_seconds;
        result.is_exact = true;
        result.warnings = report.warnings;
        return result;
    }

    /// `cell`: as equal_cell has it.
    MeshEstimate extrapolate(const CellCounts& cells, double cell, const Trials& trials) const {
        const Trial &fine = trials.fine, &coarse = trials.coarse;
        const PerCell each = per_cell(options_), trial_each = per_cell(uniform(options_, cell));
        const auto at_boundary = [&](double Trial::*value, double per_in) {
            const BoundaryLaw law(coarse, coarse.*value - per_in * coarse.in, fine,
                                  fine.*value - per_in * fine.in);
            return law.of(cells.nio, cell);
        };
        const double elements = each.elements * cells.in + each.transition_elements * cells.transitions +
                                at_boundary(&Trial::elements, trial_each.elements);
        const double nodes = each.nodes * cells.in + each.transition_nodes * cells.transitions +
                             at_boundary(&Trial::nodes, trial_each.nodes);
        MeshEstimate result = with_sizes(cells, elements, nodes);
        // Stages begin with what does not grow.
        const double per_element = std::max(
            0.0, (fine.element_seconds - coarse.element_seconds) / (fine.elements - coarse.elements));
        result.seconds = fine.element_seconds + per_element * (elements - fine.elements) +
                         at_boundary(&Trial::nio_seconds, 0);
        return result;
    }

    /// What follows from the numbers of cells, elements and nodes.
    MeshEstimate with_sizes(const CellCounts& cells, double elements, double nodes) const {
        MeshEstimate result;
        result.level = cells.level;
        result.finest_level = cells.finest_level;
        result.cell_size = cells.cell_size;
        result.in_cells = rounded(cells.in);
        result.nio_cells = rounded(cells.nio + cells.transitions);
        result.elements = rounded(elements);
        result.nodes = rounded(nodes);
        const double inside = std::min(per_cell(options_).elements * cells.in, elements);
        const double links = nodes_of_element(options_, true) * inside +
                             nodes_of_element(options_, false) * (elements - inside);
        const double points = (3 * sizeof(double) + 1) * nodes;  // and the model's dimension there
        constexpr double kMeshBytes = 2 + 1 + 4;                 // region, kind, scaled Jacobian
        constexpr double kFileBytes = 4 + 1 + 4 + 1 + 4;         // offset, type and these
        const double copies = (options_.tetrahedra ? kSplitCopies : kMeshCopies) +
                              (options_.layers.count > 0 ? kLayerCopies : 0);
        result.memory_bytes = rounded(kProcessBytes + kBytesPerCell * (cells.nio + cells.transitions) +
                                      copies * (points + sizeof(NodeId) * links + kMeshBytes * elements));
        const double index = links < 2147483647.0 ? 4 : 8;
        result.file_bytes = rounded(points + index * links + (kFileBytes + index - 4) * elements);
        return result;
    }

    static std::uint64_t rounded(double value) {
        return static_cast<std::uint64_t>(std::llround(std::max(0.0, value)));
    }

    const std::function<device::Device&()>& open_device_;
    const Model& model_;
    const MeshOptions& options_;
    const TrialRun& run_;
    bool is_late_ = false;  ///< the last trial was given up
    bool have_parts_failed_ = false;
};

}  // namespace

MeshEstimate estimate(const std::function<device::Device&()>& open_device, const Model& model,
                      const MeshOptions& options, const TrialRun& run) {
    check_options(options);
    return Estimator(open_device, model, options, run).estimate();
}

}  // namespace mortise::pipeline
