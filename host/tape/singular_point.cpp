#include "host/tape/singular_point.hpp"

#include <algorithm>
#include <cmath>

namespace mortise::tape {

bool singular_point(const Surface& s, double* point) {
    if (s.kind != kSurfaceCone && s.kind != kSurfaceQuadric) return false;
    if (s.kind == kSurfaceQuadric) {
        double largest = 0;
        for (const double form : {s.form[0], s.form[1], s.form[2]}) {
            if (form == 0) return false;
            largest = std::max(largest, std::fabs(form));
        }
        if (std::fabs(s.form[3]) > 1e-14 * largest) return false;
        // Squares of one sign: a point, no surface.
        if ((s.form[0] > 0) == (s.form[1] > 0) && (s.form[1] > 0) == (s.form[2] > 0)) return false;
    }
    // The origin of the surface's own frame: map · (x, 1) = 0, by Cramer's rule.
    const double* row[3] = {s.map, s.map + 4, s.map + 8};
    double minor[3][3];
    for (int i = 0; i < 3; ++i) {
        const double* a = row[(i + 1) % 3];
        const double* b = row[(i + 2) % 3];
        minor[i][0] = a[1] * b[2] - a[2] * b[1];
        minor[i][1] = a[2] * b[0] - a[0] * b[2];
        minor[i][2] = a[0] * b[1] - a[1] * b[0];
    }
    const double determinant = row[0][0] * minor[0][0] + row[0][1] * minor[0][1] + row[0][2] * minor[0][2];
    if (!(std::fabs(determinant) > 0)) return false;
    double square = 0;
    for (int j = 0; j < 3; ++j) {
        point[j] = -(s.map[3] * minor[0][j] + s.map[7] * minor[1][j] + s.map[11] * minor[2][j]) / determinant;
        square += point[j] * point[j];
    }
    return std::isfinite(square);
}

}  // namespace mortise::tape
