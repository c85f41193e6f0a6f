// Kernels compiled before they are needed, by several processes at once.
#pragma once

#include <cstddef>

#include "host/cli/progress.hpp"
#include "mortise/kernels.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

/// Builds what `builder` needs in as many processes as `threads` says (0: all cores). Call it before a driver
/// is opened and before any thread has been started. Returns how many programs were built; what fails can be
/// built again to hear why.
std::size_t build_in_processes(KernelBuilder& builder, int threads, Progress& progress);

/// The first run on a machine: builds the kernels that every mesh needs, unless an earlier run did. What
/// fails is left to the run itself, which says why.
std::size_t build_kernels_ahead(const MeshOptions& options, Progress& progress);

}  // namespace mortise::cli
