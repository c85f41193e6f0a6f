// Binning of NIO leaves by topology, and snapping of vertices (kernels/snio).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/device/device.hpp"
#include "host/octree/octree.hpp"
#include "kernels/shared/snio.h"
#include "mortise/mesh.hpp"

namespace mortise::snio {

/// What the bins say of each NIO leaf. Counts are zero for CNIO leaves.
struct Classification {
    std::vector<SnioLeaf> leaves;
    std::vector<std::uint32_t> used;  ///< node masks of kernels/shared/tree.h
    std::array<std::vector<std::uint32_t>, kElementTypes> elements;
    std::vector<std::uint32_t> facets;
    std::vector<std::uint32_t> cnio;  ///< indices of the leaves left to the certificate, ascending
};

/// Classifies all NIO leaves; with templates off every one is left to the certificate. So are the leaves
/// `complex`, indices into Octree::nio.
///
/// With `snap`, vertices near a smooth surface are moved onto it. Then the IN leaves around them are
/// promoted: `tree` and `on_device` change, and hold these leaves as NIO leaves with an empty tape.
Classification classify(device::Device& device, octree::Octree& tree, octree::DeviceTree& on_device,
                        bool templates, bool snap, const std::vector<std::uint32_t>& complex = {});

}  // namespace mortise::snio
