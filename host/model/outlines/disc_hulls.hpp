// Hulls of discs in the plane, and the shapes that are such hulls: their arcs need not be polygons.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/model/outlines/flat_tree.hpp"

namespace mortise::model_reader {

/// Of hulls with more discs arcs become polygons.
inline constexpr std::size_t kMostDiscs = 100;

/// The discs on the boundary of the hull of discs, counter-clockwise; one may occur more than once.
std::vector<Disc> hull_of_discs(const std::vector<Disc>& discs);

/// Discs and points that have the same hull as a shape; nothing if it has ellipses, intersections or
/// differences.
std::optional<std::vector<Disc>> discs_of(const FlatTree& tree, std::uint32_t root);

/// The same for a shape that is convex; nothing if it is not, or does not seem so.
std::optional<std::vector<Disc>> convex_discs_of(const FlatTree& tree, std::uint32_t root);

/// The discs of the hull, each once, if its outline has no corners and is no circle; nothing otherwise.
std::vector<Disc> round_hull(const std::vector<Disc>& discs);

/// Minkowski sum of two hulls.
std::vector<Disc> sum_of_discs(const std::vector<Disc>& a, const std::vector<Disc>& b);

/// Discs under a map; nothing if they become ellipses.
std::optional<std::vector<Disc>> mapped(const std::vector<Disc>& discs, const FlatMap& map);

}  // namespace mortise::model_reader
