#include "host/common/element_jacobian.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/common/vec3.hpp"
#include "kernels/shared/corners.h"

namespace mortise {
namespace {

/// A product of two linear factors, of 1 - x and x, is a Bernstein function of degree 2, which of them by how
/// often x is a factor; but half as large if each is there once.
constexpr std::array<double, 3> kShare = {1, 0.5, 1};

double triple(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)); }

double at_corner(const Vec3* p, std::size_t corner, std::size_t a, std::size_t b, std::size_t c) {
    return triple(difference(p[a], p[corner]), difference(p[b], p[corner]), difference(p[c], p[corner]));
}

double least_of_hexahedron(const Vec3* p) {
    // The corner at (i, j, k) of the unit cube.
    const auto corner = [p](std::size_t i, std::size_t j, std::size_t k) {
        constexpr std::array<std::array<std::size_t, 2>, 2> kInBase = {{{0, 3}, {1, 2}}};
        return p[kInBase[i][j] + 4 * k];
    };
    std::array<std::array<Vec3, 4>, 3> edge;  // along each axis, by the coordinates along the other two
    for (std::size_t m = 0; m < 4; ++m) {
        const std::size_t s = m / 2, t = m % 2;
        edge[0][m] = difference(corner(1, s, t), corner(0, s, t));
        edge[1][m] = difference(corner(s, 1, t), corner(s, 0, t));
        edge[2][m] = difference(corner(s, t, 1), corner(s, t, 0));
    }
    std::array<double, 27> coefficient{};
    for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
            const Vec3 normal = cross(edge[0][a], edge[1][b]);
            for (std::size_t c = 0; c < 4; ++c) {
                const std::size_t i = b / 2 + c / 2, j = a / 2 + c % 2, k = a % 2 + b % 2;
                coefficient[9 * i + 3 * j + k] += kShare[i] * kShare[j] * kShare[k] * dot(normal, edge[2][c]);
            }
        }
    }
    return *std::min_element(coefficient.begin(), coefficient.end());
}

double least_of_wedge(const Vec3* p) {
    std::array<double, 9> coefficient{};
    for (std::size_t a = 0; a < 2; ++a) {
        for (std::size_t b = 0; b < 2; ++b) {
            const Vec3 normal = cross(difference(p[3 * a + 1], p[3 * a]), difference(p[3 * b + 2], p[3 * b]));
            for (std::size_t v = 0; v < 3; ++v)
                coefficient[3 * (a + b) + v] += kShare[a + b] * dot(normal, difference(p[3 + v], p[v]));
        }
    }
    return *std::min_element(coefficient.begin(), coefficient.end());
}

double scaled_at_corner(const Vec3* p, std::size_t corner, std::size_t a, std::size_t b, std::size_t c) {
    const Vec3 u = difference(p[a], p[corner]), v = difference(p[b], p[corner]),
               w = difference(p[c], p[corner]);
    const double squares = squared_length(u) * squared_length(v) * squared_length(w);
    return squares > 0 ? triple(u, v, w) / std::sqrt(squares) : 0;
}

}  // namespace

double least_straight_jacobian(ElementType type, const Vec3* corners) {
    switch (type) {
        case ElementType::kHexahedron: return least_of_hexahedron(corners);
        case ElementType::kWedge: return least_of_wedge(corners);
        case ElementType::kPyramid:  // bilinear over the base (host/quality/jacobian.cpp has the proof)
            return std::min({at_corner(corners, 0, 1, 3, 4), at_corner(corners, 1, 2, 0, 4),
                             at_corner(corners, 2, 3, 1, 4), at_corner(corners, 3, 0, 2, 4)});
        default: return at_corner(corners, 0, 1, 2, 3);
    }
}

double least_scaled_jacobian(ElementType type, const Vec3* corners) {
    double least = std::numeric_limits<double>::infinity();
#define MORTISE_LOWER(corner, a, b, c) least = std::min(least, scaled_at_corner(corners, corner, a, b, c));
    switch (type) {
        case ElementType::kHexahedron: MORTISE_HEXAHEDRON_CORNERS(MORTISE_LOWER) break;
        case ElementType::kWedge: MORTISE_WEDGE_CORNERS(MORTISE_LOWER) break;
        case ElementType::kPyramid: MORTISE_PYRAMID_CORNERS(MORTISE_LOWER) break;
        default: MORTISE_TETRAHEDRON_CORNERS(MORTISE_LOWER) break;
    }
#undef MORTISE_LOWER
    return least;
}

}  // namespace mortise
