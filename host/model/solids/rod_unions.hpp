// Rods that end in balls of their radius, as hulls of two balls.
#pragma once

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// In each union with its subunions: a cylinder on whose ends lie balls of its radius becomes the hull of
/// both, and the balls, which are parts of it, vanish. The solid is the same, but for what is lost by the six
/// figures that OpenSCAD writes (1/1000 of the radius at most); but the rod is one smooth surface (kRounded)
/// in place of a cylinder and two balls that touch along circles, and all rods of a joint share their ball
/// exactly. The hull has the cylinder's name. Rods that touch a plane of another part along a line (a rounded
/// box made of boxes, cylinders and balls) stay: what goes on smoothly there is told apart better. Shared
/// nodes, and those with sizes or bounds of their own, are left alone.
void join_rods(Model& model);

}  // namespace mortise::model_reader
