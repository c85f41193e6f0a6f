// Edges and boundary of a mesh, for comparisons at equal element size.
#pragma once

#include <string>

#include "mortise/mesh.hpp"

namespace mortise::bench {

/// Mean length of the edges, each counted once, diagonals of faces not at all. The mesh has elements.
double mean_edge_length(const Mesh& mesh);

/// Writes the boundary facets as TetGen's .smesh, quadrilaterals as two triangles. Throws Error(kFiles).
void write_surface(const Mesh& mesh, const std::string& path);

}  // namespace mortise::bench
