// Words and numbers of a mesh for people.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/common/message_text.hpp"
#include "mortise/check.hpp"
#include "mortise/mesher.hpp"
#include "mortise/model.hpp"

namespace mortise::cli {

inline constexpr std::array<const char*, kElementTypes> kElementNames = {"hexahedra", "wedges", "pyramids",
                                                                         "tetrahedra"};

/// "120 hexahedra, 8 wedges": types without elements are left out.
std::string list_elements(const std::array<std::uint64_t, kElementTypes>& elements);

/// "0.71 hexahedra, 0.2 wedges".
std::string list_jacobians(const std::array<std::uint64_t, kElementTypes>& elements,
                           const std::array<double, kElementTypes>& jacobians);

/// What, how often and where, in one line.
std::string describe(const Defect& defect);

/// " (2 of them hang on others by an edge or a node only)", or nothing.
std::string touching_text(const CheckReport& report);

/// Lines of a run's summary: its time by stages, and what may take less where improvement takes long.
std::string times_text(const std::vector<StageTime>& stages);

}  // namespace mortise::cli
