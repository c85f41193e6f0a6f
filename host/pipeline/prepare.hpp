// The stages before the first element: from a model to classified leaves.
#pragma once

#include <functional>
#include <vector>

#include "host/cnio/extract.hpp"
#include "host/common/leaf_grid.hpp"
#include "host/device/device.hpp"
#include "host/improve/improve.hpp"
#include "host/octree/octree.hpp"
#include "host/pipeline/root_box.hpp"
#include "host/pipeline/stages.hpp"
#include "host/probe/probe.hpp"
#include "host/snio/classify.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// All that the stages which make elements need.
struct Prepared {
    tape::CompiledModel compiled;
    tape::BoundModel bound;
    std::vector<PeriodicAxis> periodic;
    Root root;
    octree::Octree tree;
    octree::DeviceTree on_device;
    snio::Classification classification;
    cnio::Extraction extraction;  ///< of all complex leaves, if it is kept; else empty
    std::vector<probe::Apex> apexes;
    std::vector<std::uint64_t> folded;  ///< as Probe::folded
    LeafGrid leaves;
    std::uint64_t transition_cells = 0;
};

/// What the report wants of all extractions.
struct Extracted {
    std::uint64_t refused = 0;                         ///< as cnio::CellCounters
    std::uint64_t unresolved = 0;                      ///< the same
    std::uint64_t troubled = 0;                        ///< cells that show less of the model than they could
    std::uint64_t first_troubled = ~std::uint64_t{0};  ///< Morton code of the first of them
};

/// `open_device` is called when the device is needed. Warnings and counts go to `out`.
Prepared prepare(const std::function<device::Device&()>& open_device, const Model& model,
                 const MeshOptions& options, Stages& stages, MeshReport& out);

/// Leaves of the tree that a run would build.
struct CellCounts {
    int level = 0, finest_level = 0;
    double cell_size = 0;  ///< of `level`, model units
    bool is_uniform = true;
    bool is_counted = false;
    double in = 0, nio = 0;
    double transitions = 0;  ///< inside, beside smaller ones; not among the others
};
/// The stages from "compile" to "octree". Where cells at the boundary would be of a higher level than this,
/// they are not counted.
CellCounts count_cells(const std::function<device::Device&()>& open_device, const Model& model,
                       const MeshOptions& options, int most_levels, Stages& stages, MeshReport& out);

/// For all meshes of a run; whoever improves a part of one adds what is open.
improve::Options improvement_options(const Prepared& prepared, const MeshOptions& options);
/// The stage "reposition", of a mesh or of what is near its poor elements. `held`: see reposition::Options.
/// Returns reposition::Counters::moved_cubes.
IndexRuns reposition_nodes(device::Device& device, const Prepared& prepared, const MeshOptions& options,
                           const std::vector<std::uint8_t>* held, Stages& stages, Mesh& mesh);

}  // namespace mortise::pipeline
