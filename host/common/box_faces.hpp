// Names of the surfaces at which MeshOptions::box cuts a solid.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace mortise {

/// By axis, the lower one first.
inline constexpr std::array<const char*, 6> kBoxFaceNames = {"box_xmin", "box_xmax", "box_ymin",
                                                             "box_ymax", "box_zmin", "box_zmax"};

inline bool is_box_face(std::string_view surface) {
    return std::find(kBoxFaceNames.begin(), kBoxFaceNames.end(), surface) != kBoxFaceNames.end();
}

}  // namespace mortise
