// hull() and minkowski() of solids.
//
// Exact are: polytopes; spheres of any radii; prisms over a hull of discs, such as cylinders of one height;
// and minkowski() of a polytope, a cylinder, a cone or such a prism with a sphere, of a prism or a box with a
// cylinder along it, and of two polytopes. Prisms over discs and points, such as cylinders and boxes of one
// height, are smooth facetted surfaces with exact flat faces (rounded_solids.hpp). All else is the hull of
// many points of its curved solids, with exact planes between these (tangent_hull.hpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/model/solids/extrusion_pieces.hpp"
#include "host/model/solids/solid_bounds.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Appends the hull of nodes and returns its node; the empty union if there is nothing. `name` names its
/// surfaces. Throws Error(kInput), with model.source and the place, for children that are not a union of
/// bounded convex solids (or of nodes whose hull or shape is known), and where the hull is flat. A facetted
/// solid is noted in Model::warnings.
std::uint32_t add_hull(Model& model, const std::vector<std::uint32_t>& children, const std::string& name,
                       SourceLocation where, const KnownExtents* known = nullptr,
                       const SweptShapes* swept = nullptr);

/// The same for the Minkowski sum, which needs convex solids or unions of them.
std::uint32_t add_minkowski(Model& model, const std::vector<std::uint32_t>& children, const std::string& name,
                            SourceLocation where, const SweptShapes* swept = nullptr);

/// A solid bounded by triangles: where it is convex and all its edges are sharp, by its planes.
std::uint32_t add_polyhedron(Model& model, TriangleSurface surface, double sharp_angle,
                             const std::string& name);

}  // namespace mortise::model_reader
