// The shadow of any solid of cubes, polyhedra, spheres, cylinders and cones.
#pragma once

#include <cstdint>
#include <optional>

#include "host/model/solids/section.hpp"

namespace mortise::model_reader {

/// The shadow along z of the image of a node; round primitives are taken with those sides (96 where nothing
/// is told), 96 at most and spheres 48. `boxes`: of the node. Throws Error(kInput) for what has no faces
/// (formulas, tori), no end, or too many faces.
std::optional<std::uint32_t> shadow_by_planes(const Model& model, std::uint32_t node, const Affine& map,
                                              const NodeBoxes& boxes, const Fragments& fragments,
                                              FlatTree& flat, const Wanted& wanted);

/// The smallest box around a solid all of whose primitives have flat faces, by its shadows along z and x;
/// none if some are round, or if it is empty.
std::optional<Box3> flat_faced_bounds(const Model& model, std::uint32_t node, const Wanted& wanted);

}  // namespace mortise::model_reader
