// Poles of the model (host/tape/pole.hpp) in the leaves that hold them.
#pragma once

#include "host/octree/octree.hpp"

namespace mortise::octree {

/// Finds the poles at which two creases of the solid cross, and sets `poles` and `leaf_poles` of the tree. A
/// pole that lies nearly on an edge of the grid is in no leaf's list: where the edge meets the two surfaces
/// there is a node already. The result does not depend on the threads.
void find_poles(const tape::BoundModel& model, Octree& tree, int threads);

}  // namespace mortise::octree
