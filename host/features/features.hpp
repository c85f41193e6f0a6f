// Classification of mesh nodes against the model, and the creases and corners that follow from it.
//
// The facets tell which surfaces pass through a node; their normals tell how these meet. An edge between
// facets of different surfaces that meet at an angle, or whose facets separate different pairs of regions,
// is a crease edge. A node is a corner where crease edges end or branch, where three of its surfaces meet in
// a point, or at a singular point of its surface (algorithms.md §8).
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
};

/// Classifies the nodes of a named mesh; facet_surface[i] is facet i's surface in `model`, `level` that of
/// the finest leaves. Time: linear in the facets, plus sorting of what lies near creases.
Features find_features(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                       const tape::BoundModel& model, int level = 0);

/// Crease edges, sorted by nodes, each once.
std::vector<CreaseEdge> find_crease_edges(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                          const tape::BoundModel& model);

/// Chains crease edges into curves that end where `is_end` holds or the surfaces change. Deterministic.
std::vector<FeatureCurve> chain(const Mesh& mesh, const std::vector<CreaseEdge>& edges,
                                const std::vector<std::uint8_t>& is_end);

}  // namespace mortise::features
