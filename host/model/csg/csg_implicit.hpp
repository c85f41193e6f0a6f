// Solids of a .csg file that formulas describe: Mortise's own nodes beside those of OpenSCAD.
//
// implicit("formula", bounds = [[x0, y0, z0], [x1, y1, z1]])   bounds: the solid is cut there; may be left
// out gyroid, schwarz_p, schwarz_d(size, period, thickness, center)
//     Triply periodic minimal surfaces in a box as that of cube(size, center). A sheet of about that
//     thickness; 0: the solid on one side of the surface, half of the box.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Appends the nodes and returns the top one; throws Error(kInput) with the place.
std::uint32_t add_csg_implicit(Model& model, const CsgNodeText& node);

}  // namespace mortise::model_reader
