// Quality by which elements are compared while they are improved.
//
// One number, from the worst dihedral angle and the worst scaled Jacobian, scaled so that 18 degrees, 155
// degrees and a scaled Jacobian of 0.2 are the same value: kGoodQuality. Only + - * / and square roots
// decide, so that results do not depend on the platform's library.
#pragma once

#include <array>

#include "host/common/vec3.hpp"

namespace mortise::improve {

using Point = Vec3;
using mortise::cross;  // beside those of quality_formula.hpp
using mortise::dot;

inline Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Point operator*(double s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }

inline constexpr double kGoodQuality = 0.309;     ///< sin 18°
inline constexpr double kObtuseWeight = 0.7312;   ///< sin 18° / sin 155°
inline constexpr double kJacobianWeight = 1.545;  ///< sin 18° / 0.2
inline constexpr double kAnglesOnly = 1e3;        ///< as a weight of Jacobians: angles alone decide
inline constexpr double kInvertedQuality = -1;    ///< of elements that are not positive

/// No change may make an element flatter than this, whatever it replaces: rounding decides nothing.
inline constexpr double kLowestQuality = 1e-9;
/// Volumes below this, in cells and relative to the longest edge squared, may be rounding of the positions.
inline constexpr double kVolumeRounding = 1e-12;

/// Quality of a tetrahedron, at most 1.1; kInvertedQuality if it is not positive (mesh.hpp's orientation).
double tetrahedron_quality(const Point& a, const Point& b, const Point& c, const Point& d,
                           double rounding = kVolumeRounding);

/// Positive if the orientation is that of mesh.hpp.
inline double tetrahedron_volume(const Point& a, const Point& b, const Point& c, const Point& d) {
    return dot(cross(b - a, c - a), d - a) / 6;
}

/// Of a tetrahedron.
double smallest_height(const std::array<Point, 4>& p);

/// Quality at a corner where three edges u, v, w meet, right-handed: its three dihedral angles and its
/// scaled Jacobian, times the weight.
double corner_quality(const Point& u, const Point& v, const Point& w,
                      double jacobian_weight = kJacobianWeight);

/// Quality of a pyramid, by the corners of its base.
double pyramid_quality(const std::array<Point, 5>& p);

}  // namespace mortise::improve
