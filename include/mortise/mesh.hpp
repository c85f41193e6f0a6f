// The finished mesh: plain arrays, shared by the mesher, the checks and the file formats.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace mortise {

using NodeId = std::uint32_t;

/// Element types in the order in which Mesh::elements holds them and files list them. Append-only.
enum class ElementType : std::uint8_t { kHexahedron = 0, kWedge = 1, kPyramid = 2, kTetrahedron = 3 };

inline constexpr int kElementTypes = 4;
inline constexpr std::array<int, kElementTypes> kElementNodes = {8, 6, 5, 4};
inline constexpr std::array<int, kElementTypes> kElementEdges = {12, 9, 8, 6};

/// By element type and local node of VTK's cell: the local node here; each row is its own inverse. VTK_WEDGE
/// is wound the other way: triangle 0-1-2 has its normal pointing away from 3-5. So documented, and so
/// measured by cell volumes and outward faces in VTK 9.2 to 9.6 (ParaView up to then). VTK 9.7 turned the
/// convention round without a mark in the file, and finds negative volumes in wedges wound for its
/// predecessors.
inline constexpr std::array<std::array<int, 8>, kElementTypes> kVtkNodes = {{
    {0, 1, 2, 3, 4, 5, 6, 7},
    {0, 2, 1, 3, 5, 4, 6, 7},
    {0, 1, 2, 3, 4, 5, 6, 7},
    {0, 1, 2, 3, 4, 5, 6, 7},
}};

inline constexpr std::size_t nodes_per(ElementType type) {
    return static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
}

/// How an element was made: the cell array `kind` of output files. Append-only.
enum class ElementKind : std::uint8_t {
    kIn = 0,          ///< an IN cell
    kSnio = 1,        ///< a template of a cell with one simple surface
    kCnio = 2,        ///< the certificate of a complex cell
    kTransition = 3,  ///< between leaves of different sizes: a template, or a cube with hanging nodes
    kLayer = 4,       ///< in a layer at a wall
};

/// All elements of one type. Order: Morton order of the leaf that made them; those in layers, and what layers
/// cut, come last.
struct ElementBlock {
    std::vector<NodeId> nodes;          ///< length: count × kElementNodes[type]; node order below
    std::vector<std::uint16_t> region;  ///< length: count; 1-based index: region_names[region - 1]
    std::vector<std::uint8_t> kind;     ///< length: count; ElementKind
    /// Second order: nodes in the middles of edges, by local_edges(); length: count × kElementEdges[type].
    /// First order: empty.
    std::vector<NodeId> middles;
    std::size_t size() const { return region.size(); }
};

/// 3 or 4, of a facet's four numbers in FacetBlock::nodes.
inline std::size_t corner_count(const NodeId* facet) { return facet[2] == facet[3] ? 3 : 4; }

/// The nodes of a facet, three or four, as they stand in the mesh.
class FacetNodes {
  public:
    FacetNodes(const NodeId* first, std::size_t count) : first_(first), count_(count) {}
    const NodeId* begin() const { return first_; }
    const NodeId* end() const { return first_ + count_; }
    std::size_t size() const { return count_; }
    NodeId operator[](std::size_t k) const { return first_[k]; }
    /// The one after the k-th, round about.
    NodeId after(std::size_t k) const { return first_[k + 1 == count_ ? 0 : k + 1]; }
    NodeId before(std::size_t k) const { return first_[k == 0 ? count_ - 1 : k - 1]; }

  private:
    const NodeId* first_;
    std::size_t count_;
};

/// Boundary and interface facets: three or four nodes each.
///
/// A facet is listed once. Seen from `outside`, its nodes run counter-clockwise, that is, the normal by
/// the right-hand rule points from region `inside` to region `outside`.
struct FacetBlock {
    std::vector<NodeId> nodes;           ///< length: 4 × count; a triangle repeats its last node
    std::vector<std::uint32_t> surface;  ///< length: count; 0-based index into surface_names
    std::vector<std::uint16_t> inside;   ///< length: count; region on the back of the facet, >= 1
    std::vector<std::uint16_t> outside;  ///< length: count; region in front, 0: none (outer boundary)
    /// Second order: the node in the middle of the edge from node k to the next; length: 4 × count, a
    /// triangle repeats its last one. First order: empty.
    std::vector<NodeId> middles;
    std::size_t size() const { return surface.size(); }
    /// Valid until `nodes` changes.
    FacetNodes facet(std::size_t i) const {
        const NodeId* const first = nodes.data() + 4 * i;
        return {first, corner_count(first)};
    }
};

/// Nodes in the middles of edges and faces of larger hexahedra (MeshOptions::hanging): a field that is
/// continuous has the mean of the node's four masters there. All lie inside a region, none on its boundary,
/// and no master hangs itself.
struct HangingNodes {
    std::vector<NodeId> node;  ///< ascending
    /// Length: 4 × count. Of a face's middle its corners, counter-clockwise seen from outside the larger
    /// hexahedron; of an edge's middle its ends a, b as a, b, a, b.
    std::vector<NodeId> masters;
    std::size_t size() const { return node.size(); }
    bool in_edge(std::size_t i) const { return masters[4 * i] == masters[4 * i + 2]; }
};

/// Two opposite planes with the same facets (MeshOptions::periodic, PeriodicPair): the nodes of one are
/// copies of those of the other. A node in several planes has several originals, which are copies themselves.
struct PeriodicNodes {
    std::array<double, 3> shift{};  ///< along one axis: from each original to its copy
    std::vector<NodeId> node;       ///< ascending; of second order also those in the middles of edges
    std::vector<NodeId> original;   ///< parallel to `node`
    std::size_t size() const { return node.size(); }
};

