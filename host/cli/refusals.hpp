// Meshes that are not handed out, or only with a complaint.
#pragma once

#include "host/cli/figures.hpp"
#include "mortise/check.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

/// Throws Error(kMeshing) if a corner of an element is flat or inside out: cheap to see, so looked for
/// always.
void refuse_inverted(const MeshFigures& figures);

/// Throws Error(kMeshing) for the first defect.
void refuse_defects(const CheckReport& check);

/// Adds a warning of the worst element, and what to do about it, if it is far below what improvement leaves
/// elsewhere; whether it did. Meshes that were not improved have none.
bool warn_of_slivers(const MeshFigures& figures, const MeshOptions& options, MeshReport& report);

/// How many scaled Jacobians are below the floor; a negative floor asks for nothing.
std::uint64_t count_below(const std::vector<float>& jacobians, double floor);

/// What is wrong if elements are below the floor; empty if none is. Of a mesh, or of `elements` elements of
/// which `below` are, with words for the worst one.
std::string below_floor(const Mesh& mesh, const std::vector<float>& jacobians, double floor);
std::string below_floor(std::uint64_t below, std::uint64_t elements, double floor, const std::string& worst);

/// Throws Error(kQuality) with the message, if there is one. The files are written: the user may want to look
/// at what is bad.
void refuse_below(const std::string& message);

}  // namespace mortise::cli
