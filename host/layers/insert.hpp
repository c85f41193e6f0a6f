// Puts layers into a mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "host/layers/band.hpp"
#include "host/layers/fit.hpp"
#include "host/layers/growth.hpp"
#include "host/layers/walls.hpp"
#include "mortise/mesh.hpp"

namespace mortise::layers {

/// Moves nodes and adds elements of kind kLayer behind all others of their type, facet by facet, from the
/// wall inward. Nodes on walls keep their numbers; new ones, those of a wall node one after the other, come
/// last. Facets where layers end on open and inner facets are added; `facet_surface` grows with them.
void insert_layers(const Walls& walls, const Band& band, const Heights& heights, const Fit& fit, int threads,
                   Mesh& mesh, std::vector<std::uint32_t>& facet_surface);

}  // namespace mortise::layers
