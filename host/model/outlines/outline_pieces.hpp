// Outlines of letters and drawings: which loops are filled, and how finely curves are drawn.
#pragma once

#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// Adds loops that are filled by winding, as fonts and drawings do, to a union of pieces: loops that turn as
/// the largest one are filled, the others are holes in the smallest filled loop around. Pieces that overlap
/// stay separate, so that their union is right where even-odd would make a hole.
void add_winding_pieces(Contours loops, std::vector<Contours>& pieces);

/// Straight pieces of a full circle, as OpenSCAD counts them.
int fragments_of(double radius, double fn, double fa, double fs);

}  // namespace mortise::model_reader
