// The planes of a polyhedron: its triangles grouped where they make one flat face.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::tape {

/// The flat faces of a surface of triangles.
struct Facets {
    static constexpr std::uint32_t kNone = 0xffffffffU;
    std::vector<std::array<double, 4>> planes;  ///< unit outward normal n and d: n·x + d = 0
    std::vector<std::uint32_t> of_triangle;     ///< index into `planes`; kNone: a triangle without area
    /// Per triangle those across its edges (corner k to k + 1), where exactly two meet; kNone elsewhere.
    std::vector<std::array<std::uint32_t, 3>> across;
    std::vector<std::uint32_t> patch_of_plane;  ///< planes that meet smoothly have one number, 0, 1, …
    std::size_t patches = 0;
};

/// Groups triangles that share an edge and whose corners lie within 1e-6 of the surface's size of the plane
/// of the group's largest triangle. Points at the same place count as one. What is one curved surface is told
/// by `sharp_angle` (smooth_faces.hpp). Deterministic.
Facets find_facets(const TriangleSurface& surface, double sharp_angle);

}  // namespace mortise::tape
