// Scaled Jacobians on host threads, eight elements at a time: for meshes too small to load kernels for.
#pragma once

#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::jacobian {

/// The same bits as mortise::scaled_jacobians, from which they come where the compiler has no lanes. Node
/// numbers must be in range.
std::vector<float> scaled_jacobians_in_lanes(const Mesh& mesh, int threads);

}  // namespace mortise::jacobian
