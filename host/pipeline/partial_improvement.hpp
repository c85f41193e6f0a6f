// Improvement of a mesh that is made in parts: its scope is collected, improved as a mesh of its own, and
// what has changed is told in terms of the whole mesh.
#pragma once

#include <vector>

#include "host/improve/improve.hpp"
#include "host/improve/scope.hpp"
#include "host/pipeline/parts.hpp"

namespace mortise::pipeline {

/// How the improved mesh differs from its parts as they are made. Nodes that are new are numbered behind all
/// others; final numbers leave out the nodes that are gone.
struct Changes {
    std::uint64_t old_nodes = 0;
    std::vector<NodeId> gone;                                     ///< nodes, ascending
    std::array<std::vector<std::uint32_t>, kElementTypes> taken;  ///< elements, ascending
    std::vector<NodeId> placed;  ///< nodes that may have moved, ascending; the last ones are new
    /// points: of the nodes `placed`; elements that come behind all others, in terms of `points`.
    Mesh added;
    FacetBlock facets;  ///< all facets of the mesh, not yet with final numbers

    NodeId final_number(NodeId node) const {
        return node - static_cast<NodeId>(std::lower_bound(gone.begin(), gone.end(), node) - gone.begin());
    }
    std::uint64_t final_nodes() const {
        const std::uint64_t last = placed.empty() ? 0 : placed.back() + std::uint64_t{1};
        return std::max(old_nodes, last) - gone.size();
    }
};

/// Changes that leave everything as it is.
Changes no_changes(const Parts& parts, FacetBlock facets);

/// Improves what is in the scope; all parts must have been made once. Throws Error(kDevice) if the scope does
/// not fit into MeshOptions::memory. `source`: the model's, for messages.
Changes improve_parts(device::Device& device, Parts& parts, improve::Scope& scope, FacetBlock facets,
                      const Prepared& prepared, const MeshOptions& options, const std::string& source,
                      Stages& stages, MeshReport& out);

}  // namespace mortise::pipeline
