// Convex solids with rounded edges. Where a round part is tangent to what is beside it, exact surfaces would
// meet without an edge, and slivers between them cannot be avoided; so these solids are facetted, kFacets to
// a circle, and what is tangent-continuous is one smooth surface. Flat faces and tangents are exact.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/model/outlines/contours.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

struct Disc {
    Vec2 center{};
    double radius = 0;  ///< 0: a point
};

/// The discs on the boundary of the hull of discs, counter-clockwise; one may occur more than once.
std::vector<Disc> hull_of_discs(const std::vector<Disc>& discs);

/// The solid over the hull of discs in the plane z = 0 of `frame`, from z = low to z = high there. Nothing if
/// the hull has no area. Surfaces are called `name`_side1, ..., _zmin, _zmax; that of one disc, a true
/// cylinder, `name`_round.
std::optional<std::uint32_t> add_prism(Model& model, const std::vector<Disc>& discs, double low, double high,
                                       const Affine& frame, const std::string& name);

/// The hull of spheres of one radius; that of one is a true sphere.
std::optional<std::uint32_t> add_hull_of_equal_spheres(Model& model, const std::vector<Vec3>& centers,
                                                       double radius, const std::string& name);

/// The hull of two spheres, none inside the other.
std::optional<std::uint32_t> add_hull_of_two_spheres(Model& model, const Vec3& a, double ra, const Vec3& b,
                                                     double rb, const std::string& name);

}  // namespace mortise::model_reader
