// Scaled Jacobians on host threads, eight elements at a time: for meshes too small to load kernels for.
#pragma once

#include <vector>

#include "host/common/index_run.hpp"
#include "mortise/mesh.hpp"

namespace mortise::jacobian {

/// The same bits as mortise::scaled_jacobians, from which they come where the compiler has no lanes. Node
/// numbers must be in range. `moved_cubes`: as for scaled_jacobians of jacobian.hpp.
std::vector<float> scaled_jacobians_in_lanes(const Mesh& mesh, int threads,
                                             const IndexRuns* moved_cubes = nullptr);

/// Puts the values of some hexahedra in their places.
void correct_cubes(const Mesh& mesh, const IndexRuns& cubes, float* values);

}  // namespace mortise::jacobian
