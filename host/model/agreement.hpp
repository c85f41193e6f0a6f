// What counts as equal in a model that a program wrote.
#pragma once

#include <algorithm>
#include <cmath>

#include "host/model/affine.hpp"

namespace mortise::model_reader {

/// Lengths and angles that agree so far are equal: matrices are written with six digits.
inline constexpr double kSame = 1e-6;

inline bool same(double a, double b) {
    return std::fabs(a - b) <= kSame * std::max(std::fabs(a), std::fabs(b));
}

inline bool perpendicular(const Vec3& a, const Vec3& b) {
    return std::fabs(dot(a, b)) <= kSame * length(a) * length(b);
}

}  // namespace mortise::model_reader
