// Surfaces that pass through the crease of two others, and change nothing there.
//
// A cone that stands on a cylinder of the same radius: cone, cylinder and the plane between them share a
// circle. Of the eight choices of their three signs only six occur around it, and on these the solid does not
// depend on the plane. Three-valued logic cannot know that; cut by all three, cells at the circle would be
// full of slivers.
#pragma once

#include "host/octree/octree.hpp"

namespace mortise::octree {

/// Rewrites the tapes of NIO leaves so that they do not name such surfaces, here and on the device. A
/// function of each leaf alone, so that faces stay alike from both sides. Returns how many leaves it changed.
std::uint64_t drop_coincident(device::Device& device, const tape::BoundModel& model, Octree& tree,
                              DeviceTree& on_device, int threads);

}  // namespace mortise::octree
