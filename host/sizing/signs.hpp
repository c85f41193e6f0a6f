// Which signs a few sheets can have at once in a node.
#pragma once

#include <cstdint>
#include <vector>

#include "host/sizing/sheets.hpp"

namespace mortise::sizing {

/// Finds choices of signs; keeps its scratch memory.
class PossibleSigns {
  public:
    /// All choices that occur at some point of the node, ascending: a bit for each sheet with f < 0. Exact
    /// for planes in general position. Curved sheets count as planes with the thickness that the samples
    /// show; sheets that are not steady may have any sign. False: too many sheets, or too many at one point.
    bool find(const std::vector<Sheet>& sheets, const tape::Cell& cell);
    std::vector<std::uint32_t>& choices() { return choices_; }

  private:
    /// A sheet as normal·x + offset, with the node mapped to [-1, 1]^3.
    struct Plane {
        Vec3 normal;
        double offset;
        double tolerance;
        std::uint32_t bit;
        double at(const Vec3& x) const { return dot(normal, x) + offset; }
    };

    static Plane flatten(const Sheet& sheet, const tape::Cell& cell);
    void add(const Vec3& x);
    void add_edges_and_corners();
    void add_pair(const Plane& p, const Plane& q);
    void add_triple(const Plane& p, const Plane& q, const Plane& r);
    void forbid_pairs(const std::vector<Sheet>& sheets, const tape::Cell& cell);

    bool failed_ = false;
    std::uint32_t any_ = 0;  ///< sheets that are not steady
    std::vector<Plane> planes_;
    std::vector<bool> seen_;  ///< per choice
    std::vector<std::uint32_t> choices_;
};

}  // namespace mortise::sizing
