// The 2D nodes of a .csg file, and what makes solids of them. The functions of nodes with children read the
// arguments and return what is to be done with the children.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "host/model/csg/csg_scene.hpp"

namespace mortise::model_reader {

CsgOperand read_square(CsgScene& scene, const CsgNodeText& node);
CsgOperand read_circle(CsgScene& scene, const CsgNodeText& node);
CsgOperand read_polygon(CsgScene& scene, const CsgNodeText& node);

CsgFinish read_linear_extrude(CsgScene& scene, const CsgNodeText& node);
CsgFinish read_rotate_extrude(CsgScene& scene, const CsgNodeText& node);

CsgFinish read_offset(CsgScene& scene, const CsgNodeText& node);
CsgFinish read_fill(CsgScene& scene, const CsgNodeText& node);
CsgFinish read_hull(CsgScene& scene, const CsgNodeText& node);
CsgFinish read_minkowski(CsgScene& scene, const CsgNodeText& node);
CsgFinish read_resize(CsgScene& scene, const CsgNodeText& node);
CsgFinish read_projection(CsgScene& scene, const CsgNodeText& node);

}  // namespace mortise::model_reader
