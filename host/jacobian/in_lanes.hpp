// Scaled Jacobians on host threads, eight elements at a time: for meshes too small to load kernels for.
#pragma once

#include <vector>

#include "host/jacobian/jacobian.hpp"
#include "mortise/mesh.hpp"

namespace mortise::jacobian {

/// The same bits as mortise::scaled_jacobians, from which they come where the compiler has no lanes. Node
/// numbers must be in range.
std::vector<float> scaled_jacobians_in_lanes(const Mesh& mesh, int threads, const KnownShapes& known = {});

/// The tetrahedra up to the last of the known sixths; their number.
std::size_t tetrahedra_with_sixths(const Mesh& mesh, const IndexRuns& sixths, int threads, float* values);

/// Puts the values of some hexahedra in their places.
void correct_cubes(const Mesh& mesh, const IndexRuns& cubes, float* values);

}  // namespace mortise::jacobian
