// Centroids of eight elements at a time.
#pragma once

#include <array>
#include <cstddef>

#include "host/improve/places.hpp"

namespace mortise::improve {

inline constexpr std::size_t kCentroidsAtOnce = 8;

/// What centroid() says of eight elements of one type, given by their nodes.
std::array<Point, kCentroidsAtOnce> centroids(const Mesh& mesh, const CellFrame& frame, ElementType type,
                                              const std::array<const NodeId*, kCentroidsAtOnce>& elements);

}  // namespace mortise::improve
