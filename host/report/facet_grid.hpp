// Nearest facet to a point, by a uniform grid over the root box.
#pragma once

#include <cstdint>
#include <vector>

#include "host/features/surfaces.hpp"

namespace mortise::report {

using features::Vector;

/// Distance from a point to a triangle, degenerate or not.
double triangle_distance(const Vector& p, const Vector& a, const Vector& b, const Vector& c);

class FacetGrid {
  public:
    /// Facets in box-local coordinates; a quadrilateral is the four triangles about its mean.
    FacetGrid(const Mesh& mesh, const tape::BoundModel& model, int level);

    /// Distance to the nearest facet; infinite if there is none. Any point.
    double distance(const Vector& local) const;

  private:
    struct Triangle {
        Vector a, b, c;
    };
    struct Range {
        int low[3], high[3];
    };
    Range range_of(const Triangle& triangle) const;
    int cell_of(double x) const;
    template <class Visit>
    void for_cells(const Range& range, const Visit& visit) const;

    int cells_ = 1;  ///< along each axis
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> first_;    ///< cells³ + 1
    std::vector<std::uint32_t> listing_;  ///< triangles by cell
};

}  // namespace mortise::report
