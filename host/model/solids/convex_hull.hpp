// Convex polytopes: hulls of points and intersections of half-spaces, by Qhull.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

struct Polytope {
    struct Face {
        Plane plane;                         ///< unit normal, outwards; all vertices are below or on it
        std::vector<std::uint32_t> corners;  ///< counter-clockwise seen from outside
    };
    std::vector<Vec3> vertices;  ///< those that some face uses, in a fixed order
    std::vector<Face> faces;     ///< ordered by normal
};

/// The hull of points; nothing if they lie in a plane. Faces that agree within 1e-6 of the extent (as far as
/// numbers with six digits can tell) are one.
std::optional<Polytope> convex_hull(const std::vector<Vec3>& points);

enum class Boundedness { kBounded, kUnbounded, kEmpty };

/// The vertices of an intersection of half-spaces. kEmpty: no volume.
Boundedness vertices_of(const std::vector<Plane>& planes, std::vector<Vec3>& vertices);

double volume_of(const Polytope& polytope);

/// The faces divided into triangles.
TriangleSurface triangles_of(const Polytope& polytope);

}  // namespace mortise::model_reader
