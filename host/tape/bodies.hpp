// Bodies of a surface of triangles that run through each other.
#pragma once

#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Takes a surface apart whose bodies, closed and the right way out each, may cross, as programs write them
/// that put parts into one file without joining them: into as few polyhedra as keep bodies apart whose boxes
/// touch, so that the solid is the union of these. A cell where bodies cross then has the faces of each, not
/// samples of the winding number. Any other surface (one body, holes, cavities) stays as it is.
std::vector<WorldPolyhedron> split_bodies(WorldPolyhedron polyhedron);

}  // namespace mortise::tape
