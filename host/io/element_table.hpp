// The one table of elements in file formats: a row per element type, columns per format.
//
// `nodes` lists, for each node of the file's element, the local node of mesh.hpp (VTK's wedge: kVtkNodes
// there). All permutations of corners are their own inverse, so the same column serves reading and writing.
#pragma once

#include <array>
#include <cstdint>

#include "mortise/mesh.hpp"

namespace mortise::io {

struct FormatElement {
    int type;                     ///< number of the element type in the format
    std::array<int, 8> nodes;     ///< local node of mesh.hpp, by the format's local node
    int second_type;              ///< number of the type of second order
    std::array<int, 12> middles;  ///< local edge of mesh.hpp, by the format's local node after the corners
    /// The number of the type of that order.
    constexpr int type_of(bool second_order) const { return second_order ? second_type : type; }
};

struct ElementRow {
    FormatElement vtk;
    FormatElement gmsh;
};

/// In the order of ElementType.
inline constexpr std::array<ElementRow, kElementTypes> kElementTable = {{
    // hexahedron
    {{12, kVtkNodes[0], 25, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
     {5, {0, 1, 2, 3, 4, 5, 6, 7}, 17, {0, 3, 8, 1, 9, 2, 10, 11, 4, 7, 5, 6}}},
    // wedge
    {{13, kVtkNodes[1], 26, {2, 1, 0, 5, 4, 3, 6, 8, 7, 9, 10, 11}},
     {6, {0, 1, 2, 3, 4, 5, 6, 7}, 18, {0, 2, 6, 1, 7, 8, 3, 5, 4, 9, 10, 11}}},
    // pyramid
    {{14, kVtkNodes[2], 27, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
     {7, {0, 1, 2, 3, 4, 5, 6, 7}, 19, {0, 3, 4, 1, 5, 2, 6, 7, 8, 9, 10, 11}}},
    // tetrahedron
    {{10, kVtkNodes[3], 24, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
     {4, {0, 1, 2, 3, 4, 5, 6, 7}, 11, {0, 1, 2, 3, 5, 4, 6, 7, 8, 9, 10, 11}}},
}};

/// Gmsh's types of facets.
inline constexpr int kGmshTriangle = 2, kGmshSecondTriangle = 9;
inline constexpr int kGmshQuadrilateral = 3, kGmshSecondQuadrilateral = 16;

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
inline std::size_t middles_per_element(std::size_t type) {
    return static_cast<std::size_t>(kElementEdges[type]);
}
/// All nodes of an element, those in the middles of edges included.
inline std::size_t all_nodes_per_element(std::size_t type, bool second_order) {
    return nodes_per_element(type) + (second_order ? middles_per_element(type) : 0);
}

}  // namespace mortise::io
