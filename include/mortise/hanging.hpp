// Faces of hexahedra that meet four smaller ones: what HangingNodes say of faces.
#pragma once

#include <array>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise {

/// A face of a larger hexahedron and the four faces that it meets, all counter-clockwise seen from outside
/// the larger hexahedron. Quarter i holds corner i; its nodes are that corner, the middle of the side after
/// it, the middle of the face, and the middle of the side before it.
struct HangingFace {
    std::array<NodeId, 4> whole{};
    std::array<std::array<NodeId, 4>, 4> quarters{};
};

/// In the order of the nodes in the faces' middles. Throws Error(kMeshing) if lengths of arrays do not fit,
/// or if the middle of a side is missing.
std::vector<HangingFace> hanging_faces(const HangingNodes& nodes);

}  // namespace mortise
