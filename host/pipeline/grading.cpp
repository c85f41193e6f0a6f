#include "host/pipeline/grading.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/sizing/sizing.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

/// What files and options say of sizes; features and curvature are asked apart, since they have limits of
/// their own.
sizing::SizeField wanted_sizes(const MeshOptions& options, const tape::BoundModel& model) {
    sizing::SizeField field;
    if (options.model_sizes) field = sizing::size_field(model);
    for (const SizeSource& source : options.sizes) {
        Vec3 at{};
        for (std::size_t j = 0; j < 3; ++j) at[j] = (source.at[j] - model.origin[j]) / model.side;
        field.sources.push_back({at, source.size / model.side, source.grading});
    }
    return field;
}

double smallest(const sizing::SizeField& field) {
    double size = field.everywhere;
    for (const double surface : field.surface) size = std::min(size, surface);
    for (const double region : field.region) size = std::min(size, region);
    for (const auto& source : field.sources) size = std::min(size, source.size);
    return size;
}

/// The coarsest level whose cells are no larger than this, box-local.
int level_for(double size) {
    int level = 0;
    while (level <= kMaxLevel && std::ldexp(1.0, -level) > size) ++level;
    return level;
}

}  // namespace

Levels plan_levels(const MeshOptions& options, const tape::BoundModel& model, int base) {
    Levels levels;
    levels.base = base;
    levels.features = base + options.refine;
    levels.sizes = std::max(base, level_for(smallest(wanted_sizes(options, model))));
    levels.coarsest_in = std::max(1, base - options.interior_coarsening);
    if (options.size_min > 0) {
        // The finest cells are not smaller.
        const int finest = std::max(base, level_for(options.size_min / model.side * (1 + 1e-9)));
        levels.features = std::min(levels.features, finest);
        levels.sizes = std::min(levels.sizes, finest);
    }
    if (levels.finest() > kMaxLevel) {
        throw Error(ExitCode::kUsage, "the smallest cells asked for need level " +
                                          std::to_string(levels.finest()) + "; the finest level is " +
                                          std::to_string(kMaxLevel) + "; ask for larger ones, or --size-min");
    }
    return levels;
}

octree::Octree build_tree(device::Device& device, const MeshOptions& options, const tape::BoundModel& model,
                          const Levels& levels, octree::DeviceTree* on_device) {
    if (levels.is_uniform()) return octree::build(device, model, levels.base, on_device);
    const sizing::Sizer sizes(model, wanted_sizes(options, model));
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
        if (level < levels.sizes) ask(sizes);
        if (level < levels.features) ask(features);
        return result;
    };
    grading.split_in = [&](std::uint64_t morton, int level, std::uint16_t region) {
        return level < levels.sizes && octree::Octree::edge_of(level) > sizes.in_size(morton, level, region);
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
    grid.leaf_level = tree.leaf_levels;
    return grid;
}

}  // namespace mortise::pipeline
