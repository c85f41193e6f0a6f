// Small affine algebra for the model readers: maps are row-major 3×4 (mortise::Affine) and send local
// to parent coordinates.
#pragma once

#include <cmath>

#include "host/common/vec3.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

inline double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

inline double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(length(cross(a, b)), dot(a, b));
}

/// v divided by its length; exact for vectors along a coordinate axis. Precondition: v is finite, not zero.
Vec3 unit(const Vec3& v);

/// A point's image.
inline Vec3 image(const Affine& m, const Vec3& p) {
    return {m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3], m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
            m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]};
}

Affine translation(const Vec3& shift);

/// The map x -> x0·column0 + x1·column1 + x2·column2 + origin.
Affine from_columns(const Vec3& column0, const Vec3& column1, const Vec3& column2, const Vec3& origin);

/// A right-handed orthonormal frame at `origin` whose z axis is `axis`; exact for coordinate axes.
Affine frame_along(const Vec3& axis, const Vec3& origin);

/// first, then second.
Affine compose(const Affine& second, const Affine& first);

/// Precondition: regular.
Affine inverse_of(const Affine& map);

/// Determinant of the linear part after its columns were scaled to unit length: 1 for a map that keeps
/// right angles, 0 for a singular one, whatever its scale. 0 if an entry is not finite.
double relative_determinant(const Affine& map);

/// Below this relative determinant a map counts as singular.
inline constexpr double kSingular = 1e-12;

}  // namespace mortise::model_reader
