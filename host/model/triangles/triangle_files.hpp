// Readers of surfaces of triangles: STL, OBJ and OFF.
//
// Each takes the file's whole content and gives a repaired surface (surface_repair.hpp). Errors name the
// line and column, in binary files the byte.
#pragma once

#include <string>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

TriangleSurface read_stl(const std::string& content, const std::string& source,
                         std::vector<std::string>& warnings);
TriangleSurface read_obj(const std::string& content, const std::string& source,
                         std::vector<std::string>& warnings);
TriangleSurface read_off(const std::string& content, const std::string& source,
                         std::vector<std::string>& warnings);

/// "stl", "obj" or "off".
bool is_triangle_format(const std::string& format);

TriangleSurface read_triangles(const std::string& content, const std::string& format,
                               const std::string& source, std::vector<std::string>& warnings);

/// Edges of files without any other sign of what is smooth are creases from this angle on, in degrees.
inline constexpr double kSharpAngle = 40;

/// A model with the surface as its one solid.
Model read_triangle_model(const std::string& content, const std::string& format, const std::string& source,
                          const std::string& region);

}  // namespace mortise::model_reader
