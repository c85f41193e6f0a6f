// A plane shape as convex parts that do not overlap.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// Divides a normalised shape (polygons.hpp) into triangles, and joins these while they stay convex (Hertel &
/// Mehlhorn 1983: at most four times as many parts as need be): loops of its own corners, counter-clockwise.
/// None if there would be more than `most`.
std::optional<Contours> convex_parts(const Contours& shape, std::size_t most);

}  // namespace mortise::model_reader
