// Closed surfaces of triangles for the tests.
#pragma once

#include <cstdint>

#include "mortise/model.hpp"

namespace mortise::test {

/// Prism over a simple, star-shaped about point 0, counter-clockwise outline, from z = 0 to `height`. With
/// `named`, caps and sides are groups.
TriangleSurface prism(const std::vector<std::array<double, 2>>& outline, double height, bool named = false);

/// An L of five unit squares, one unit high: volume 5, area 2·5 + 12.
TriangleSurface l_block();

/// An octahedron divided `depth` times: 8·4^depth triangles with corners on the unit sphere.
TriangleSurface unit_sphere(int depth);

/// unit_sphere with a random radius in [low, high] for every corner: not convex.
TriangleSurface random_star(std::uint64_t seed, int depth, double low, double high);

/// A model of one region that holds the surface.
Model solid_of(TriangleSurface surface, double sharp_angle, const Affine& map = kIdentity);

}  // namespace mortise::test
