// Triangles of one polygon in space: for the faces of OBJ, OFF and polyhedron().
#pragma once

#include <cstdint>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Divides a polygon, which need be neither convex nor quite plane, into triangles of its own corners and
/// appends them, in the polygon's own orientation. Corners in the middle of an edge get no flat triangle
/// where that can be avoided. A polygon without area gives nothing; one that crosses itself gives triangles
/// whose sum over orientation is the polygon's.
void triangulate_polygon(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& corners,
                         std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace mortise::model_reader
