// The middle of a facet.
#pragma once

#include "host/common/vec3.hpp"
#include "mortise/mesh.hpp"

namespace mortise {

/// The mean of its corners, in model units.
inline Vec3 facet_middle(const Mesh& mesh, std::size_t facet) {
    const FacetNodes nodes = mesh.facets.facet(facet);
    Vec3 middle{};
    for (const NodeId node : nodes) {
        const double* const p = mesh.points.data() + 3 * std::size_t{node};
        for (std::size_t j = 0; j < 3; ++j) middle[j] += p[j] / static_cast<double>(nodes.size());
    }
    return middle;
}

}  // namespace mortise
