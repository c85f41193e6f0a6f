// Layers of flat elements at walls (prism layers, boundary layers): a mesh makes room for them and gets them.
//
// Each node of the walls is doubled. The wall keeps the one, elements behind it get the other, which moves
// into the solid by the layers' height; nodes behind that follow, less and less, over some rings of elements
// (the band). Between the two lie stacks of wedges and hexahedra on the wall's facets. Facets that get no
// layers keep their surfaces: nodes there slide along these, and where layers end at them their sides become
// facets. Every element is looked at: where one would be too flat, layers are lower, down to none. So layers
// take nothing from a valid mesh, and the walls stay as they are.
//
// Sources: the doubling and shrinking is that of Garimella and Shephard, "Boundary layer mesh generation for
// viscous flow simulations" (2000); directions by the narrowest cone of normals: Kallinderis and Ward,
// "Prismatic grid generation for three-dimensional complex geometries" (1993), Aubry and Löhner, "On the
// 'most normal' normal" (2008).
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"
#include "mortise/mesher.hpp"

namespace mortise::layers {

/// Adds layers to a mesh whose surfaces have names; `facet_surface`, by facet its surface in the model, grows
/// with the facets. Walls: as LayerOptions::on says. Deterministic. Throws Error(kMeshing) if there are too
/// many nodes.
LayerFigures add_layers(Mesh& mesh, std::vector<std::uint32_t>& facet_surface, const tape::BoundModel& model,
                        const LayerOptions& options, int threads);

}  // namespace mortise::layers
