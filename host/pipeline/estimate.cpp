// Cells are counted: the tree is built as the run would build it, or a coarser one where cells of one size
// grow in number as area and volume do. What cells at the boundary give, and what they cost, is the model's,
// its options' and the machine's: meshes of two larger cell sizes tell, by a part that grows as the area does
// (simple cells) and one that grows as the length of edges does (complex ones).
#include "host/pipeline/estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "host/pipeline/check_options.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/pipeline/stages.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

/// Trees of cells of one size are built to this level; in finer ones there are four and eight times as many
/// cells at each level.
constexpr int kFinestTree = 9;
/// A trial has no more cells at the boundary than this; a run that has no more is made as it is.
constexpr double kTrialCells = 40'000;

// Measured on the models of assets/ and of the corpora at level 7, and on spheres to level 9: the peaks of
// runs were between 0.9 and 1.2 of what this gives.
constexpr double kProcessBytes = 120e6;  ///< of the driver and its compiler
constexpr double kBytesPerCell = 550;    ///< at the boundary
constexpr double kMeshCopies = 1.15;     ///< of hexahedra
constexpr double kSplitCopies = 1.3;     ///< of tetrahedra, which are made of these
constexpr double kLayerCopies = 0.5;     ///< more, with layers

/// What a cell inside gives, and one beside smaller ones (measured: 17.2 and 24.4 elements).
struct PerCell {
    double elements, transition_elements, nodes, transition_nodes;
};
PerCell per_cell(const MeshOptions& options) {
    if (options.hanging) return {1, 1, 1, 1};
    PerCell result = options.tetrahedra ? PerCell{6, 24, 1, 1} : PerCell{1, 17, 1, 1};
    if (options.second_order) {
        // A grid of cubes has three edges for each vertex, one of cubes cut into six seven; a template of a
        // transition cell has one vertex and 14 edges inside.
        result.nodes += options.tetrahedra ? 7 : 3;
        result.transition_nodes += 14;
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

/// Stages whose time is that of all elements; that of others is the boundary's.
bool is_of_elements(std::string_view stage) {
    constexpr std::array<std::string_view, 8> kStages = {"assemble",  "merge", "tetrahedra",   "faces",
                                                         "jacobians", "names", "second order", "hanging"};
    return std::find(kStages.begin(), kStages.end(), stage) != kStages.end();
}

/// What a mesh of cells of one size has, and took.
struct Trial {
    double cell = 0, in = 0, nio = 0;
    double elements = 0, nodes = 0;
    double element_seconds = 0;  ///< of stages whose time is that of all elements
    double nio_seconds = 0;      ///< of others
};

Trial measured(const Mesh& mesh, const MeshReport& report) {
    Trial trial;
    trial.cell = report.cell_size;
    trial.in = static_cast<double>(report.in_cells);
    trial.nio = std::max(1.0, static_cast<double>(report.nio_cells));
    trial.elements = static_cast<double>(mesh.element_count());
    trial.nodes = static_cast<double>(mesh.node_count());
    for (const StageTime& stage : report.stages) {
        if (stage.stage == "compile" || stage.stage == "device") continue;
        (is_of_elements(stage.stage) ? trial.element_seconds : trial.nio_seconds) += stage.wall_seconds;
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

class Estimator {
  public:
    Estimator(const std::function<device::Device&()>& open_device, const Model& model,
              const MeshOptions& options, const TrialRun& run)
        : open_device_(open_device), model_(model), options_(options), run_(run) {}

    MeshEstimate estimate() {
        CellCounts cells = count(options_);
        if (!cells.is_counted) add_counts(cells);
        const double of_one_size = cells.is_uniform ? cells.nio : count_of_one_size(cells);
        int coarser = 0;
        while (of_one_size > kTrialCells * std::ldexp(1.0, 2 * coarser)) ++coarser;
        if (coarser == 0 && cells.nio <= kTrialCells) {
            try_run(uniform(options_, 4 * cells.cell_size), 0.5, 0.6);  // which loads the kernels
            MeshReport report;
            const Mesh mesh = run_(told(options_, 0.6, 1), report);
            const Trial trial = measured(mesh, report);
            MeshEstimate exact = estimate_of(cells, trial.elements, trial.nodes);
            exact.seconds = trial.element_seconds + trial.nio_seconds;
            exact.is_exact = true;
            return exact;
        }
        return extrapolate(cells, coarser);
    }

  private:
    MeshOptions told(MeshOptions options, double begin, double end) const {
        if (!options_.progress) return options;
        options.progress = [this, begin, end](const char* stage, double progress) {
            return options_.progress(stage, begin + (end - begin) * progress);
        };
        return options;
    }

    /// Without building it where the tree would be too fine: then only level and size of cells are right.
    CellCounts count(const MeshOptions& options) {
        MeshReport ignored;
        const MeshOptions asked = told(options, 0, 0.5);
        Stages stages(asked, ignored);
        return count_cells(open_device_, model_, asked, kFinestTree, stages, ignored);
    }

    /// Of cells of one size, from larger ones: as area and volume have them.
    void add_counts(CellCounts& cells) {
        CellCounts larger;
        int levels = std::max(0, cells.level - kFinestTree);
        for (; !larger.is_counted; ++levels)
            larger = count(uniform(options_, std::ldexp(cells.cell_size, levels)));
        const double lengths = larger.cell_size / cells.cell_size;
        const double volume = (larger.in + 0.5 * larger.nio) * lengths * lengths * lengths;
        cells.nio = larger.nio * lengths * lengths;
        cells.in = std::max(0.0, volume - 0.5 * cells.nio);
    }

    double count_of_one_size(CellCounts cells) {
        add_counts(cells);
        return cells.nio;
    }

    /// None if the model has no mesh of such cells.
    std::optional<Trial> try_run(const MeshOptions& options, double begin, double end) const {
        try {
            MeshReport report;
            const Mesh mesh = run_(told(options, begin, end), report);
            return measured(mesh, report);
        } catch (const Interrupted&) {
            throw;
        } catch (const Error& error) {
            if (error.code() == ExitCode::kDevice) throw;
            return std::nullopt;
        }
    }

    /// From cells 2^coarser times as large, or less if the model has no mesh of those.
    MeshEstimate extrapolate(const CellCounts& cells, int coarser) const {
        const auto at = [&](int levels) { return uniform(options_, std::ldexp(cells.cell_size, levels)); };
        std::optional<Trial> coarse, fine;
        for (;; --coarser) {
            try_run(at(coarser + 2), 0.5, 0.55);  // which loads the kernels
            coarse = try_run(at(coarser + 1), 0.55, 0.7);
            if (coarse && (fine = try_run(at(coarser), 0.7, 1))) break;
            if (coarser > 0) continue;
            MeshReport report;
            fine = measured(run_(told(options_, 0.7, 1), report), report);  // throws, or does without another
            if (!coarse) coarse = Trial{2 * fine->cell, 0, 0, 0, 0, 0, 0};
            break;
        }
        const PerCell each = per_cell(options_), trial_each = per_cell(at(0));
        const auto at_boundary = [&](double Trial::*value, double per_in) {
            const BoundaryLaw law(*coarse, (*coarse).*value - per_in * coarse->in, *fine,
                                  (*fine).*value - per_in * fine->in);
            return law.of(cells.nio, cells.cell_size);
        };
        const double elements = each.elements * cells.in + each.transition_elements * cells.transitions +
                                at_boundary(&Trial::elements, trial_each.elements);
        const double nodes = each.nodes * cells.in + each.transition_nodes * cells.transitions +
                             at_boundary(&Trial::nodes, trial_each.nodes);
        MeshEstimate result = estimate_of(cells, elements, nodes);
        // Stages begin with what does not grow.
        const double per_element = std::max(
            0.0, (fine->element_seconds - coarse->element_seconds) / (fine->elements - coarse->elements));
        result.seconds = fine->element_seconds + per_element * (elements - fine->elements) +
                         at_boundary(&Trial::nio_seconds, 0);
        return result;
    }

    MeshEstimate estimate_of(const CellCounts& cells, double elements, double nodes) const {
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
};

}  // namespace

MeshEstimate estimate(const std::function<device::Device&()>& open_device, const Model& model,
                      const MeshOptions& options, const TrialRun& run) {
    check_options(options);
    return Estimator(open_device, model, options, run).estimate();
}

}  // namespace mortise::pipeline
