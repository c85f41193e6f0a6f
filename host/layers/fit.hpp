// How much of the layers' full height there is room for, so that every element is valid.
#pragma once

#include <cstdint>
#include <vector>

#include "host/layers/band.hpp"
#include "host/layers/growth.hpp"
#include "host/layers/slides.hpp"
#include "host/layers/walls.hpp"
#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::layers {

/// Where nodes come.
struct Fit {
    std::vector<double> share;  ///< by place of the wall node: of the layers' full height; 0: none
    std::vector<Vec3> inner;    ///< by slot: what elements behind the layers have as node
    std::vector<Vec3> between;  ///< by place of the wall node: after each layer but the last; count - 1 each
};

/// Full heights first. Where an element would be too flat, the walls nearest to it get less, and walls around
/// little more than these, until none is; walls that would get next to nothing get nothing. Nodes that no
/// wall nearby moves any more, but one behind, stay. So a mesh that is valid stays valid.
Fit fit_layers(const Mesh& mesh, const Walls& walls, const Band& band, const Slides& slides,
               const Growth& growth, const Heights& heights, int threads);

}  // namespace mortise::layers
