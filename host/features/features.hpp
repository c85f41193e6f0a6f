// Classification of mesh nodes against the model, and the creases and corners that follow from it.
//
// The facets tell which surfaces pass through a node; their normals tell how these meet. An edge between
// facets of different surfaces that meet at an angle, or whose facets separate different pairs of regions,
// is a crease edge. A node is a corner where crease edges end or branch, where three of its surfaces meet in
// a point, or at a singular point of its surface. At a pole (host/tape/pole.hpp), where
// two creases cross, the angle vanishes: edges between the two surfaces belong to the creases all the way
// there.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"
#include "mortise/quality.hpp"

namespace mortise::features {

/// Mesh edge on a crease.
struct CreaseEdge {
    NodeId a = 0, b = 0;                      ///< a < b
    std::array<std::uint32_t, 2> surfaces{};  ///< indices into Mesh::surface_names, ascending
    double model_angle = 360;                 ///< as FeatureCurve::model_angle
    std::array<std::uint32_t, 2> bound{};     ///< the surfaces in the model, ascending, if there are two
};

/// Edges between facets of different surfaces, each list sorted by nodes.
struct SurfaceEdges {
    std::vector<CreaseEdge> creases;
    std::vector<CreaseEdge> smooth;  ///< the two surfaces meet at no angle
};

/// Classifies the nodes of a named mesh; facet_surface[i] is facet i's surface in `model`, `level` that of
/// the finest leaves. Time: linear in the facets, plus sorting of what lies near creases.
Features find_features(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                       const tape::BoundModel& model, int level = 0);

SurfaceEdges find_surface_edges(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                const tape::BoundModel& model);

struct Creases {
    std::vector<CreaseEdge> edges;  ///< sorted by nodes, each once
    std::vector<NodeId> poles;      ///< ascending
};

/// Crease edges, with the smooth ones that lead from creases to a pole.
Creases find_creases(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                     const tape::BoundModel& model, int level);

/// Chains crease edges into curves that end at `ends` (ascending) or where the surfaces change.
/// Deterministic.
std::vector<FeatureCurve> chain(const Mesh& mesh, const std::vector<CreaseEdge>& edges,
                                const std::vector<NodeId>& ends);

}  // namespace mortise::features
