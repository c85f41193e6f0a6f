// Crumbs: loose pieces that the certificate leaves where surfaces cross within a hair's breadth of a face of
// cells; and scraps: larger ones that hang on the rest by an edge or a node. No solver can use them: nothing
// holds them.
#pragma once

#include <cstdint>
#include <optional>

#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Largest volume of a crumb, in smallest leaves around it. The probe is certain to find balls of 1/18 of a
/// cell, 9e-5 cells, so no feature that it knows is a crumb.
inline constexpr double kCrumbVolume = 5e-5;

/// Largest volume of a scrap, which hangs on the rest by an edge or a node: what the certificate leaves along
/// creases and necks that it does not know, of one or two tetrahedra with up to a tenth of a cell.
inline constexpr double kScrapVolume = 0.15;

struct Crumbs {
    std::uint64_t count = 0;
    double largest = 0;          ///< volume, in smallest leaves around it
    std::optional<Point> first;  ///< a node of the first one, in finest cells
};

/// Takes pieces of tetrahedra out of the zone that share faces with nothing else: crumbs, and scraps that
/// hang on something. `most`: kScrapVolume, or kCrumbVolume for crumbs only. Pieces with held facets
/// or tips stay.
Crumbs remove_crumbs(Zone& zone, double most, int threads);

}  // namespace mortise::improve
