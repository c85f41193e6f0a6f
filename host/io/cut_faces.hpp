// What a picture shows of a mesh that is cut open.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mortise/io.hpp"
#include "mortise/mesh.hpp"

namespace mortise::io {

/// A face of an element; a triangle repeats its last node.
struct DrawnFace {
    std::array<NodeId, 4> node{};
    bool is_facet = false;      ///< of the outer boundary
    std::uint32_t surface = 0;  ///< then: its surface
    std::uint16_t region = 0;   ///< of the element
    std::uint8_t kind = 0;      ///< likewise
};

/// Facets of the outer boundary.
std::vector<DrawnFace> outer_faces(const Mesh& mesh);

/// Of the elements whose centres lie behind the cut: their faces on the outer boundary, and towards elements
/// before it. Elements stay whole. Time: linear, plus sorting of what is near the cut or the boundary.
std::vector<DrawnFace> faces_behind(const Mesh& mesh, const PictureCut& cut);

}  // namespace mortise::io
