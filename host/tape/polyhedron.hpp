// A polyhedron taken apart: planes where it is flat, patches where it is smooth.
#pragma once

#include <string>
#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

struct PolyhedronParts {
    WorldPolyhedron world;  ///< without triangles that have no area; `surface` indexes `surfaces`
    std::vector<Surface> surfaces;
    std::vector<std::string>
        suffixes;  ///< per surface: its group, or its number if there are few, or nothing
};

/// `shape` is in model units. Patches' data (kernels/shared/patch.h) is appended to the arena of expressions.
PolyhedronParts make_polyhedron(TriangleSurface shape, double sharp_angle, std::vector<ExpressionOp>& arena);

/// The shape mapped; a mirror turns its triangles over.
TriangleSurface transformed(const TriangleSurface& shape, const Affine& map);

/// Box around the triangles' corners.
Box3 bounds_of(const TriangleSurface& shape);

}  // namespace mortise::tape
