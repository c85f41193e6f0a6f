// What loosening in blocks must know of the whole zone.
#pragma once

#include <cstdint>
#include <vector>

#include "host/improve/stratum.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Outward normals face away from each other if their cosine is below the negative of this: a chamfer of 45
/// degrees is no blade, and rounded figures make cylinders miss its edges by little.
inline constexpr double kFacingAway = 0.72;

/// What loosening in blocks must know of the whole zone, by node.
struct LooseStart {
    struct Way {
        std::uint32_t node;
        double used;
    };
    /// What a block has used.
    void add(const std::vector<Way>& ways) {
        for (const Way& way : ways) used[way.node] = way.used;
    }

    double reach = 0;         ///< how far nodes may go, in edges of the smallest leaf
    std::vector<Point> home;  ///< where the nodes are before any is loose
    /// How thick the wall is in which a node lies, in finest cells; negative: none.
    std::vector<double> wall;
    std::vector<double> most;  ///< how far it may go whatever the reach, in finest cells
    std::vector<double> used;  ///< how far what it has been merged with has come already
};

/// `merge_distance` in cells: strips of walls that are thinner count as none.
LooseStart find_loose_start(const Zone& zone, double merge_distance);

/// Nodes that are not on their surfaces any more.
std::uint64_t count_loose(const Zone& zone, const LooseStart& start, const Surfaces& surfaces);

}  // namespace mortise::improve
