#include "host/triangles/polygon.hpp"

#include <algorithm>

namespace mortise::triangles {

glm::dvec3 Polygon::centre() const {
    glm::dvec3 sum(0.0);
    for (int i = 0; i < count; ++i) sum += corner[static_cast<std::size_t>(i)];
    return sum / static_cast<double>(count);
}

namespace {

glm::dvec3 twice_the_area(const Polygon& polygon) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 1; i + 1 < static_cast<std::size_t>(polygon.count); ++i) {
        sum += glm::cross(polygon.corner[i] - polygon.corner[0], polygon.corner[i + 1] - polygon.corner[0]);
    }
    return sum;
}

}  // namespace

double Polygon::area() const { return 0.5 * glm::length(twice_the_area(*this)); }

glm::dvec3 Polygon::unit_normal() const { return glm::normalize(twice_the_area(*this)); }

double Polygon::perimeter() const {
    double sum = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        sum += glm::length(corner[(i + 1) % static_cast<std::size_t>(count)] - corner[i]);
    }
    return sum;
}

std::array<double, 2> range_of(const Polygon& polygon, const CutPlane& plane) {
    std::array<double, 2> range = {0, 0};
    for (std::size_t i = 0; i < static_cast<std::size_t>(polygon.count); ++i) {
        const double f = plane.at(polygon.corner[i]);
        range = {std::min(range[0], f), std::max(range[1], f)};
    }
    return range;
}

Polygon part_of(const Polygon& polygon, const CutPlane& plane, int side, double tolerance) {
    Polygon part;
    part.surface = polygon.surface;
    const auto add = [&part](const glm::dvec3& x) {
        if (part.count < Polygon::kMost) part.corner[static_cast<std::size_t>(part.count++)] = x;
    };
    const auto count = static_cast<std::size_t>(polygon.count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3& a = polygon.corner[i];
        const glm::dvec3& b = polygon.corner[(i + 1) % count];
        const double fa = side * plane.at(a);
        const double fb = side * plane.at(b);
        if (fa >= -tolerance) add(a);
        if ((fa > tolerance && fb < -tolerance) || (fa < -tolerance && fb > tolerance)) {
            add(a + (fa / (fa - fb)) * (b - a));
        }
    }
    return part;
}

Polygon clip_to_cube(const Polygon& polygon, const glm::dvec3& centre, double half) {
    Polygon part = polygon;
    for (int axis = 0; axis < 3 && part.count >= 3; ++axis) {
        for (const int side : {-1, 1}) {
            glm::dvec3 normal(0.0);
            normal[axis] = side;
            part = part_of(part, {normal, -side * centre[axis] - half}, -1, 0);
            if (part.count < 3) break;
        }
    }
    return part;
}

}  // namespace mortise::triangles
