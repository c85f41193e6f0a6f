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
};

/// Groups triangles that share an edge and whose corners lie within 1e-6 of the surface's size of the plane
/// of the group's largest triangle. Points at the same place count as one. Deterministic.
Facets find_facets(const TriangleSurface& surface);

}  // namespace mortise::tape
