// Numbers of mathematics.
#pragma once

#include <limits>

namespace mortise {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kTurn = 2 * kPi;       ///< radians in a full turn
inline constexpr double kDegrees = 180 / kPi;  ///< in a radian
inline constexpr double kRadians = kPi / 180;  ///< in a degree
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace mortise
