// Centroids of eight elements at a time.
#pragma once

#include <array>
#include <cstddef>

#include "host/improve/places.hpp"

namespace mortise::improve {

inline constexpr std::size_t kCentroidsAtOnce = 8;

/// Of eight elements of one type (no hexahedra), given by their nodes: the first node, and what centroid()
/// says of each.
struct Centroids {
    std::array<Point, kCentroidsAtOnce> node;
    std::array<Point, kCentroidsAtOnce> middle;
};
Centroids centroids(const Mesh& mesh, const CellFrame& frame, ElementType type,
                    const std::array<const NodeId*, kCentroidsAtOnce>& elements);

}  // namespace mortise::improve
