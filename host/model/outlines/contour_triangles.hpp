// Triangles of plane shapes with holes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// Triangles of a normalised shape (polygons.hpp), counter-clockwise, of its own corners, which are numbered
/// loop after loop.
std::vector<std::array<std::uint32_t, 3>> triangulate(const Contours& loops);

}  // namespace mortise::model_reader
