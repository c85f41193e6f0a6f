// Netgen's primitives as Mortise primitives under affine maps.
#pragma once

#include <string_view>

#include "host/model/geo_curves.hpp"
#include "host/model/geo_lexer.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Whether `name` is a primitive that add_geo_primitive reads.
bool is_geo_primitive(std::string_view name);

/// "plane, sphere, ..." for messages.
std::string geo_primitive_list();

/// Reads "name ( ... )" at the lexer's token and returns its top node.
std::uint32_t add_geo_primitive(Model& model, GeoLexer& lexer, const GeoCurves& curves);

/// Netgen's rotation about `center`: Rz(angles[2])·Rx(angles[1])·Rz(angles[0]), angles in radians and each
/// factor turning clockwise: x' = x cos + y sin, y' = y cos - x sin.
Affine geo_rotation(const Vec3& center, const Vec3& angles);

}  // namespace mortise::model_reader
