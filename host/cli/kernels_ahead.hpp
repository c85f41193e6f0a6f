// The first run on a machine: its kernels are compiled by several processes at once.
#pragma once

#include <cstddef>

#include "host/cli/progress.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

/// Builds the kernels that every mesh needs, unless an earlier run did, in as many processes as
/// options.threads says (0: all cores). Call it before a driver is opened and before any thread has been
/// started. What fails is left to the run itself, which says why. Returns the number of programs built.
std::size_t build_kernels_ahead(const MeshOptions& options, Progress& progress);

}  // namespace mortise::cli
