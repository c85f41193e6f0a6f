// Points and directions: sums, products and lengths.
#pragma once

#include <cmath>

#include "mortise/model.hpp"

namespace mortise {

inline Vec3 sum(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 scaled(const Vec3& v, double by) { return {v[0] * by, v[1] * by, v[2] * by}; }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double squared_length(const Vec3& v) { return dot(v, v); }
inline double length(const Vec3& v) { return std::sqrt(dot(v, v)); }

/// Of length 1; a vector of length 0 stays.
inline Vec3 unit(const Vec3& v) {
    const double size = length(v);
    return size > 0 ? Vec3{v[0] / size, v[1] / size, v[2] / size} : v;
}

}  // namespace mortise
