// Convex pieces of triangles, cut by planes.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace mortise::triangles {

/// A convex planar polygon; it is part of a triangle on `surface`.
struct Polygon {
    static constexpr int kMost = 20;
    std::array<glm::dvec3, kMost> corner;
    int count = 0;
    std::uint32_t surface = 0;  ///< index into BoundModel::surfaces

    glm::dvec3 centre() const;
    double area() const;
    double perimeter() const;
    /// On the side from which the corners run counter-clockwise.
    glm::dvec3 unit_normal() const;
};

/// The plane { x : normal·x + offset = 0 }.
struct CutPlane {
    glm::dvec3 normal;
    double offset;
    double at(const glm::dvec3& x) const { return glm::dot(normal, x) + offset; }
};

/// Least and largest value of the plane's function on the polygon, and zero.
std::array<double, 2> range_of(const Polygon& polygon, const CutPlane& plane);

/// The part of the polygon where the plane's function is <= 0 (side -1) or >= 0 (side +1); corners within
/// `tolerance` belong to both. Less than three corners: nothing.
Polygon part_of(const Polygon& polygon, const CutPlane& plane, int side, double tolerance);

/// The part in a closed cube.
Polygon clip_to_cube(const Polygon& polygon, const glm::dvec3& centre, double half);

}  // namespace mortise::triangles
