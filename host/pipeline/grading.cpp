#include "host/pipeline/grading.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/common/constants.hpp"
#include "host/formula/expression_parser.hpp"
#include "host/pipeline/names.hpp"
#include "host/sizing/hints.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

/// Puts a size on the regions and surfaces of this name.
void add_named_size(const std::string& name, double size, const tape::CompiledModel& compiled,
                    const tape::BoundModel& model, sizing::SizeField& field) {
    bool found = false;
    field.region.resize(compiled.region_names.size(), kInfinity);
    field.surface.resize(model.surfaces.size(), kInfinity);
    for (std::size_t r = 0; r < compiled.region_names.size(); ++r) {
        if (compiled.region_names[r] != name) continue;
        field.region[r] = std::min(field.region[r], size);
        found = true;
    }
    const auto add_surface = [&](std::size_t surface, std::uint32_t called) {
        if (compiled.surface_names[called] != name) return;
        field.surface[surface] = std::min(field.surface[surface], size);
        found = true;
    };
    for (std::size_t s = 0; s < model.surfaces.size(); ++s) add_surface(s, model.surface_name[s]);
    for (const tape::Namesake& other : model.namesakes)
        add_surface(other.surface, compiled.surfaces[other.compiled].name);
    if (!found) refuse_name(name, compiled);
}

/// What the model asks for at parts without a node of their own. `base`: level of the boundary.
void add_hints(const tape::BoundModel& model, int base, sizing::SizeField& field) {
    const auto below = [base](int levels) { return std::ldexp(1.0, -std::min(base + levels, kMaxLevel)); };
    for (const tape::SurfaceHint& hint : model.hints) {
        const double size = hint.max_size > 0 ? hint.max_size : below(kHintLevels);
        if (std::any_of(hint.groups.begin(), hint.groups.end(), [](const auto& g) { return g.empty(); }))
            continue;
        if (hint.kind == SizeHint::Kind::kPoint) {
            field.sources.push_back({hint.at, size, 1});
        } else if (hint.kind == SizeHint::Kind::kGap) {
            // Flat gaps are as wide as they are; others may get narrow anywhere.
            double least = kInfinity;
            for (const std::uint32_t a : hint.groups[0]) {
                for (const std::uint32_t b : hint.groups[1])
                    least = std::min(least, 0.5 * sizing::distance_of_planes(model, a, b));
            }
            least = std::max(least, below(kGapLevels));
            field.gaps.push_back({hint.groups[0], hint.groups[1], least});
        } else if (hint.groups.size() == 1) {
            field.surface.resize(model.surfaces.size(), kInfinity);
            for (const std::uint32_t s : hint.groups[0]) field.surface[s] = std::min(field.surface[s], size);
        } else {
            field.meetings.push_back({hint.groups, size});
        }
    }
}

/// What file and options say of sizes; features and curvature are asked apart, since they have limits of
/// their own.
sizing::SizeField wanted_sizes(const MeshOptions& options, const tape::CompiledModel& compiled,
                               const tape::BoundModel& model, const Box3& bounds, int base) {
    sizing::SizeField field;
    if (options.model_sizes) {
        field = sizing::size_field(model);
        add_hints(model, base, field);
    }
    if (options.size_max > 0) field.everywhere = options.size_max / model.side;
    for (const SizeSource& source : options.sizes) {
        Vec3 at{};
        for (std::size_t j = 0; j < 3; ++j) at[j] = (source.at[j] - model.origin[j]) / model.side;
        field.sources.push_back({at, source.size / model.side, source.grading});
    }
    for (const auto& [name, size] : options.named_sizes)
        add_named_size(name, size / model.side, compiled, model, field);
    if (!options.size_formula.empty()) {
        try {
            const formula::Formula formula = formula::parse_formula(options.size_formula);
            formula::emit_formula(formula, formula.root, field.formula);
        } catch (const Error& error) {
            throw Error(ExitCode::kUsage, "--size-formula: " + std::string(error.what()));
        }
        field.within = bounds;
    }
    return field;
}

