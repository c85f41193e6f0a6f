// Coordinates that can be computed with.
#pragma once

namespace mortise {

/// Products of three are still finite, and those of the smallest do not vanish.
inline constexpr double kLargestCoordinate = 1e100;
inline constexpr double kSmallestCoordinate = 1e-100;
/// The first one, in messages.
inline constexpr const char* kLargestCoordinateText = "1e100";

}  // namespace mortise
