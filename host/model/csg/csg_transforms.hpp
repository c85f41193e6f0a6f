// The nodes of .csg files that move their children. OpenSCAD writes all of them as multmatrix; the others are
// for files written by hand or by programs.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "host/model/csg/csg_scene.hpp"

namespace mortise::model_reader {

/// m: four rows of four numbers, the last one 0, 0, 0, 1.
CsgFinish read_multmatrix(CsgScene& scene, const CsgNodeText& node);
/// v: two or three numbers.
CsgFinish read_translate(CsgScene& scene, const CsgNodeText& node);
/// a: up to three angles in degrees, about x, then y, then z; or one, about the axis v (default z).
CsgFinish read_rotate(CsgScene& scene, const CsgNodeText& node);
/// v: one number, or two or three.
CsgFinish read_scale(CsgScene& scene, const CsgNodeText& node);
/// v: normal of the mirror; nothing moves if it is zero.
CsgFinish read_mirror(CsgScene& scene, const CsgNodeText& node);

}  // namespace mortise::model_reader
