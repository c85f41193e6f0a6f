// Small pieces of the finished mesh that the model does not have apart: crumbs of a pin that is thinner than
// the cells, closed hollows where a hole goes on.
//
// Samples may see a thin pin here and there. Where they do, cells hold what they saw, with true facets around
// it and nothing between: no cell is wrong by itself, and no facet false (false_facets.hpp). But then the
// mesh has a small piece on its own, and the model tells whether it goes on beyond it.
#pragma once

#include <cstdint>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::probe {

/// Pieces of a region, and hollows in the solid, that few facets bound, each by its lowest facet.
struct SmallPieces {
    /// Where the model goes on beyond the piece: what is there, how long the piece is, how thick the model.
    std::vector<MissedFeature> torn;
    /// Bounds of the others, model units.
    struct Sound {
        Vec3 low{}, high{};
        bool material;
    };
    std::vector<Sound> sound;
};

/// `points` of the facets' nodes, model units.
SmallPieces find_small_pieces(const tape::BoundModel& model, const octree::Octree& tree,
                              const std::vector<double>& points, const FacetBlock& facets, int threads);

}  // namespace mortise::probe
