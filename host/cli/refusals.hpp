// Meshes that are not handed out, or only with a complaint.
#pragma once

#include "host/cli/documents.hpp"
#include "mortise/check.hpp"

namespace mortise::cli {

/// Throws Error(kMeshing) if a corner of an element is flat or inside out: cheap to see, so looked for
/// always.
void refuse_inverted(const MeshFigures& figures);

/// Throws Error(kMeshing) for the first defect.
void refuse_defects(const CheckReport& check);

/// Throws Error(kQuality) if an element's scaled Jacobian is below the floor; a negative floor asks for
/// nothing. The files are written: the user may want to look at what is bad.
void refuse_below(const Mesh& mesh, const std::vector<float>& jacobians, double floor);

}  // namespace mortise::cli
