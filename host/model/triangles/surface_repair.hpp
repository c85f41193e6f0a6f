// Makes a closed, outward surface of triangles of what files hold.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// What repair_surface found.
struct SurfaceFindings {
    std::size_t open_edges = 0;      ///< edges with only one triangle
    std::size_t crowded_edges = 0;   ///< edges with more than two triangles
    std::size_t turned = 0;          ///< triangles turned over because their neighbours disagreed
    std::size_t flat_triangles = 0;  ///< dropped: without area
    std::size_t repeated = 0;        ///< triangles dropped: there was the same one before
    std::size_t joined = 0;          ///< points at open edges joined with others
    double crack = 0;                ///< how far these were apart at most
    bool inverted = false;           ///< the whole surface was turned inside out
};

/// Joins equal points (exactly equal, then within 1e-9 of the box's diagonal; at open edges as far apart as
/// it takes to close them, up to 1e-4, which also
/// aligns coordinates that differ by less), drops repeated triangles, those without area and points that no
/// triangle uses, turns triangles over where neighbours disagree (to the side of the majority of a connected
/// piece) and the whole surface where its volume is negative.
SurfaceFindings repair_surface(TriangleSurface& surface);

/// One line for each thing that the user should know, `source` in front.
std::vector<std::string> surface_warnings(const SurfaceFindings& findings, const std::string& source);

/// Six times the volume enclosed, relative to the first point; positive if triangles are counter-clockwise
/// seen from outside.
double six_volumes(const TriangleSurface& surface);

}  // namespace mortise::model_reader
