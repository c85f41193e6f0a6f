#include "host/common/good_elements.hpp"

#include "host/common/wide.hpp"
#include "kernels/shared/corners.h"
#include "kernels/shared/lattice.h"

namespace mortise {

#if defined(__GNUC__) && !defined(__clang__)
namespace {

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

using Lanes = double __attribute__((vector_size(kLookedAtOnce * sizeof(double))));
using Mask = std::int64_t __attribute__((vector_size(kLookedAtOnce * sizeof(std::int64_t))));

struct Point {
    Lanes x, y, z;
};

constexpr double kMargin = 1 - 1e-6;
constexpr double kJacobian = kMargin / 0.04;             // per square of the least scaled Jacobian
constexpr double kAcute = kMargin / 0.0954915028125263;  // per square of the sine of 18 degrees
constexpr double kObtuse = kMargin / 0.178606194956727;  // of 155

[[gnu::always_inline]] inline Point operator-(const Point& a, const Point& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Lanes dot(const Point& a, const Point& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// An angle between faces, by what is said of it at a corner: the square of the volume times that of their
/// edge, the product of the squares of their normals, and the product of these, positive where it is obtuse.
[[gnu::always_inline]] inline Mask is_angle_good(const Lanes& square, const Lanes& normals,
                                                 const Lanes& inner) {
    const Lanes scale = inner < 0 ? Lanes{} + kAcute : Lanes{} + kObtuse;
    return square * scale >= normals;
}

/// A corner with edges u, v, w, right-handed (scaled_corner_quality in kernels/shared/corner_quality.h,
/// without its divisions).
[[gnu::always_inline]] inline Mask is_corner_good(const Point& u, const Point& v, const Point& w,
                                                  double shortest) {
    const Point l = cross(v, w), m = cross(w, u), n = cross(u, v);
    const Lanes volume = dot(u, l);
    const Lanes square = volume * volume;
    const Lanes uu = dot(u, u), vv = dot(v, v), ww = dot(w, w);
    const Lanes ll = dot(l, l), mm = dot(m, m), nn = dot(n, n);
    Mask good = (volume > 0) & (square * kJacobian >= uu * vv * ww);
    good &= is_angle_good(square * uu, mm * nn, dot(m, n));
    good &= is_angle_good(square * vv, nn * ll, dot(n, l));
    good &= is_angle_good(square * ww, ll * mm, dot(l, m));
    return good & (uu >= shortest) & (vv >= shortest) & (ww >= shortest);
}

/// Coordinate j of eight nodes, in cells.
[[gnu::always_inline]] inline Lanes coordinate(const double* const (&node)[kLookedAtOnce], std::size_t j,
                                               const GoodElementsFrame& frame) {
    constexpr double kRounder = 6755399441055744.0;  // 1.5 × 2^52: rounds as std::rint, without a call
    const Lanes model = {node[0][j], node[1][j], node[2][j], node[3][j],
                         node[4][j], node[5][j], node[6][j], node[7][j]};
    const Lanes cells = (model - frame.origin[j]) * frame.per_cell;
    if (!frame.on_lattice) return cells;
    return ((cells * kCellUnits + kRounder) - kRounder) * (1.0 / kCellUnits);
}

/// Node k of eight elements.
[[gnu::always_inline]] inline Point load(const double* points,
                                         const std::array<const NodeId*, kLookedAtOnce>& elements,
                                         std::size_t k, const GoodElementsFrame& frame) {
    const double* node[kLookedAtOnce];
    for (std::size_t i = 0; i < kLookedAtOnce; ++i) node[i] = points + 3 * std::size_t{elements[i][k]};
    return {coordinate(node, 0, frame), coordinate(node, 1, frame), coordinate(node, 2, frame)};
}

#define MORTISE_CORNER(node, first, second, third) \
    good &= is_corner_good(p[first] - p[node], p[second] - p[node], p[third] - p[node], shortest);
#define MORTISE_GOOD_ELEMENTS(name, nodes, CORNERS, edge)                                      \
    MORTISE_WIDE unsigned name(const double* points,                                           \
                               const std::array<const NodeId*, kLookedAtOnce>& elements,       \
                               const GoodElementsFrame& frame) {                               \
        Point p[nodes];                                                                        \
        for (std::size_t k = 0; k < nodes; ++k) p[k] = load(points, elements, k, frame);       \
        const double shortest = (edge) * (edge);                                               \
        Mask good = Mask{} - 1;                                                                \
        CORNERS(MORTISE_CORNER)                                                                \
        unsigned bits = 0;                                                                     \
        for (std::size_t i = 0; i < kLookedAtOnce; ++i) bits |= (good[i] != 0 ? 1u : 0u) << i; \
        return bits;                                                                           \
    }

constexpr double kLonger = 1 + 1e-6;
MORTISE_GOOD_ELEMENTS(good_hexahedra, 8, MORTISE_HEXAHEDRON_CORNERS, kLonger* frame.shortest)
MORTISE_GOOD_ELEMENTS(good_wedges, 6, MORTISE_WEDGE_CORNERS, kLonger* frame.shortest)
MORTISE_GOOD_ELEMENTS(good_pyramids, 5, MORTISE_PYRAMID_CORNERS, kLonger* frame.shortest)
MORTISE_GOOD_ELEMENTS(good_tetrahedra, 4, MORTISE_TETRAHEDRON_CORNERS, 0.0)
#undef MORTISE_GOOD_ELEMENTS
#undef MORTISE_CORNER

}  // namespace

unsigned certainly_good(ElementType type, const double* points,
                        const std::array<const NodeId*, kLookedAtOnce>& elements,
                        const GoodElementsFrame& frame) {
    switch (type) {
        case ElementType::kHexahedron: return good_hexahedra(points, elements, frame);
        case ElementType::kWedge: return good_wedges(points, elements, frame);
        case ElementType::kPyramid: return good_pyramids(points, elements, frame);
        default: return good_tetrahedra(points, elements, frame);
    }
}
#else
unsigned certainly_good(ElementType, const double*, const std::array<const NodeId*, kLookedAtOnce>&,
                        const GoodElementsFrame&) {
    return 0;
}
#endif

}  // namespace mortise
