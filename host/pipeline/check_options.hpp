// What MeshOptions may hold.
#pragma once

#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Throws Error(kUsage) for a negative size.
void check_work_group(int size);

/// Throws Error(kUsage) for options out of range, and for those that exclude each other, with name and value.
void check_options(const MeshOptions& options);

}  // namespace mortise::pipeline
