// What MeshOptions may hold: check_options of mortise/mesher.hpp, and what is asked apart from it.
#pragma once

#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Throws Error(kUsage) for a negative size.
void check_work_group(int size);

}  // namespace mortise::pipeline
