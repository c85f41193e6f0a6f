// Crumbs: loose pieces that the certificate leaves where surfaces cross within a hair's breadth of a face of
// cells. No solver can use them: nothing holds them.
#pragma once

#include <cstdint>
#include <optional>

#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Largest volume of a crumb, in smallest leaves around it. The probe is certain to find balls of 1/18 of a
/// cell, 9e-5 cells, so no feature that it knows is a crumb.
inline constexpr double kCrumbVolume = 5e-5;

struct Crumbs {
    std::uint64_t count = 0;
    std::optional<Point> first;  ///< a node of the first one, in finest cells
};

/// Takes tetrahedra out of the zone that hang together by faces with few others, or none, and share faces
/// with nothing else. Pieces with held facets or tips stay.
Crumbs remove_crumbs(Zone& zone, int threads);

}  // namespace mortise::improve
