// Unions of polygons with common corners: the fans, teeth and tiles of which scripts make outlines.
#pragma once

#include <cstdint>

#include "host/model/outlines/flat_tree.hpp"

namespace mortise::model_reader {

/// In each union of at least three polygons below `root`, and among what a difference takes away, those with
/// common corners become one shape: no edge is swept that lies inside another polygon, and edges of a curve
/// follow each other. Corners that stay keep their coordinates bit for bit; circles stay circles. Polygons
/// that only overlap (strokes with round joints) are better left alone: what meets there is meant to be
/// hidden.
void unite_polygons(FlatTree& tree, std::uint32_t root);

}  // namespace mortise::model_reader
