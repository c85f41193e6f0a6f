// What a run would make and take, without it.
#pragma once

#include <functional>

#include "host/device/device.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Meshes a model, with these options.
using TrialRun = std::function<Mesh(const Model& model, const MeshOptions& options, MeshReport& report)>;

/// As Mesher::estimate. `open_device` is called when the device is needed.
MeshEstimate estimate(const std::function<device::Device&()>& open_device, const Model& model,
                      const MeshOptions& options, const TrialRun& run);

}  // namespace mortise::pipeline
