// hull() and minkowski() of solids.
//
// Polytopes are exact, and so is what stays a sphere, a cylinder or a cone. Spheres of one radius, two
// spheres, and prisms over a hull of discs, such as cylinders of one height, also with boxes of that height,
// are smooth facetted surfaces with exact flat faces (rounded_solids.hpp). minkowski() of a polytope with a
// sphere, or of a prism with a cylinder, is such a hull. All else is the hull of its curved solids' points,
// 96 to a circle.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/model/solids/solid_bounds.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Appends the hull of nodes and returns its node; the empty union if there is nothing. `name` names its
/// surfaces. Throws Error(kInput), with model.source and the place, for children that are not a union of
/// bounded convex solids (or of nodes whose hull is known), and where the hull is flat. A facetted solid is
/// noted in Model::warnings.
std::uint32_t add_hull(Model& model, const std::vector<std::uint32_t>& children, const std::string& name,
                       SourceLocation where, const KnownExtents* known = nullptr);

/// The same for the Minkowski sum, which needs convex solids or unions of them.
std::uint32_t add_minkowski(Model& model, const std::vector<std::uint32_t>& children, const std::string& name,
                            SourceLocation where);

/// A solid bounded by triangles: where it is convex and all its edges are sharp, by its planes.
std::uint32_t add_polyhedron(Model& model, TriangleSurface surface, double sharp_angle,
                             const std::string& name);

}  // namespace mortise::model_reader
