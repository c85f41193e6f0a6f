// Nodes of .csg files that bring their own geometry: polyhedron, text, import, surface; hulls and sums of
// solids.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "host/model/csg/csg_scene.hpp"

namespace mortise::model_reader {

CsgOperand read_polyhedron(CsgScene& scene, const CsgNodeText& node);
CsgOperand read_text(CsgScene& scene, const CsgNodeText& node);
/// Paths are relative to the .csg file.
CsgOperand read_import(CsgScene& scene, const CsgNodeText& node);
CsgOperand read_surface(CsgScene& scene, const CsgNodeText& node);

/// Plane shapes among the children are left out.
CsgOperand hull_of_solids(CsgScene& scene, const std::vector<CsgOperand>& children, const std::string& name,
                          SourceLocation where);
CsgOperand minkowski_of_solids(CsgScene& scene, const std::vector<CsgOperand>& children,
                               const std::string& name, SourceLocation where);

}  // namespace mortise::model_reader
