// Blocks whose results do not go together.
//
// Blocks do not know each other. Where skins or slivers lie close together, two of them may move nodes onto
// one place, make one face anew, or push a skin through one of the other's, each on its own without fault.
#pragma once

#include <cstdint>
#include <vector>

#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Nodes closer than this coincide: finest leaves.
inline constexpr double kSameNode = 1e-9;

/// What a pass over the blocks has made.
struct PassResult {
    const std::vector<Point>& before;         ///< positions before the pass
    const std::vector<Point>& after;          ///< and now
    const std::vector<std::uint32_t>& owner;  ///< per node its block, `shared`, or kNone if nothing has it
    std::uint32_t shared;
    const std::vector<Tetrahedron>& tetrahedra;  ///< block by block
    const std::vector<std::size_t>& first;       ///< per block, and behind the last: its first tetrahedron
    const std::vector<std::uint8_t>& changed;    ///< per block, not 0 if it may not be as it was
    double unit;                                 ///< Zone::unit
};

/// Changed blocks to take back, ascending: those with a node that has come to lie on another block's, with a
/// face between shared nodes that has more than two tetrahedra, or two on one side, or with a facet that
/// crosses one of another block. Where two such blocks have done so together one is taken back, the second.
/// There may be others afterwards. The result does not depend on `threads`.
std::vector<std::uint32_t> find_clashes(const PassResult& pass, int threads);

}  // namespace mortise::improve
