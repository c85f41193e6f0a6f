// The elements between a wall's facet and what has moved away from it.
//
// A facet all of whose nodes have moved gets a stack of wedges or hexahedra. At bare nodes, which have not,
// the stack narrows to nothing: triangles give pyramids or tetrahedra, quadrilaterals with a bare edge
// wedges. A quadrilateral with another number of bare nodes is cut into two triangles, from a bare node on,
// and so is the face behind it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/layers/walls.hpp"
#include "mortise/mesh.hpp"

namespace mortise::layers {

/// Of a stack: a corner of the facet, and how many layers lie between it and the wall.
struct StackNode {
    std::uint8_t corner = 0;
    int layer = 0;
};
using StackNodes = std::array<StackNode, 8>;

using BareCorners = std::array<bool, 4>;

/// `is_bare`: by place of the wall node, which `place` tells of a node.
inline BareCorners bare_corners(const WallFacet& facet, const std::vector<std::uint32_t>& place,
                                const std::vector<std::uint8_t>& is_bare) {
    BareCorners bare{};
    for (std::size_t k = 0; k < bare.size(); ++k) bare[k] = is_bare[place[facet.node[k]]] != 0;
    return bare;
}

/// Where a quadrilateral is cut: from this corner to the one opposite.
inline std::optional<std::size_t> cut_of(const WallFacet& facet, const BareCorners& bare) {
    if (facet.corners() == 3) return std::nullopt;
    const int count = bare[0] + bare[1] + bare[2] + bare[3];
    if (count == 0 || count == 4) return std::nullopt;
    if (count == 3) {
        std::size_t moved = 0;
        while (bare[moved]) ++moved;
        return (moved + 1) % 4;
    }
    std::size_t first = 0;
    while (!bare[first]) ++first;
    if (count == 2 && !bare[(first + 2) % 4]) return std::nullopt;
    return first;
}

/// Calls emit(type, nodes) for the elements over some corners of a facet, three or four that need no cut,
/// from the wall inward.
template <class Emit>
void for_polygon(const std::array<std::uint8_t, 4>& corner, std::size_t corners, const BareCorners& bare,
                 int layers, const Emit& emit) {
    std::size_t count = 0, turn = 0;
    for (std::size_t k = 0; k < corners; ++k) count += bare[corner[k]];
    if (count == corners) return;
    // Turned until the bare ones come first, and the last one is not.
    const auto is_bare = [&](std::size_t k) { return bare[corner[k % corners]]; };
    if (count > 0) {
        while (!is_bare(turn) || is_bare(turn + corners - 1)) ++turn;
    }
    const auto at = [&](std::size_t k, int layer) {
        return StackNode{corner[(turn + k) % corners], is_bare(turn + k) ? 0 : layer};
    };
    for (int out = 0; out < layers; ++out) {
        const int in = out + 1;
        if (count == 0 && corners == 4) {
            emit(ElementType::kHexahedron, StackNodes{at(0, in), at(1, in), at(2, in), at(3, in), at(0, out),
                                                      at(1, out), at(2, out), at(3, out)});
        } else if (count == 0) {
            emit(ElementType::kWedge,
                 StackNodes{at(0, in), at(1, in), at(2, in), at(0, out), at(1, out), at(2, out)});
        } else if (corners == 4) {
            emit(ElementType::kWedge,
                 StackNodes{at(0, 0), at(3, in), at(3, out), at(1, 0), at(2, in), at(2, out)});
        } else if (count == 1) {
            emit(ElementType::kPyramid, StackNodes{at(1, in), at(1, out), at(2, out), at(2, in), at(0, 0)});
        } else {
            emit(ElementType::kTetrahedron, StackNodes{at(0, 0), at(1, 0), at(2, in), at(2, out)});
        }
    }
}

/// The same for a whole facet.
template <class Emit>
void for_stack(const WallFacet& facet, const BareCorners& bare, int layers, const Emit& emit) {
    const std::optional<std::size_t> cut = cut_of(facet, bare);
    if (!cut) {
        for_polygon({0, 1, 2, 3}, facet.corners(), bare, layers, emit);
        return;
    }
    const auto corner = [&](std::size_t k) { return static_cast<std::uint8_t>((*cut + k) % 4); };
    for_polygon({corner(0), corner(1), corner(2), 0}, 3, bare, layers, emit);
    for_polygon({corner(0), corner(2), corner(3), 0}, 3, bare, layers, emit);
}

}  // namespace mortise::layers
