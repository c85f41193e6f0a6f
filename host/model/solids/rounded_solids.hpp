// Convex solids with rounded edges: exact where all of their outline is round, one smooth surface. Where
// round sides end at corners, they are facetted, kFacets to a circle, with exact flat faces and tangents.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/model/outlines/disc_hulls.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// The solid over the hull of discs in the plane z = 0 of `frame`, from z = low to z = high there. Nothing if
/// the hull has no area. Surfaces are called `name`_side1, ..., _zmin, _zmax; the side of discs alone, which
/// is exact, `name`_round.
std::optional<std::uint32_t> add_prism(Model& model, const std::vector<Disc>& discs, double low, double high,
                                       const Affine& frame, const std::string& name);

/// Evaluating a rounded solid takes time in proportion to its balls; hulls of more are facetted.
inline constexpr std::size_t kMostBalls = kMostDiscs;

/// A rounded solid in a frame.
std::uint32_t add_rounded(Model& model, RoundedSolid solid, const Affine& frame, const std::string& name);

/// The hull of spheres; nothing if more than kMostBalls are on its surface.
std::optional<std::uint32_t> add_hull_of_spheres(Model& model, std::vector<Ball> balls,
                                                 const std::string& name);

}  // namespace mortise::model_reader
