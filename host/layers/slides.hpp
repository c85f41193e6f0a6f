// How nodes on facets that get no layers move: along the surfaces of these.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/common/index_set.hpp"
#include "host/common/small_groups.hpp"
#include "host/layers/walls.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::layers {

/// Directions in which a node does not move freely, of length 1 and at right angles: none, or up to three.
struct Across {
    std::array<Vec3, 3> normal{};
    std::size_t count = 0;

    /// The part of a move that is free.
    Vec3 free_part(Vec3 move) const;
    /// Takes one more direction in, if what it adds to the others is as long as `least`; its length is 1.
    bool add(const Vec3& direction, double least);
};

/// All nodes of open and inner facets. Other nodes are free.
class Slides {
  public:
    /// `facet_surface`: by facet, its surface in the model.
    Slides(const Mesh& mesh, const Walls& walls, const std::vector<std::uint32_t>& facet_surface,
           const tape::BoundModel& model, int threads);

    bool holds(NodeId node) const { return nodes_.holds(node); }

    /// Across the node's surfaces; three if it cannot move.
    Across across(NodeId node) const;

    /// The part of a move of this node that stays on its surfaces, to first order.
    Vec3 along(NodeId node, const Vec3& move) const;

    /// Where the node comes by such a move: on its surfaces. False if it finds no way there.
    bool place(NodeId node, const Vec3& move, Vec3& at) const;

  private:
    Across across_at(std::size_t place, const Vec3& at) const;

    const Mesh& mesh_;
    const tape::BoundModel& model_;
    IndexSet nodes_;
    SmallGroups surfaces_;  ///< by place among the nodes, ascending
    std::vector<Across> across_;
};

/// Of a node, model units.
inline Vec3 point_of(const Mesh& mesh, NodeId node) {
    const double* const p = mesh.points.data() + 3 * std::size_t{node};
    return {p[0], p[1], p[2]};
}

}  // namespace mortise::layers
