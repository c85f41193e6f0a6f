// OpenSCAD's polyhedron(points, faces) as a surface of triangles.
#pragma once

#include <string>
#include <vector>

#include "host/model/text.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Lists of numbers, one behind the other.
struct NumberLists {
    const double* numbers;
    const std::size_t* ends;  ///< of each list in `numbers`
    std::size_t count;
};

/// `faces` holds numbers of points as read, from 0, clockwise seen from outside; faces need be neither plane
/// nor convex. `where` is the place of the node, for errors. A surface that is inside out is turned.
TriangleSurface polyhedron_surface(std::vector<Vec3> points, const NumberLists& faces,
                                   const std::string& source, SourceLocation where,
                                   std::vector<std::string>& warnings);

/// Faces of polyhedron() are written with six digits: below this angle in degrees they count as one.
inline constexpr double kPolyhedronSharpAngle = 1;
/// Of a polyhedron with more faces, edges that turn by no more than kSmoothTurn (swept_outline.hpp) stand for
/// a curve.
inline constexpr std::size_t kMostSharpFaces = 24;

}  // namespace mortise::model_reader
