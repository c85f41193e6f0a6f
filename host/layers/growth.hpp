// Which way layers leave a wall, and how far they reach into the solid where nothing is in their way.
#pragma once

#include <vector>

#include "host/layers/slides.hpp"
#include "host/layers/walls.hpp"
#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::layers {

/// Layers of a wall, from the wall inward.
struct Heights {
    int count = 0;
    double first = 0;   ///< of the layer at the wall, model units; 0: from the lengths of the wall's edges
    double growth = 1;  ///< of each layer to the one before it

    /// How far the first `layers` of them reach, in heights of the first.
    double sum(int layers) const;
    /// The same as a part of all.
    double share(int layers) const { return sum(layers) / sum(count); }
};

struct Growth {
    std::vector<Vec3> reach;     ///< by place of the wall node: from it to the layers' other side; bare: zero
    std::vector<Across> fixed;   ///< likewise: where it must not come farther, or less far; bare: everywhere
    std::vector<double> height;  ///< likewise: of all layers, at right angles to the wall
    std::vector<double> asked;   ///< likewise: what it should be, if that is more than there can be room for
    std::vector<double> edges;   ///< likewise: mean length of the wall's edges around
};

/// Makes nodes bare from where no direction leads away from all facets, those that cannot slide, and those at
/// rims where the facet without layers lies on the other side of the wall's edge, so that layers would leave
/// it. Throws Error(kUsage) if layers are so thin that their nodes are one.
Growth find_growth(const Mesh& mesh, const Slides& slides, const Heights& heights, int threads, Walls& walls);

}  // namespace mortise::layers
