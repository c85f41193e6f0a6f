// Affine maps for computing with: the model's are lists of twelve numbers.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "mortise/model.hpp"

namespace mortise::tape {

inline glm::dvec3 to_vector(const Vec3& p) { return {p[0], p[1], p[2]}; }

/// Affine map as 3×3 matrix and offset, in double precision.
struct Map {
    glm::dmat3 matrix{1.0};  ///< column-major, as GLM has it
    glm::dvec3 offset{0.0};
};

inline Map to_map(const Affine& a) {
    Map map;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) map.matrix[column][row] = a[4 * row + column];
        map.offset[row] = a[4 * row + 3];
    }
    return map;
}

inline Affine to_affine(const Map& map) {
    Affine a{};
    for (int row = 0; row < 3; ++row) {
        const auto first = static_cast<std::size_t>(4 * row);
        for (int column = 0; column < 3; ++column) {
            a[first + static_cast<std::size_t>(column)] = map.matrix[column][row];
        }
        a[first + 3] = map.offset[row];
    }
    return a;
}

inline Map compose(const Map& outer, const Map& inner) {
    return {outer.matrix * inner.matrix, outer.matrix * inner.offset + outer.offset};
}

}  // namespace mortise::tape
