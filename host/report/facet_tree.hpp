// Nearest facet to a point, by a tree of boxes: facets may be of very different sizes.
#pragma once

#include <cstdint>
#include <vector>

#include "host/features/surfaces.hpp"

namespace mortise::report {

using features::Vector;

/// Distance from a point to a triangle, degenerate or not.
double triangle_distance(const Vector& p, const Vector& a, const Vector& b, const Vector& c);

class FacetTree {
  public:
    /// Facets in box-local coordinates; a quadrilateral is the four triangles about its mean.
    FacetTree(const Mesh& mesh, const tape::BoundModel& model);

    /// Distance to the nearest facet; infinite if there is none. Any point.
    double distance(const Vector& local) const;

  private:
    struct Triangle {
        Vector a, b, c;
    };
    struct Box {
        Vector low, high;
    };
    void sort_along_curve();
    void add_boxes();
    static Box box_of(const Triangle& triangle);
    static double squared_distance(const Box& box, const Vector& p);

    std::vector<Triangle> triangles_;  ///< in Morton order of their centres
    /// A complete binary tree: node i has the children 2 i + 1 and 2 i + 2, leaf i of the last row the
    /// triangles from kPerLeaf · i on. Boxes of leaves without triangles are empty.
    std::vector<Box> boxes_;
    std::size_t leaves_ = 0;  ///< of the last row: a power of two
};

}  // namespace mortise::report
