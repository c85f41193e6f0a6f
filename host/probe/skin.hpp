// The facets of a mesh as triangles in the root box of its model, and rays that meet them.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "host/common/vec3.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::probe {

using Triangle = std::array<Vec3, 3>;

/// The facets of a mesh as triangles in the root box.
class Skin {
  public:
    Skin(const tape::BoundModel& model, const std::vector<double>& points, const FacetBlock& facets)
        : model_(model), points_(points), facets_(facets) {}

    /// Triangle 0 or 1 of a facet; 1: of quadrilaterals only.
    Triangle triangle(std::uint32_t facet, std::size_t part) const {
        const NodeId* node = facets_.nodes.data() + 4 * std::size_t{facet};
        return {corner(node[0]), corner(node[1 + part]), corner(node[2 + part])};
    }
    std::size_t triangles(std::uint32_t facet) const { return facets_.facet(facet).size() - 2; }
    Vec3 middle(std::uint32_t facet) const {
        const Triangle t = triangle(facet, triangles(facet) - 1);
        return scaled(sum(sum(t[0], t[1]), t[2]), 1.0 / 3);
    }
    Vec3 normal(std::uint32_t facet) const {
        const Triangle t = triangle(facet, 0);
        return unit(cross(difference(t[1], t[0]), difference(t[2], t[0])));
    }
    std::uint16_t inside(std::uint32_t facet) const { return facets_.inside[facet]; }
    std::uint16_t outside(std::uint32_t facet) const { return facets_.outside[facet]; }
    std::uint32_t size() const { return static_cast<std::uint32_t>(facets_.size()); }

  private:
    Vec3 corner(NodeId node) const {
        Vec3 x{};
        for (std::size_t j = 0; j < 3; ++j)
            x[j] = (points_[3 * std::size_t{node} + j] - model_.origin[j]) / model_.side;
        return x;
    }

    const tape::BoundModel& model_;
    const std::vector<double>& points_;
    const FacetBlock& facets_;
};

/// Finds the facet that a ray hits first, by a grid of boxes that holds each facet in all that it may pass.
class Rays {
  public:
    /// Of a ray that starts in no facet.
    static constexpr std::uint32_t kNoFacet = 0xffffffffu;

    /// `starts` of rays that are no longer than `reach`; facets longer than that are seen near their middle.
    Rays(const Skin& skin, const std::vector<Vec3>& starts, double reach);

    /// Distance to the first facet behind x but `own`, or `reach` if there is none before.
    double first_hit(const Vec3& x, const Vec3& direction, double reach, std::uint32_t own) const;

  private:
    using Key = std::array<std::int32_t, 3>;

    static Key key_of(const Vec3& x, double box);
    static double hit(const Triangle& t, const Vec3& x, const Vec3& direction, double most);
    void list(std::uint32_t facet);

    const Skin& skin_;
    const double box_;
    std::vector<std::pair<Key, std::uint32_t>> listed_;  ///< facets by the boxes that their bounds touch
};

}  // namespace mortise::probe
