// Cubes among hexahedra: those of IN cells, most of a large mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "mortise/mesh.hpp"

namespace mortise {

inline bool is_cube(const ElementBlock& hexahedra, std::size_t i) {
    return hexahedra.kind[i] == static_cast<std::uint8_t>(ElementKind::kIn);
}

/// The next hexahedron from `i` on that is none; at most `end`. Eight are looked at at a time.
inline std::size_t next_no_cube(const ElementBlock& hexahedra, std::size_t i, std::size_t end) {
    static_assert(static_cast<std::uint8_t>(ElementKind::kIn) == 0);
    const std::uint8_t* const kinds = hexahedra.kind.data();
    for (std::uint64_t eight = 0; i + sizeof eight <= end; i += sizeof eight) {
        std::memcpy(&eight, kinds + i, sizeof eight);
        if (eight != 0) break;
    }
    while (i < end && kinds[i] == 0) ++i;
    return i;
}

}  // namespace mortise
