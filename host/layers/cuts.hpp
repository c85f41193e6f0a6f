// Elements at a wall's quadrilaterals that are cut into two triangles: they are cut as well.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/layers/walls.hpp"
#include "mortise/mesh.hpp"

namespace mortise::layers {

/// A face of four nodes and the two between which it is cut.
struct CutFace {
    std::array<NodeId, 4> key{};  ///< the nodes, ascending
    std::array<NodeId, 2> diagonal{};
    std::uint32_t wall = 0;  ///< in Walls::facets

    bool operator<(const CutFace& other) const { return key < other.key; }
};

/// All quadrilaterals that bare nodes cut, sorted. `is_bare`: by place of the wall node.
std::vector<CutFace> find_cut_faces(const Walls& walls, const std::vector<std::uint8_t>& is_bare);

/// Of these the wall facets of which a triangle would have three nodes of another facet, too: neighbours that
/// share two edges, as they may where a solid is thinner than its cells.
std::vector<std::uint32_t> find_folded_cuts(const Mesh& mesh, const Walls& walls,
                                            const std::vector<CutFace>& faces);

/// An element with such faces.
struct CutElement {
    ElementType type = ElementType::kHexahedron;
    std::uint32_t index = 0;
};

/// In their order in the mesh.
std::vector<CutElement> find_cut_elements(const Mesh& mesh, const std::vector<CutFace>& faces, int threads);

/// A part of one: local nodes; kCentre: a node in the middle of all.
inline constexpr int kCentre = -1;
struct CutPart {
    ElementType type = ElementType::kTetrahedron;
    std::array<int, 5> node{};
};

/// Pyramids are cut in two; others into pyramids and tetrahedra around their centre.
std::vector<CutPart> cut_element(ElementType type, const NodeId* nodes, const std::vector<CutFace>& faces);

}  // namespace mortise::layers
