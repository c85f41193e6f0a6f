// Hand-made graded meshes: the leaves of a balanced octree that fill a box, hexahedra where they fit and
// cones from the centre where a neighbour is finer. No mesher involved.
#pragma once

#include <functional>
#include <vector>

#include "host/common/leaf_grid.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::test {

struct GradedMesh {
    Mesh mesh;  ///< facets carry bound surfaces
    tape::BoundModel model;
    LeafGrid leaves;
};

/// A tree of `level`, split where `wanted(low, edge)` says so and for 2:1 balance; the leaves in the box
/// [4, 2^level - 4]³ of finest cells, with that box as model. One finest cell is one model unit.
GradedMesh graded_mesh(int level, const std::function<bool(const Vec3& low, double edge)>& wanted);

}  // namespace mortise::test
