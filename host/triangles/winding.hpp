// Winding numbers of a surface of triangles: how often it goes around a point.
//
// One inside a closed surface and zero outside, in between where it has holes; overlapping shells add up. So
// a point inside has a winding number above one half, even where the surface is not perfect. Far triangles
// count as one dipole each group (Barill et al. 2018, Fast winding numbers for soups and clouds).
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::triangles {

class WindingNumber {
  public:
    explicit WindingNumber(const TriangleSurface& surface);

    /// To about 0.02. Pure: any thread may ask.
    double at(const glm::dvec3& point) const;
    bool is_inside(const glm::dvec3& point) const { return at(point) > 0.5; }

    /// Whether every edge is run through as often one way as the other.
    bool is_closed() const { return is_closed_; }

  private:
    struct Node {
        glm::dvec3 centre{0.0};   ///< of the triangles' areas
        glm::dvec3 area{0.0};     ///< sum of area vectors
        double radius = 0;        ///< of a ball around `centre` that holds the triangles
        std::uint32_t first = 0;  ///< triangles [first, first + count)
        std::uint32_t count = 0;
        std::uint32_t right = 0;  ///< second child; the first one follows; 0: a leaf
    };
    using Triangle = std::array<glm::dvec3, 3>;

    std::vector<Triangle> triangles_;
    std::vector<Node> nodes_;
    bool is_closed_ = false;
};

}  // namespace mortise::triangles
