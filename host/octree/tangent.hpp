// Surfaces that touch each other smoothly: a cylinder and the plane that goes on from it, a sphere that caps
// a cylinder, a torus between two planes.
//
// A slot is made of two cylinders and the box between them. Where box and cylinder meet, the box's side is
// tangent to the cylinder, and the cylinder lies inside the side's half-space: one of the four choices of
// their two signs never occurs. Three-valued logic cannot know that. Cut by both, cells at such a joint
// would be full of slivers, as flat as the film between the two surfaces.
#pragma once

#include <cstdint>

#include "host/common/vec3.hpp"
#include "host/octree/joint.hpp"
#include "host/octree/leaf_formula.hpp"
#include "host/tape/compile.hpp"

namespace mortise::octree {

/// A leaf of the tree, box-local.
struct LeafBox {
    Vec3 centre;
    double edge;
};

/// Rewrites the formula of a leaf, so that tangent surfaces do not both cut it where one of them changes
/// nothing: one takes the place of the other, everywhere or on one side of a third surface (the end of the
/// box that lies in the cylinder). The solid stays the same but for films thinner than 1e-4 of a cell.
/// Where the third surface has no other role, the two are one surface of the leaf: `joint` tells; its tape is
/// empty where there is none. A function of the leaf alone. Returns whether the formula changed or there is
/// a joint.
bool join_tangent(const tape::BoundModel& model, const LeafBox& leaf, LeafFormula& formula, LeafJoint& joint);

}  // namespace mortise::octree
