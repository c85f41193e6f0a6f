// A plane shape as convex parts that do not overlap.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// Cuts a normalised shape (polygons.hpp) along edges at its reentrant corners, until all parts are convex:
/// loops, counter-clockwise. None if there would be more than `most`.
std::optional<Contours> convex_parts(const Contours& shape, std::size_t most);

}  // namespace mortise::model_reader
