// Affine algebra of affine.hpp.
#include "host/model/affine.hpp"

#include <cmath>
#include <cstddef>

namespace mortise::model_reader {

Vec3 unit(const Vec3& v) {
    const double norm = length(v);
    return {v[0] / norm, v[1] / norm, v[2] / norm};
}

Affine translation(const Vec3& shift) { return {1, 0, 0, shift[0], 0, 1, 0, shift[1], 0, 0, 1, shift[2]}; }

Affine from_columns(const Vec3& column0, const Vec3& column1, const Vec3& column2, const Vec3& origin) {
    Affine map{};
    for (std::size_t row = 0; row < 3; ++row) {
        map[4 * row] = column0[row];
        map[4 * row + 1] = column1[row];
        map[4 * row + 2] = column2[row];
        map[4 * row + 3] = origin[row];
    }
    return map;
}

Affine frame_along(const Vec3& axis, const Vec3& origin) {
    const Vec3 z = unit(axis);
    // The coordinate axis least parallel to z, made perpendicular to it.
    std::size_t smallest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
        if (std::fabs(z[k]) < std::fabs(z[smallest])) smallest = k;
    }
    Vec3 x{};
    x[smallest] = 1;
    const double along = z[smallest];
    for (std::size_t k = 0; k < 3; ++k) x[k] -= along * z[k];
    x = unit(x);
    return from_columns(x, cross(z, x), z, origin);
}

Affine compose(const Affine& second, const Affine& first) {
    Affine result{};
    for (std::size_t row = 0; row < 3; ++row) {
        const double* m = &second[4 * row];
        for (std::size_t column = 0; column < 4; ++column) {
            result[4 * row + column] =
                m[0] * first[column] + m[1] * first[4 + column] + m[2] * first[8 + column];
        }
        result[4 * row + 3] += m[3];
    }
    return result;
}

Affine inverse_of(const Affine& map) {
    const Vec3 x = {map[0], map[4], map[8]};
    const Vec3 y = {map[1], map[5], map[9]};
    const Vec3 z = {map[2], map[6], map[10]};
    const Vec3 origin = {map[3], map[7], map[11]};
    const std::array<Vec3, 3> rows = {cross(y, z), cross(z, x), cross(x, y)};
    const double determinant = dot(x, rows[0]);
    Affine inverse{};
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t j = 0; j < 3; ++j) inverse[4 * k + j] = rows[k][j] / determinant;
        inverse[4 * k + 3] = -dot(rows[k], origin) / determinant;
    }
    return inverse;
}

double relative_determinant(const Affine& map) {
    std::array<Vec3, 3> columns{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 column = {map[k], map[4 + k], map[8 + k]};
        const double norm = length(column);
        if (!std::isfinite(norm) || norm == 0) return 0;
        columns[k] = unit(column);
    }
    return dot(columns[0], cross(columns[1], columns[2]));
}

}  // namespace mortise::model_reader
