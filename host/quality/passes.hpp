// The passes of check_mesh, in the order in which it runs them. `threads`: of the host, 0: all cores.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/quality/defects.hpp"
#include "mortise/check.hpp"
#include "mortise/hanging.hpp"

namespace mortise::quality {

/// Array lengths, index ranges, names. False: indices cannot be trusted, so no other pass may run.
bool check_structure(const Mesh& mesh, int threads, DefectLog& log);

/// Coordinates finite, every node used, no two nodes within 1e-12 of the bounding box's diagonal.
void check_nodes(const Mesh& mesh, int threads, DefectLog& log);

/// Repeated nodes and Jacobians, of curved elements at samples; fills volumes, and scaled Jacobians and
/// dihedral angles between corners, of the report.
void check_elements(const Mesh& mesh, int threads, DefectLog& log, CheckReport& report);

/// Hanging nodes: each once, its masters different nodes that do not hang, itself in their middle. Returns
/// the faces that have one; none if there are defects.
std::vector<HangingFace> check_hanging(const Mesh& mesh, DefectLog& log);

/// The ends of an edge as one number, whatever their order.
inline std::uint64_t edge_ends(NodeId a, NodeId b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

/// The node in the middle of an edge.
struct EdgeMiddle {
    std::uint64_t ends;  ///< edge_ends
    NodeId node;
    bool operator<(const EdgeMiddle& other) const {
        return ends != other.ends ? ends < other.ends : node < other.node;
    }
};

/// Of second order: each edge has one node in its middle, the same for all elements and listed facets; it is
/// of no other edge, and no corner. Returns all edges, sorted; none of first order.
std::vector<EdgeMiddle> check_middles(const Mesh& mesh, int threads, DefectLog& log);

/// A facet that belongs to one element only, in that element's outward order.
struct BoundaryFacet {
    NodeId nodes[4];  ///< a triangle repeats its last node
    int count() const { return nodes[2] == nodes[3] ? 3 : 4; }
};

/// Matches the facets of all elements with each other, with `hanging` faces and with the mesh's facet list;
/// also finds duplicate elements. Fills facet counts and components of the report. Returns the boundary, in
/// order of smallest node.
std::vector<BoundaryFacet> check_facets(const Mesh& mesh, const std::vector<HangingFace>& hanging,
                                        int threads, DefectLog& log, CheckReport& report);

/// Closedness, quadrilaterals against triangles; fills area, Euler characteristic and non-manifold edges.
/// `middles`: what check_middles returned.
void check_boundary(const Mesh& mesh, const std::vector<BoundaryFacet>& boundary,
                    const std::vector<EdgeMiddle>& middles, DefectLog& log, CheckReport& report);

/// Fills parts and non-manifold nodes of the report.
void check_hinges(const Mesh& mesh, const std::vector<BoundaryFacet>& boundary, CheckReport& report);

}  // namespace mortise::quality
