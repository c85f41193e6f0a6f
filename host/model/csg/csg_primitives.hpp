// The solids of a .csg file: cube, sphere and cylinder.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Each appends nodes to the model and returns the top one; throws Error(kInput) with the place.
std::uint32_t add_csg_cube(Model& model, const CsgNodeText& node);
std::uint32_t add_csg_sphere(Model& model, const CsgNodeText& node);
std::uint32_t add_csg_cylinder(Model& model, const CsgNodeText& node);

}  // namespace mortise::model_reader
