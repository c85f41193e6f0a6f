// The solids of a .csg file: cube, sphere, cylinder and the matrix of multmatrix.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Each appends nodes to the model and returns the top one; throws Error(kInput) with the place.
std::uint32_t add_csg_cube(Model& model, const CsgNodeText& node);
std::uint32_t add_csg_sphere(Model& model, const CsgNodeText& node);
std::uint32_t add_csg_cylinder(Model& model, const CsgNodeText& node);

/// The 4×4 matrix of a multmatrix node: finite, last row 0, 0, 0, 1; it may be singular.
Affine csg_matrix(const CsgNodeText& node);

}  // namespace mortise::model_reader
