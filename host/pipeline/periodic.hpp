// Opposite faces with the same mesh (PeriodicPair of the model).
//
// Faces of cells are meshed as a function of position and of the surfaces there alone, so two planes of the
// grid that the solid meets alike have the same facets, up to rounding, if their distance is a whole number
// of cells. What is left to do: the root box puts the planes on the grid (root_box.hpp), improvement holds
// their facets, and nodes of the second plane take the places of those of the first, moved.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Two planes across an axis that are to have the same facets.
struct PeriodicAxis {
    std::size_t pair = 0;  ///< index into Model::periodic
    std::size_t axis = 0;
    double first = 0;  ///< places of the planes along the axis
    double second = 0;
};

/// The pairs that a grid can repeat; `why`, if not null, receives a line on each other one.
std::vector<PeriodicAxis> periodic_axes(const tape::CompiledModel& compiled, const Model& model,
                                        std::vector<std::string>* why);

/// Nodes of one level that touch a plane of a pair are split alike: marks, in which[i] for node i, the images
/// of all that are marked. Nodes in any order; the level is that of the boundary or a finer one.
void split_images(const tape::BoundModel& bound, const std::vector<PeriodicAxis>& axes,
                  const std::vector<TreeNode>& nodes, int level, std::vector<std::uint8_t>& which);

/// Per bound surface, not 0 for periodic planes.
std::vector<std::uint8_t> held_surfaces(const tape::BoundModel& bound, const std::vector<PeriodicAxis>& axes);

/// Per node of a pair's second plane the one of the first that it is a copy of, for others 0xffffffff; moves
/// it there exactly. Empty if facets of the two planes differ.
std::vector<NodeId> match_plane(const PeriodicAxis& axis, const tape::BoundModel& bound, double cell,
                                Mesh& mesh);

/// Moves the nodes of second planes to those of the first, exactly, and adds a warning for each pair whose
/// facets differ. `cell`: edge of the largest cells at the boundary, in
/// model units. Surfaces of facets are those of `bound`.
/// Returns per node the node that it is a copy of, or itself.
std::vector<NodeId> match_planes(const std::vector<PeriodicAxis>& axes, const Model& model,
                                 const tape::BoundModel& bound, double cell, Mesh& mesh,
                                 std::vector<std::string>& warnings);

/// Mesh::periodic: the pairs whose facets are all the same. `facet_surface`: by facet, the surface of
/// `bound`.
std::vector<PeriodicNodes> pair_nodes(const std::vector<PeriodicAxis>& axes, const tape::BoundModel& bound,
                                      double cell, const std::vector<std::uint32_t>& facet_surface,
                                      Mesh& mesh);

}  // namespace mortise::pipeline
