// Extrusions of plane shapes as CSG trees: the shape's tree with every circle and every edge swept.
#pragma once

#include <optional>
#include <string>

#include "host/model/outlines/flat_tree.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// At height z the shape is rotated by -twist·z/height degrees, then scaled by 1 + (scale - 1)·z/height.
struct LinearSweep {
    double height = 1;
    double twist = 0;
    Vec2 scale = {1, 1};  ///< not negative; 0: an apex or a ridge at the top
    double base = 0;      ///< z of the bottom
    bool smooth = true;   ///< edges that turn by little stand for a curve (swept_outline.hpp)
};

/// The shape's x becomes the distance from the z axis, its y becomes z.
struct RotarySweep {
    double start = 0;  ///< degrees from the +x axis
    double angle = 360;
    int facets = 0;  ///< flat steps of the sweep; 0: round
};

/// Both append nodes to the model and return the top one, with bounds and the name `name`; none if the
/// solid is empty. Surfaces are called top, bottom, start, end and side1, side2, ...: one name for each
/// circle, each smooth curve and each other edge of a loop with at most 24 of these, one for a loop of more.
std::optional<std::uint32_t> linear_extrusion(Model& model, const FlatTree& tree, std::uint32_t root,
                                              const LinearSweep& sweep, const std::string& name,
                                              SourceLocation where);

/// Precondition: no part of the shape lies at x < 0, but for rounding.
std::optional<std::uint32_t> rotary_extrusion(Model& model, const FlatTree& tree, std::uint32_t root,
                                              const RotarySweep& sweep, const std::string& name,
                                              SourceLocation where);

}  // namespace mortise::model_reader
