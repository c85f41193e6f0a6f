// Faces of elements and facets, told by their nodes in whatever order these come.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "mortise/mesh.hpp"

namespace mortise {

/// The number of no node: no mesh has so many.
inline constexpr NodeId kNoNode = 0xffffffffu;

/// The nodes of a face, ascending; a triangle ends with kNoNode.
using FaceKey = std::array<NodeId, 4>;

/// `count`: three or four.
inline FaceKey face_key(const NodeId* nodes, std::size_t count) {
    FaceKey key;
    std::copy_n(nodes, count, key.begin());
    if (count == 3) key[3] = kNoNode;
    std::sort(key.begin(), key.end());
    return key;
}

/// Of four numbers as FacetBlock::nodes holds them: a triangle repeats the last.
inline FaceKey facet_key(const FaceKey& nodes) { return face_key(nodes.data(), corner_count(nodes.data())); }

}  // namespace mortise
