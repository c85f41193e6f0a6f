// Words and numbers of a mesh for people.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "mortise/check.hpp"
#include "mortise/model.hpp"

namespace mortise::cli {

inline constexpr std::array<const char*, kElementTypes> kElementNames = {"hexahedra", "wedges", "pyramids",
                                                                         "tetrahedra"};

/// "120 hexahedra, 8 wedges": types without elements are left out.
std::string list_elements(const std::array<std::uint64_t, kElementTypes>& elements);

/// "(1, 2.5, -3)".
std::string place_text(const Vec3& place);

/// "0.71 hexahedra, 0.2 wedges".
std::string list_jacobians(const std::array<std::uint64_t, kElementTypes>& elements,
                           const std::array<double, kElementTypes>& jacobians);

/// A number with a few significant digits.
std::string short_number(double value, int digits = 4);

/// What, how often and where, in one line.
std::string describe(const Defect& defect);

/// " (2 of them hang on others by an edge or a node only)", or nothing.
std::string touching_text(const CheckReport& report);

}  // namespace mortise::cli
