// Boxes around the nodes of a tree, each in its own frame: larger than needed, infinite where nothing is
// known.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "mortise/model.hpp"

namespace mortise::model_reader {

using NodeBoxes = std::unordered_map<std::uint32_t, Box3>;

/// Of the node and all nodes below it.
NodeBoxes node_boxes(const Model& model, std::uint32_t root);

/// The box around the image of a box, infinite sides included.
Box3 image_of(const Affine& map, const Box3& box);

Box3 common_box(const Box3& a, const Box3& b);
bool is_empty(const Box3& box);
bool is_finite(const Box3& box);

}  // namespace mortise::model_reader
