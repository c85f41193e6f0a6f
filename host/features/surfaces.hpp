// Model surfaces at points of the mesh: unit normals, and how surfaces meet.
#pragma once

#include <algorithm>
#include <cmath>

#include "host/quality/vector.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/singular_point.hpp"

namespace mortise::features {

using quality::point_of;
using quality::Vector;

/// Surfaces whose normals differ by less (about 5 degrees) meet smoothly: there is no crease.
inline constexpr double kSharpSine = 0.0872;

/// Three unit normals span space if their determinant is larger.
inline constexpr double kSpanning = 1e-3;

/// A point of the model closer than this to a node, in edges of the root box, is that node.
inline constexpr double kSamePoint = 1e-6;
/// In trees of this level and more, it must be closer: by half for each level more.
inline constexpr int kSamePointLevel = 11;

inline double same_point(int level) { return std::ldexp(kSamePoint, std::min(0, kSamePointLevel - level)); }

inline Vector to_local(const tape::BoundModel& model, const Vector& p) {
    return (1 / model.side) * (p - Vector{model.origin[0], model.origin[1], model.origin[2]});
}

inline Vector to_model(const tape::BoundModel& model, const Vector& p) {
    return Vector{model.origin[0], model.origin[1], model.origin[2]} + model.side * p;
}

inline SurfaceSample sample(const tape::BoundModel& model, std::uint32_t surface, const Vector& local) {
    return surface_sample(&model.surfaces[surface], model.expression_ops.data(), local.x, local.y, local.z);
}

inline double value(const tape::BoundModel& model, std::uint32_t surface, const Vector& local) {
    return surface_value(&model.surfaces[surface], model.expression_ops.data(), local.x, local.y, local.z);
}

/// The vector over its length; zero for one without length, or not finite.
inline Vector unit(const Vector& v) {
    const double square = dot(v, v);
    return square > 0 && square < kMortiseInfinity ? (1 / std::sqrt(square)) * v : Vector{};
}

inline Vector unit_normal(const tape::BoundModel& model, std::uint32_t surface, const Vector& local) {
    const SurfaceSample s = sample(model, surface, local);
    return unit({s.gradient[0], s.gradient[1], s.gradient[2]});
}

/// Two unit normals belong to surfaces that meet at an angle.
inline bool is_sharp(const Vector& a, const Vector& b) { return length(cross(a, b)) > kSharpSine; }

/// Three unit normals belong to surfaces that meet in a point.
inline bool is_corner(const Vector& a, const Vector& b, const Vector& c) {
    return std::fabs(dot(cross(a, b), c)) > kSpanning && is_sharp(a, b) && is_sharp(b, c) && is_sharp(c, a);
}

/// The one point where a surface passes and its gradient vanishes or jumps: a cone's apex. False: none.
inline bool singular_point(const Surface& surface, Vector* point) {
    double p[3];
    if (!tape::singular_point(surface, p)) return false;
    *point = {p[0], p[1], p[2]};
    return true;
}

}  // namespace mortise::features
