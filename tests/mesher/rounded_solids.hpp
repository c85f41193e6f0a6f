// Solids whose faces go on smoothly into each other, made of overlapping parts as people make them: where two
// parts meet, the end of one lies inside the other, and its sides are tangent to it.
#pragma once

#include "tests/mesher/solids.hpp"

namespace mortise::test {

/// Two cylinders along z and a box between them: a slot, or a plate with round ends.
NodeIndex add_stadium(Model& model, double radius, double length, double low, double high);
/// A cylinder along z with a ball at each end.
NodeIndex add_capsule(Model& model, double radius, double length);
/// A box with the edges along z rounded: four cylinders and two boxes.
NodeIndex add_rounded_plate(Model& model, const Vec3& half, double radius);
/// A box with all edges and corners rounded: eight balls, twelve cylinders, three boxes.
NodeIndex add_rounded_box(Model& model, const Vec3& half, double radius);
/// A disc with a round rim: a torus and a cylinder.
NodeIndex add_rounded_disc(Model& model, double radius, double rim);
/// A cylinder along z and a box turned by 45 degrees with two faces tangent to it.
NodeIndex add_teardrop(Model& model, double radius, double low, double high);
/// A box one edge of which, along z, is rounded by what a box without a cylinder takes away.
NodeIndex add_filleted_box(Model& model, const Vec3& size, double radius);

}  // namespace mortise::test
