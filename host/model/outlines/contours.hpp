// Closed polylines in a plane: what 2D nodes that are no plain primitive (text, drawings, offsets) become.
#pragma once

#include <array>
#include <vector>

namespace mortise::model_reader {

using Vec2 = std::array<double, 2>;

/// Closed loops without a repeated last point; a point is inside by the even-odd rule over all loops.
using Contours = std::vector<std::vector<Vec2>>;

struct Disc {
    Vec2 center{};
    double radius = 0;  ///< 0: a point
};

}  // namespace mortise::model_reader