/// A mesh of hexahedra, wedges, pyramids and tetrahedra: conforming, but for hanging nodes.
///
/// Node order of elements (VTK's for hexahedra, pyramids and tetrahedra), all right-handed:
/// - hexahedron: 0-3 counter-clockwise seen from inside looking from face 4-7, i.e. 0 (0,0,0), 1 (1,0,0),
///   2 (1,1,0), 3 (0,1,0), 4-7 the same with z = 1.
/// - wedge: triangle 0 (0,0,0), 1 (1,0,0), 2 (0,1,0), and 3-5 above them with z = 1 (Gmsh's order, not
///   VTK's: kVtkNodes).
/// - pyramid: base 0 (0,0,0), 1 (1,0,0), 2 (1,1,0), 3 (0,1,0), apex 4 with z > 0.
/// - tetrahedron: 0 (0,0,0), 1 (1,0,0), 2 (0,1,0), 3 (0,0,1).
///
/// Of second order (MeshOptions::second_order), each edge has one node more, in its middle, where the edges
/// of all elements and facets share it; these nodes come after all others. Elements are the serendipity
/// elements of 20, 15, 13 and 10 nodes; the pyramid's functions are Bedrosian's (1992), as in VTK and Gmsh.
///
/// Guarantees of a mesh that the mesher returns: every element's Jacobian is positive everywhere; every
/// facet of an element is shared by exactly one other element with the same nodes or lies on the boundary
/// (with hanging nodes also: or is four facets of others, hanging.hpp); no two nodes, and no two elements,
/// coincide; every node is used.
struct Mesh {
    std::vector<double> points;  ///< length: 3 × nodes; x, y, z in model units
    std::array<ElementBlock, kElementTypes> elements;
    FacetBlock facets;                          ///< outer boundary and interfaces between regions
    std::vector<std::string> region_names;      ///< region r is region_names[r - 1]
    std::vector<std::string> surface_names;     ///< unique; any text: files escape it
    std::vector<std::uint8_t> model_dimension;  ///< length: nodes, or empty; see Features::model_dimension
    HangingNodes hanging;                       ///< empty, but with MeshOptions::hanging
    std::vector<PeriodicNodes> periodic;        ///< by pair of planes, those of MeshOptions::periodic last

    std::size_t node_count() const { return points.size() / 3; }
    std::size_t element_count() const {
        std::size_t count = 0;
        for (const ElementBlock& block : elements) count += block.size();
        return count;
    }
    bool is_second_order() const {
        for (const ElementBlock& block : elements) {
            if (!block.middles.empty()) return true;
        }
        return false;
    }
    ElementBlock& block(ElementType type) { return elements[static_cast<std::size_t>(type)]; }
    const ElementBlock& block(ElementType type) const { return elements[static_cast<std::size_t>(type)]; }
};

/// Local faces of each element type, outward (right-hand rule), -1-padded to four nodes.
using LocalFace = std::array<int, 4>;
inline constexpr std::array<LocalFace, 6> kHexahedronFaces = {
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
inline constexpr std::array<LocalFace, 5> kWedgeFaces = {
    {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}};
inline constexpr std::array<LocalFace, 5> kPyramidFaces = {
    {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}};
inline constexpr std::array<LocalFace, 4> kTetrahedronFaces = {
    {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}}};

inline constexpr std::size_t corner_count(const LocalFace& face) { return face[3] < 0 ? 3 : 4; }

/// Local edges of each element type, in VTK's order of the nodes in their middles (but for its wedge).
using LocalEdge = std::array<int, 2>;
inline constexpr std::array<LocalEdge, 12> kHexahedronEdges = {
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
inline constexpr std::array<LocalEdge, 9> kWedgeEdges = {
    {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
inline constexpr std::array<LocalEdge, 8> kPyramidEdges = {
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};
inline constexpr std::array<LocalEdge, 6> kTetrahedronEdges = {
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Edges of a type as pointer and count, kElementEdges[type].
struct LocalEdges {
    const LocalEdge* edges;
    int count;
};
inline LocalEdges local_edges(ElementType type) {
    switch (type) {
        case ElementType::kHexahedron: return {kHexahedronEdges.data(), 12};
        case ElementType::kWedge: return {kWedgeEdges.data(), 9};
        case ElementType::kPyramid: return {kPyramidEdges.data(), 8};
        default: return {kTetrahedronEdges.data(), 6};
    }
}

/// The local edge between two local nodes of a type; -1: there is none.
inline int local_edge(ElementType type, int a, int b) {
    const LocalEdges local = local_edges(type);
    for (int e = 0; e < local.count; ++e) {
        const LocalEdge& edge = local.edges[e];
        if ((edge[0] == a && edge[1] == b) || (edge[0] == b && edge[1] == a)) return e;
    }
    return -1;
}

/// Faces of a type as pointer and count.
struct LocalFaces {
    const LocalFace* faces;
    int count;
};
inline LocalFaces local_faces(ElementType type) {
    switch (type) {
        case ElementType::kHexahedron: return {kHexahedronFaces.data(), 6};
        case ElementType::kWedge: return {kWedgeFaces.data(), 5};
        case ElementType::kPyramid: return {kPyramidFaces.data(), 5};
        default: return {kTetrahedronFaces.data(), 4};
    }
}

}  // namespace mortise
