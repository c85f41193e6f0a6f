// Combinatorics of one boundary cell: corners, cuts, faces, symmetries and the boundary of its inside part.
//
// Unit cell [0,1]^3. Corner c lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e = 4 * axis + k runs from
// coordinate 0 to 1 of its axis; k counts the other two coordinates, the lower axis first. Face
// f = 2 * axis + side. A pattern is an 8-bit mask: bit c set when corner c is inside. Node codes: 0-7
// corners, 8-19 the cut on edge (code - 8), 20 the interior node.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::templates {

using Pattern = std::uint8_t;
using NodeCode = std::uint8_t;
using NodeSet = std::uint32_t;  ///< bit i: node code i

inline constexpr int kCorners = 8;
inline constexpr int kEdges = 12;
inline constexpr int kFaces = 6;
inline constexpr int kPatterns = 256;
inline constexpr NodeCode kFirstCut = 8;
inline constexpr NodeCode kInteriorNode = 20;
inline constexpr int kNodeCodes = 21;

/// An oriented triangle or quad; two facets are equal when one is a rotation of the other.
struct Facet {
    std::array<NodeCode, 4> nodes{};
    int size = 0;
};

struct Element {
    ElementType type = ElementType::kTetrahedron;
    std::array<NodeCode, 8> nodes{};  ///< the first kElementNodes[type] count
};

/// A symmetry of the cube as a map of node codes.
struct Symmetry {
    std::array<NodeCode, kNodeCodes> image{};
    bool mirror = false;  ///< reverses orientation
};

int bits(std::uint32_t mask);
std::array<int, 2> edge_corners(int edge);  ///< low end, high end
int edge_between(int corner_a, int corner_b);
bool on_face(NodeCode node, int face);
NodeSet face_nodes(int face);

Facet triangle(NodeCode a, NodeCode b, NodeCode c);
Facet quad(NodeCode a, NodeCode b, NodeCode c, NodeCode d);
Facet reversed(const Facet& facet);
std::uint32_t facet_key(const Facet& facet);  ///< the same for all rotations of one oriented facet
NodeSet node_set(const Facet& facet);
std::vector<NodeCode> node_list(NodeSet nodes);             ///< ascending
std::vector<Facet> element_facets(const Element& element);  ///< outward

/// All 48 symmetries in a fixed order; the first is the identity.
const std::vector<Symmetry>& symmetries();
Pattern mapped(Pattern pattern, const Symmetry& symmetry);
Facet mapped(const Facet& facet, const Symmetry& symmetry);
Element mapped(const Element& element, const Symmetry& symmetry);
NodeSet mapped(NodeSet nodes, const Symmetry& symmetry);

/// One surface loop: no face with two opposite inside corners only, inside and outside corners each
/// connected along edges; neither empty nor full.
bool is_simple(Pattern pattern);

/// The part of a face inside the solid as a polygon, counter-clockwise seen from outside the cell.
/// Precondition: the face is not ambiguous.
std::vector<NodeCode> face_polygon(Pattern pattern, int face);

/// The face rule: polygons of 3 and 4 nodes stay; the pentagon is fanned from its middle inside corner.
std::vector<Facet> face_mesh(Pattern pattern, int face);

/// The cuts of a simple pattern in order around the surface, counter-clockwise seen from outside the solid.
std::vector<NodeCode> surface_loop(Pattern pattern);

/// Every way to divide a polygon of 3 to 6 nodes into triangles and quads by diagonals.
std::vector<std::vector<Facet>> dissections(const std::vector<NodeCode>& polygon);

/// Inside corners and cuts.
NodeSet pattern_nodes(Pattern pattern);

}  // namespace mortise::templates
