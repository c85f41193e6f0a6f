// Linear programs in three variables.
#pragma once

#include <optional>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::tape {

/// normal · x <= offset; the normal has unit length.
struct HalfSpace {
    Vec3 normal{};
    double offset = 0;
};

/// Coordinates that a linear program looks at; lengths are best chosen so that what matters is near 1.
constexpr double kFarthest = 1e6;

/// The point that goes farthest along `direction` in all half-spaces and in the cube |x_j| <= kFarthest;
/// nothing where no point is in all of them. Half-spaces are taken 1e-9 larger than they are, which is what
/// rounding needs. Seidel's method (Small-dimensional linear programming and convex hulls made easy, 1991),
/// in an order that depends on the number of half-spaces alone: expected time linear in it.
std::optional<Vec3> farthest(const std::vector<HalfSpace>& half_spaces, const Vec3& direction);

}  // namespace mortise::tape
