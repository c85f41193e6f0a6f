// Which flat faces of a polyhedron are facets of one curved surface.
#pragma once

#include "host/tape/facets.hpp"

namespace mortise::tape {

/// Numbers the patches of facets.planes in the order of their first planes (Facets::patch_of_plane, patches).
/// Planes are of one patch if they share an edge at which the normal turns by no more than `sharp_angle`
/// degrees, and
/// - by no more than 10 degrees, or
/// - both have two triangles at most, as facets of a curve do and faces that were cut do not, or
/// - the surface goes on turning like that: the edge is one of three in a row, from face to face straight on,
///   all convex or all concave, at which the normal turns by not much less or more. So a fillet of two facets
///   between its flat neighbours is round, and two blocks that meet at 30 degrees have a crease.
/// Groups of triangles are patches of their own. A ring of planes that would meet itself at a crease, as
/// around a teardrop, becomes two patches (best_parting in host/common/parting.hpp).
void find_patches(const TriangleSurface& surface, double sharp_angle, Facets& facets);

}  // namespace mortise::tape