/// The coarsest level whose cells are no larger than this, box-local.
int level_for(double size) {
    int level = 0;
    while (level <= kMaxLevel && std::ldexp(1.0, -level) > size) ++level;
    return level;
}

}  // namespace

Sizes plan_sizes(const MeshOptions& options, const tape::CompiledModel& compiled,
                 const tape::BoundModel& model, const Box3& bounds, int base) {
    Sizes sizes{{}, sizing::Sizer(model, wanted_sizes(options, compiled, model, bounds, base))};
    Levels& levels = sizes.levels;
    const double smallest = sizes.sizer.smallest();
    levels.base = base;
    levels.features = base + options.refine;
    levels.sizes = std::max(base, level_for(smallest));
    levels.coarsest_in = std::max(1, base - options.interior_coarsening);
    if (options.size_min > 0) {
        // The finest cells are not smaller.
        const int finest = std::max(base, level_for(options.size_min / model.side * (1 + 1e-9)));
        const bool exact = std::ldexp(model.side, -finest) >= options.size_min * (1 - 1e-9);
        levels.features = std::min(levels.features, std::max(base, exact ? finest : finest - 1));
        levels.sizes = std::min(levels.sizes, std::max(base, exact ? finest : finest - 1));
    } else if (smallest == 0) {
        throw Error(ExitCode::kUsage,
                    "--size-formula may reach 0 in the model's box, as far as bounds tell; give --size-min");
    }
    if (levels.finest() > kMaxLevel) {
        throw Error(ExitCode::kUsage, "the smallest cells asked for need level " +
                                          std::to_string(levels.finest()) + "; the finest level is " +
                                          std::to_string(kMaxLevel) + "; ask for larger ones, or --size-min");
    }
    return sizes;
}

octree::Octree build_tree(device::Device& device, const MeshOptions& options, const tape::BoundModel& model,
                          const Sizes& sizes, const std::vector<PeriodicAxis>& periodic,
                          octree::DeviceTree* on_device) {
    const Levels& levels = sizes.levels;
    if (levels.is_uniform()) return octree::build(device, model, levels.base, on_device);
    sizing::SizeField shape;
    shape.features = options.refine > 0;
    shape.curvature_elements = options.curvature_elements;
    shape.finest = octree::Octree::edge_of(levels.features);
    const sizing::Sizer features(model, shape);
    octree::Grading grading;
    grading.coarsest = levels.base;
    grading.finest = levels.finest();
    grading.coarsest_in = levels.coarsest_in;
    grading.split_undecided = [&](const std::vector<TreeNode>& nodes, const std::vector<std::uint32_t>& tapes,
                                  int level) {
        std::vector<std::uint8_t> result(nodes.size(), 0);
        const auto ask = [&](const sizing::Sizer& sizer) {
            const auto wanted = sizer.split_undecided(nodes, tapes, level, options.threads);
            for (std::size_t i = 0; i < nodes.size(); ++i) result[i] |= wanted[i];
        };
        if (level < levels.sizes) ask(sizes.sizer);
        if (level < levels.features) ask(features);
        split_images(model, periodic, nodes, level, result);
        return result;
    };
    grading.split_in = [&](std::uint64_t morton, int level, std::uint16_t region) {
        return level < levels.sizes && sizes.sizer.splits_in(morton, level, region);
    };
    return octree::build_graded(device, model, grading, options.threads, on_device);
}

LeafGrid leaf_grid(const octree::Octree& tree) {
    LeafGrid grid;
    grid.level = tree.level;
    if (!tree.graded) return grid;
    for (std::size_t word = 0; word < tree.words(); ++word) {
        for (u32 bits = tree.in_bits[word] | tree.nio_bits[word]; bits != 0; bits &= bits - 1) {
            grid.code.push_back(tree.code_of_word(word) + count_bits((bits & (0u - bits)) - 1));
        }
    }
    grid.leaf_level = tree.leaf_marks;
    for (std::uint8_t& mark : grid.leaf_level) mark &= kMarkLevel;
    return grid;
}

}  // namespace mortise::pipeline
