// Round primitives as the polyhedra that OpenSCAD makes of them.
#pragma once

#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// The side planes of a regular n-sided frustum about z: vertex 0 of each ring on +x, circumradius
/// `radius` + `slope`·z.
void add_frustum_sides(std::vector<Plane>& planes, int n, double radius, double slope);

/// Rings of n vertices at polar angles 180 (i + 1/2) / rings; the first and last are flat caps.
Primitive facetted_sphere(double radius, int n);

}  // namespace mortise::model_reader
