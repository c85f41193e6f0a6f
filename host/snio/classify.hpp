// Binning of NIO leaves by topology (kernels/snio/classify.cl).
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

/// Classifies all NIO leaves; with templates off every one is left to the certificate.
Classification classify(device::Device& device, const octree::Octree& tree, octree::DeviceTree& on_device,
                        bool templates);

}  // namespace mortise::snio
