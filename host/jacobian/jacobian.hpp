// Scaled Jacobians of all elements: what mortise::scaled_jacobians (mortise/check.hpp) computes one by one,
// which stays the independent check of it.
//
// Three ways there, with the same bits: host threads, eight elements at a time; our own kernel; or CLBlast's
// product of the nodes' coordinates with a matrix of 0, 1 and -1 for each element type, (3N × 8)·(8 × 24) for
// hexahedra, which gives the edges at all corners with one rounding each, as subtraction does (bench: section
// jacobians).
#pragma once

#include <optional>
#include <vector>

#include "host/common/index_run.hpp"
#include "host/device/device.hpp"
#include "mortise/mesh.hpp"

namespace mortise::jacobian {

/// Shapes that need no look at their nodes.
struct KnownShapes {
    /// Not null: all hexahedra of kind kIn but these are boxes along the axes.
    const IndexRuns* moved_cubes = nullptr;
    /// Tetrahedra that are sixths of cubes, with edges of 1, 1, 1, √2, √2 and √3, ascending; may be null.
    const IndexRuns* sixths = nullptr;
};

/// Scaled Jacobian of a sixth of a cube, 1/√6. Nodes give the same float if no coordinate is larger than so
/// many edges of the cube: what rounding of coordinates then does to it (3e-11) is less than what the next
/// float would need (1e-10).
inline constexpr float kSixth = 0.408248290463863f;
inline constexpr double kExactEdges = 65536;

enum class Method { kHost, kOwn, kProduct };

/// $MORTISE_JACOBIANS: "host", "own" or "clblast"; nothing if it is not set. Throws Error(kUsage) for another
/// word.
std::optional<Method> wanted_method();

/// The host for small meshes, where loading kernels takes longer; else our own kernel, the faster one on all
/// devices measured.
Method usual_method(std::size_t elements);

/// Scaled Jacobian per element, in the order of mesh.elements. Node numbers must be in range. CLBlast builds
/// its kernels, for many seconds where the driver has not kept them, at the first product of a process.
/// Meshes whose coordinates exceed the device's largest allocation stay on the host. `threads` make room, in
/// the memory of `old` if it fits. Known shapes are not looked at (kProduct does).
std::vector<float> scaled_jacobians(device::Device& device, const Mesh& mesh, Method method, int threads = 0,
                                    const KnownShapes& known = {}, std::vector<float> old = {});

}  // namespace mortise::jacobian
