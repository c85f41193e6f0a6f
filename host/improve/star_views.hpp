// The tetrahedra around a node, for many places of it.
//
// Whether a node may move or become another is asked of some twenty elements at once, for places most of
// which one of them refuses. So the star is kept as lanes: eight elements are evaluated at a time, those
// first that refused the last place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/improve/quality.hpp"

namespace mortise::improve {

/// Eight elements, as OppositeFace by lanes, in memory: there, registers' types would depend on the machine.
struct StarGroup {
    static constexpr std::size_t kLanes = 8;
    using Row = std::array<double, kLanes>;

    std::array<Row, 3> b, c, d, normal;
    Row squared_normal, l_bc, l_bd, l_cd;
    Row square;  ///< of the quality, as last evaluated; -1 of an inverted element
    std::array<std::array<std::uint32_t, 3>, kLanes> nodes;
};

class StarViews {
  public:
    void clear();

    /// An element, by the nodes opposite and their places: (node, b, c, d) is positive if the element is.
    void add(const std::array<std::uint32_t, 3>& nodes, const Point& b, const Point& c, const Point& d);

    /// After the last add().
    void finish();

    std::size_t size() const { return size_; }

    /// Worst quality of the elements if the node were at p, or one that is not above `enough`, but kNoElement
    /// if there are none. Those with node `except` are not asked.
    double worst_at(const Point& p, double enough, double rounding, std::uint32_t except = kNobody);

    /// After a worst_at() that was above `enough`: quality of the element added as the i-th.
    double quality(std::size_t i) const;

    /// Evaluations in units of single elements' cost.
    std::uint64_t cost() const { return cost_; }

    static constexpr std::uint32_t kNobody = 0xffffffffu;
    static constexpr double kNoElement = 2;

  private:
    std::vector<StarGroup> groups_;  ///< more than are in use
    std::vector<std::uint32_t> order_;
    std::size_t size_ = 0;
    std::uint64_t cost_ = 0;
};

}  // namespace mortise::improve
