// Points of eight elements side by side, where the compiler has lanes (MORTISE_HAS_LANES). Everything is
// inlined: how lanes are passed depends on the machine's registers.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#define MORTISE_HAS_LANES 1

#include <array>
#include <cstddef>
#include <cstdint>

#include "mortise/mesh.hpp"

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace mortise::lanes {

inline constexpr std::size_t kWidth = 8;
using Doubles = double __attribute__((vector_size(kWidth * sizeof(double))));
using Mask = std::int64_t __attribute__((vector_size(kWidth * sizeof(std::int64_t))));

struct Points {
    Doubles x, y, z;
};

[[gnu::always_inline]] inline Points operator-(const Points& a, const Points& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Doubles dot(const Points& a, const Points& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Points cross(const Points& a, const Points& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Node k of eight elements, each given by its nodes. Built from single values in registers: an array of
/// lanes that is written one by one and read as a whole waits for the last of them.
[[gnu::always_inline]] inline Points load(const double* points, const NodeId* const* elements,
                                          std::size_t k) {
    const double* const a = points + 3 * std::size_t{elements[0][k]};
    const double* const b = points + 3 * std::size_t{elements[1][k]};
    const double* const c = points + 3 * std::size_t{elements[2][k]};
    const double* const d = points + 3 * std::size_t{elements[3][k]};
    const double* const e = points + 3 * std::size_t{elements[4][k]};
    const double* const f = points + 3 * std::size_t{elements[5][k]};
    const double* const g = points + 3 * std::size_t{elements[6][k]};
    const double* const h = points + 3 * std::size_t{elements[7][k]};
    const Doubles x = {a[0], b[0], c[0], d[0], e[0], f[0], g[0], h[0]};
    const Doubles y = {a[1], b[1], c[1], d[1], e[1], f[1], g[1], h[1]};
    const Doubles z = {a[2], b[2], c[2], d[2], e[2], f[2], g[2], h[2]};
    return {x, y, z};
}

}  // namespace mortise::lanes
#endif
