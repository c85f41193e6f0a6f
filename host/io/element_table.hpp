// The one table of elements in file formats: a row per element type, columns per format.
//
// `nodes` lists, for each node of the file's element, the local node of mesh.hpp. VTK_WEDGE's triangle 0-1-2
// has its normal pointing away from 3-5, opposite to ours and Gmsh's: so documented, and so measured by cell
// volumes and outward faces in VTK 9.2 to 9.6 (ParaView up to then). VTK 9.7 turned the convention round
// without a mark in the file, and finds negative volumes in wedges wound for its predecessors. All
// permutations here are their own inverse, so the same column serves reading and writing.
#pragma once

#include <array>
#include <cstdint>

#include "mortise/mesh.hpp"

namespace mortise::io {

struct FormatElement {
    int type;                  ///< number of the element type in the format
    std::array<int, 8> nodes;  ///< local node of mesh.hpp, by the format's local node
};

struct ElementRow {
    FormatElement vtk;
    FormatElement gmsh;
};

/// In the order of ElementType.
inline constexpr std::array<ElementRow, kElementTypes> kElementTable = {{
    {{12, {0, 1, 2, 3, 4, 5, 6, 7}}, {5, {0, 1, 2, 3, 4, 5, 6, 7}}},  // hexahedron
    {{13, {0, 2, 1, 3, 5, 4, 6, 7}}, {6, {0, 1, 2, 3, 4, 5, 6, 7}}},  // wedge
    {{14, {0, 1, 2, 3, 4, 5, 6, 7}}, {7, {0, 1, 2, 3, 4, 5, 6, 7}}},  // pyramid
    {{10, {0, 1, 2, 3, 4, 5, 6, 7}}, {4, {0, 1, 2, 3, 4, 5, 6, 7}}},  // tetrahedron
}};

inline constexpr int kGmshTriangle = 2;
inline constexpr int kGmshQuadrilateral = 3;

constexpr bool is_own_inverse(const std::array<int, 8>& nodes) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[static_cast<std::size_t>(nodes[i])] != static_cast<int>(i)) return false;
    }
    return true;
}
static_assert(is_own_inverse(kElementTable[0].vtk.nodes) && is_own_inverse(kElementTable[0].gmsh.nodes));
static_assert(is_own_inverse(kElementTable[1].vtk.nodes) && is_own_inverse(kElementTable[1].gmsh.nodes));
static_assert(is_own_inverse(kElementTable[2].vtk.nodes) && is_own_inverse(kElementTable[2].gmsh.nodes));
static_assert(is_own_inverse(kElementTable[3].vtk.nodes) && is_own_inverse(kElementTable[3].gmsh.nodes));

inline std::size_t nodes_per_element(std::size_t type) {
    return static_cast<std::size_t>(kElementNodes[type]);
}

}  // namespace mortise::io
