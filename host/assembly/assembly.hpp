// Assembly: one numbering by ownership, node positions, connectivity and facets of all leaves.
//
// Counts first, then fills at the offsets that follow from them, so every part can be made by anyone, in any
// order (architecture.md). Grid vertices, IN hexahedra and templates are written by
// kernels/assembly/number.cl, the certificate's cells by host threads.
#pragma once

#include "host/cnio/extract.hpp"
#include "host/device/device.hpp"
#include "host/octree/octree.hpp"
#include "host/snio/classify.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::assembly {

struct Input {
    const tape::BoundModel& model;
    const octree::Octree& tree;
    octree::DeviceTree& on_device;
    const snio::Classification& classification;
    const cnio::Extraction& extraction;
    int threads;
};

/// Builds the mesh; names are left to the caller, and facets carry indices of BoundModel::surface_name.
Mesh assemble(device::Device& device, const Input& input);

}  // namespace mortise::assembly
