// The few vector operations that the checks need, and access to the nodes of an element.
#pragma once

#include <cmath>
#include <cstddef>

#include "mortise/mesh.hpp"

namespace mortise::quality {

struct Vector {
    double x = 0, y = 0, z = 0;
};

inline Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(double s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }

inline Vector point_of(const Mesh& mesh, NodeId node) {
    const double* p = mesh.points.data() + 3 * static_cast<std::size_t>(node);
    return {p[0], p[1], p[2]};
}

/// Corner points of one element; slots beyond its node count stay zero.
struct Corners {
    Vector p[8];
};

inline Corners corners_of(const Mesh& mesh, ElementType type, std::size_t element) {
    const std::size_t count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    const NodeId* nodes = mesh.block(type).nodes.data() + count * element;
    Corners corners;
    for (std::size_t i = 0; i < count; ++i) corners.p[i] = point_of(mesh, nodes[i]);
    return corners;
}

}  // namespace mortise::quality
