// The stages before the first element: from a model to classified leaves.
#pragma once

#include <functional>
#include <vector>

#include "host/cnio/extract.hpp"
#include "host/common/leaf_grid.hpp"
#include "host/device/device.hpp"
#include "host/features/hinges.hpp"
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

/// Throws Error(kUsage) for a negative size.
void check_work_group(int size);

/// Throws Error(kUsage) for options out of range.
void check_options(const MeshOptions& options);

/// `open_device` is called when the device is needed. Warnings and counts go to `out`.
Prepared prepare(const std::function<device::Device&()>& open_device, const Model& model,
                 const MeshOptions& options, Stages& stages, MeshReport& out);

/// For all meshes of a run; whoever improves a part of one adds what is open.
improve::Options improvement_options(const Prepared& prepared, const MeshOptions& options);
/// The stage "reposition", of a mesh or of what is near its poor elements. `held`: see reposition::Options.
/// Returns reposition::Counters::moved_cubes.
IndexRuns reposition_nodes(device::Device& device, const Prepared& prepared, const MeshOptions& options,
                           const std::vector<std::uint8_t>* held, Stages& stages, Mesh& mesh);
/// Throws Error(kMeshing) if something was left out and MeshOptions::strict is set.
void report_improvement(const improve::Counters& counters, const MeshOptions& options,
                        const std::string& source, MeshReport& out);

/// Warns where the skin of the mesh touches itself. Throws Error(kMeshing) if MeshOptions::strict
/// is set. `points` of the nodes that the hinges number.
void report_hinges(const features::Hinges& hinges, const std::vector<double>& points,
                   const MeshOptions& options, const std::string& source, MeshReport& out);

/// What the report tells of leaves and lost features. Throws Error(kMeshing) if the options forbid these.
void report_cells(const Prepared& prepared, const Extracted& extracted, const Model& model,
                  const MeshOptions& options, MeshReport& out);

/// Where a region has no element, by region: named in the file, but not in the mesh.
void warn_of_empty_regions(const std::vector<std::string>& names, const std::vector<bool>& present,
                           const std::string& source, MeshReport& report);

/// Error(kInput): a model without elements.
[[noreturn]] void refuse_empty(const std::string& source);
/// Of a mesh whose faces do not fit together.
[[noreturn]] void refuse_unpaired(const std::string& source);

}  // namespace mortise::pipeline
