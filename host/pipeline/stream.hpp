// Meshes that are handed on part by part.
#pragma once

#include <functional>

#include "host/device/device.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Mesher::stream on a device that is opened when it is needed; `out` is empty.
void stream(const std::function<device::Device&()>& open_device, const Model& model,
            const MeshOptions& options, MeshSink& sink, MeshReport& out);

}  // namespace mortise::pipeline
