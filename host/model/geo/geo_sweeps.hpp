// Netgen's extrusion and revolution: a profile swept along a path or about an axis.
#pragma once

#include "host/model/geo/geo_curves.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// A closed profile along a path. On the path with tangent t, the profile's coordinates count along
/// t × z and z, where z is `up` less its part along t. An open path ends in flat caps; at kinks the profile
/// goes on to the plane between both directions. Plane where profile and path are straight, else in chords
/// (geo_curves.hpp). Throws Error without a place.
Primitive sweep_along(const GeoCurve& profile, const GeoCurve& path, const Vec3& up);

/// A profile in coordinates along and away from the axis, closed or with both ends on the axis. Returns the
/// top node: planes, cylinders and cones where the profile has lines only, else a polyhedron of chords.
std::uint32_t add_revolution(Model& model, const GeoCurve& profile, const Vec3& origin, const Vec3& axis,
                             SourceLocation where);

}  // namespace mortise::model_reader
