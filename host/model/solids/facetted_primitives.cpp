// See facetted_primitives.hpp.
#include "host/model/solids/facetted_primitives.hpp"

#include <algorithm>
#include <cmath>

#include "host/model/outlines/flat_tree.hpp"

namespace mortise::model_reader {
namespace {

/// Scales a plane so that its largest component is 1: equal planes of different sizes get equal normals.
Plane normalized(Plane plane) {
    double largest = 0;
    for (const double component : plane.normal) largest = std::max(largest, std::fabs(component));
    for (double& component : plane.normal) component /= largest;
    plane.offset /= largest;
    return plane;
}

}  // namespace

void add_frustum_sides(std::vector<Plane>& planes, int n, double radius, double slope) {
    for (int j = 0; j < n; ++j) {
        const double from = 360.0 * j / n;
        const double to = 360.0 * (j + 1) / n;
        const double x = cosine_of_degrees(from);
        const double y = sine_of_degrees(from);
        const Vec3 outward = {sine_of_degrees(to) - y, x - cosine_of_degrees(to), 0};
        const double apothem = outward[0] * x + outward[1] * y;
        planes.push_back(normalized({{outward[0], outward[1], -slope * apothem}, radius * apothem, ""}));
    }
}

Primitive facetted_sphere(double radius, int n) {
    Primitive result;
    const int rings = (n + 1) / 2;
    const auto ring_z = [&](int i) { return radius * cosine_of_degrees(180 * (i + 0.5) / rings); };
    const auto ring_radius = [&](int i) { return radius * sine_of_degrees(180 * (i + 0.5) / rings); };
    for (int i = 0; i + 1 < rings; ++i) {
        const double slope = (ring_radius(i) - ring_radius(i + 1)) / (ring_z(i) - ring_z(i + 1));
        add_frustum_sides(result.planes, n, ring_radius(i) - slope * ring_z(i), slope);
    }
    result.planes.push_back({{0, 0, -1}, ring_z(0), "zmin"});
    result.planes.push_back({{0, 0, 1}, ring_z(0), "zmax"});
    return result;
}

}  // namespace mortise::model_reader
