// Cells of several sizes: which levels a run needs, and who asks for smaller cells.
#pragma once

#include "host/common/leaf_grid.hpp"
#include "host/octree/octree.hpp"
#include "host/pipeline/periodic.hpp"
#include "host/sizing/sizing.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Levels of a tree. Boundary cells have level `base` unless something asks for smaller ones.
struct Levels {
    int base = 6;
    int features = 6;     ///< finest that features and curvature may ask for
    int sizes = 6;        ///< finest that sizes ask for
    int coarsest_in = 6;  ///< of cells inside the solid

    int finest() const { return features > sizes ? features : sizes; }
    bool is_uniform() const { return finest() == base && coarsest_in == base; }
};

/// What decides about the cells' sizes.
struct Sizes {
    Levels levels;
    sizing::Sizer sizer;  ///< sizes, not features; refers to the bound model
};

/// Sizes for a model with these bounds, bound to its root box. Throws Error(kUsage) if they ask for more than
/// kMaxLevel, or for names that the model does not have.
Sizes plan_sizes(const MeshOptions& options, const tape::CompiledModel& compiled,
                 const tape::BoundModel& model, const Box3& bounds, int base);

/// The tree, uniform if all levels are one. What sizes split at periodic planes is split at both.
octree::Octree build_tree(device::Device& device, const MeshOptions& options, const tape::BoundModel& model,
                          const Sizes& sizes, const std::vector<PeriodicAxis>& periodic,
                          octree::DeviceTree* on_device);

/// The meshed leaves, for stages that only have the mesh; empty lists if the tree is uniform.
LeafGrid leaf_grid(const octree::Octree& tree);

}  // namespace mortise::pipeline
