// Meshes that come in parts: what makes them, and what takes them, meet here.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise {

/// How much of a mesh there will be.
struct MeshTotals {
    std::uint64_t nodes = 0;
    std::array<std::uint64_t, kElementTypes> elements{};
};

/// Receives a mesh part by part, so that it need not fit into memory. Called by the thread that meshes. What
/// it throws ends the run, and goes to the caller of Mesher::stream (std::bad_alloc as Error(kDevice)).
class MeshSink {
  public:
    virtual ~MeshSink() = default;

    /// Called once, first. `outline` has the facets, with the node numbers of the whole mesh, and the names
    /// of regions and surfaces; no nodes, no elements. It is gone afterwards.
    virtual void begin(const MeshTotals& totals, const Mesh& outline) = 0;

    /// The next nodes (points and model_dimension), and the next elements of each type, with the node numbers
    /// of the whole mesh, which may be those of nodes to come; their scaled Jacobians, type by type. A part
    /// has no facets and no names: begin() had them.
    virtual void add(const Mesh& part, const std::vector<float>& scaled_jacobians) = 0;
};

}  // namespace mortise
