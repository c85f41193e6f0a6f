// Exact orientation on the lattice, and the flatness limit of the certificate.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace mortise::cnio {

/// A point in lattice units from its cell's minimum corner: 0 … kCellUnits in each direction.
using LatticePoint = std::array<std::int32_t, 3>;

/// A split must leave every simplex at least this high, in lattice units (6e-8 of a cell): more than the
/// half step by which rounding moves a point, and more than the rounding of model coordinates.
inline constexpr double kMinHeight = 4;

/// Nor flatter, relative to its longest edge: what double precision in model coordinates still tells to be
/// positive.
inline constexpr double kMinRelativeArea = 1e-9;
inline constexpr double kMinRelativeVolume = 1e-12;

__extension__ using Int128 = __int128;  // a GNU extension; the alias keeps -Wpedantic quiet

/// An end of an edge this close to the root (1.5e-5 of a cell) counts as on the surface; nothing is split
/// there.
inline constexpr double kMergeDistance = 1024;

/// Where a split is refused, an end of the edge this close to the root does so too.
inline constexpr double kSnapDistance = 16384;

inline Int128 determinant(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                          const LatticePoint& d) {
    const std::int64_t ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
    const std::int64_t vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
    const std::int64_t wx = d[0] - a[0], wy = d[1] - a[1], wz = d[2] - a[2];
    const std::int64_t x = vy * wz - vz * wy;
    const std::int64_t y = vz * wx - vx * wz;
    const std::int64_t z = vx * wy - vy * wx;
    return static_cast<Int128>(ux) * x + static_cast<Int128>(uy) * y + static_cast<Int128>(uz) * z;
}

/// Square of twice a triangle's area.
inline double squared_normal(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
    const double ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
    const double vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
    const double x = uy * vz - uz * vy;
    const double y = uz * vx - ux * vz;
    const double z = ux * vy - uy * vx;
    return x * x + y * y + z * z;
}

inline double twice_area(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
    return std::sqrt(squared_normal(a, b, c));
}

inline double squared_distance(const LatticePoint& a, const LatticePoint& b) {
    const double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    return x * x + y * y + z * z;
}

inline double distance(const LatticePoint& a, const LatticePoint& b) {
    return std::sqrt(squared_distance(a, b));
}

/// A tetrahedron that is positive and nowhere lower than kMinHeight.
inline bool is_solid(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                     const LatticePoint& d) {
    const Int128 exact = determinant(a, b, c, d);
    if (exact <= 0) return false;
    const double largest =
        std::max({twice_area(a, b, c), twice_area(a, b, d), twice_area(a, c, d), twice_area(b, c, d)});
    const double longest = std::max(
        {distance(a, b), distance(a, c), distance(a, d), distance(b, c), distance(b, d), distance(c, d)});
    const double volume = static_cast<double>(exact);
    return volume >= kMinHeight * largest && volume >= kMinRelativeVolume * longest * longest * longest;
}

}  // namespace mortise::cnio
