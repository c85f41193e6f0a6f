// Faces of leaves that are split in two triangles, as three of their corners snap onto a surface.
#pragma once

#include "host/octree/octree.hpp"

namespace mortise::octree {

/// Of face f of a leaf: the corner, by its place in kFaceCorners, that is not on a surface on which the three
/// others are, some of them because they snap; 4 if there is none. A whole face and the surface would have no
/// angle between them at the opposite corner. Both leaves at the face tell the same.
std::size_t odd_corner(const Octree& tree, const tape::BoundModel& model, std::uint64_t leaf, int f);

}  // namespace mortise::octree
