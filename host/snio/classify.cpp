#include "host/snio/classify.hpp"

namespace mortise::snio {

Classification classify(device::Device& device, const octree::Octree& tree, octree::DeviceTree& on_device,
                        bool templates) {
    const std::size_t count = tree.nio.size();
    Classification result;
    if (templates) {
        device::Buffer leaves = device.allocate(count * sizeof(SnioLeaf));
        device::Buffer used = device.allocate(count * sizeof(std::uint32_t));
        device::Buffer counts = device.allocate(kElementTypes * count * sizeof(std::uint32_t));
        device::Buffer facets = device.allocate(count * sizeof(std::uint32_t));
        device.launch(device.kernel("snio/classify.cl", "classify"), count, on_device.nio, on_device.tapes,
                      on_device.surfaces, on_device.ops, leaves, used, counts, facets,
                      static_cast<std::uint32_t>(count), static_cast<std::int32_t>(tree.level));
        result.leaves = device.download<SnioLeaf>(leaves, count);
        result.used = device.download<std::uint32_t>(used, count);
        result.facets = device.download<std::uint32_t>(facets, count);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            result.elements[t] = device.download<std::uint32_t>(counts, count, t * count);
        }
    } else {
        result.leaves.assign(count, {0, kPatternCnio, 0});
        result.used.assign(count, 0);
        result.facets.assign(count, 0);
        for (auto& elements : result.elements) elements.assign(count, 0);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        if (result.leaves[i].pattern == kPatternCnio) result.cnio.push_back(i);
    }
    return result;
}

}  // namespace mortise::snio
