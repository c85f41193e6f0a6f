// Netgen's primitives as Mortise primitives under affine maps.
#pragma once

#include <string_view>
#include <unordered_map>
#include <vector>

#include "host/model/geo/geo_curves.hpp"
#include "host/model/geo/geo_lexer.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// What primitives know of the statements around them, and leave to them.
struct GeoShapes {
    GeoCurves curves;
    /// Nodes of polyhedra: for each triangle the number of its face in the file, from 0.
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> faces;
};

/// Whether `name` is a primitive that add_geo_primitive reads.
bool is_geo_primitive(std::string_view name);

/// "plane, sphere, ..." for messages.
std::string geo_primitive_list();
std::vector<std::string_view> geo_primitive_names();

/// Reads "name ( ... )" at the lexer's token and returns its top node.
std::uint32_t add_geo_primitive(Model& model, GeoLexer& lexer, GeoShapes& shapes);

/// Netgen's rotation about `center`: Rz(angles[2])·Rx(angles[1])·Rz(angles[0]), angles in radians and each
/// factor turning clockwise: x' = x cos + y sin, y' = y cos - x sin.
Affine geo_rotation(const Vec3& center, const Vec3& angles);

}  // namespace mortise::model_reader
