// Plane shapes of solids: where they cut the plane z = 0, and their shadow on it along z.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>

#include "host/model/outlines/flat_tree.hpp"
#include "host/model/solids/convex_pieces.hpp"
#include "host/model/solids/node_boxes.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Lengths that agree so far, in units of the solid's size, are equal: .csg files have six digits.
inline constexpr double kSameHeight = 1e-6;

/// The section of a node's image under `map` with z = 0, as a node of `flat`; nothing if it has no area. The
/// solid is closed: where a face lies in the plane, the solid on either side of it counts. `boxes`: of the
/// node. Throws Error(kInput) for what has no section of circles, ellipses and polygons.
std::optional<std::uint32_t> section(const Model& model, std::uint32_t node, const Affine& map,
                                     const NodeBoxes& boxes, FlatTree& flat, const Wanted& wanted);

/// Sides of the polygon that stands for the circle of a round primitive, by node.
using Fragments = std::unordered_map<std::uint32_t, int>;

/// The shadow along z of a node; nothing if it has no area. `fragments` counts where round primitives have to
/// be facetted.
std::optional<std::uint32_t> shadow(const Model& model, std::uint32_t node, const Fragments& fragments,
                                    FlatTree& flat, const Wanted& wanted);

}  // namespace mortise::model_reader
