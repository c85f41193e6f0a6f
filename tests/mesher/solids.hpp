// Bounded solids and affine maps as model nodes, for tests: each function appends nodes and returns the root.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::test {

using NodeIndex = std::uint32_t;

NodeIndex add_box(Model& model, const Vec3& min, const Vec3& max);
NodeIndex add_ball(Model& model, const Vec3& centre, double radius);
/// Axis along z, from low to high.
NodeIndex add_cylinder(Model& model, double radius, double low, double high);
/// Axis along z; radius `bottom` at low and `top` at high; one of them may be 0 (a pointed cone).
NodeIndex add_frustum(Model& model, double bottom, double top, double low, double high);
NodeIndex add_torus(Model& model, double major, double minor);

NodeIndex unite(Model& model, std::vector<NodeIndex> parts);
NodeIndex intersect(Model& model, std::vector<NodeIndex> parts);
NodeIndex subtract(Model& model, std::vector<NodeIndex> parts);

Affine translation(const Vec3& by);
Affine scaling(const Vec3& factors);
/// Rotation about an axis through the origin; `axis` need not have unit length.
Affine rotation(const Vec3& axis, double radians);
/// The map x -> first(second(x)).
Affine compose(const Affine& first, const Affine& second);
double determinant(const Affine& map);
Vec3 apply(const Affine& map, const Vec3& point);

/// The same model with every region's solid mapped.
Model transformed(Model model, const Affine& map);

/// Adds a region; returns the model for chaining.
Model& add_region(Model& model, NodeIndex root, const std::string& name);

/// One line per node, numbers in full: enough to build the model again by hand.
std::string describe(const Model& model);

}  // namespace mortise::test
