#include "host/common/good_elements.hpp"

#include "host/common/point_lanes.hpp"
#include "host/common/wide.hpp"
#include "kernels/shared/corners.h"

namespace mortise {

#ifdef MORTISE_HAS_LANES
namespace {

using lanes::Doubles;
using lanes::Points;
template <std::size_t kWidth>
using Mask = decltype(Doubles<kWidth>{} < 0);

constexpr double kMargin = 1 - 1e-6;
constexpr double kJacobian = kMargin / 0.04;             // per square of the least scaled Jacobian
constexpr double kAcute = kMargin / 0.0954915028125263;  // per square of the sine of 18 degrees
constexpr double kObtuse = kMargin / 0.178606194956727;  // of 155

/// An angle between faces, by what is said of it at a corner: the square of the volume times that of their
/// edge, the product of the squares of their normals, and the product of these, positive where it is obtuse.
template <class Reals>
[[gnu::always_inline]] inline auto is_angle_good(const Reals& square, const Reals& normals,
                                                 const Reals& inner) {
    const Reals scale = inner < 0 ? Reals{} + kAcute : Reals{} + kObtuse;
    return square * scale >= normals;
}

/// A corner with edges u, v, w, right-handed (scaled_corner_quality in kernels/shared/corner_quality.h,
/// without its divisions).
template <std::size_t kWidth>
[[gnu::always_inline]] inline Mask<kWidth> is_corner_good(const Points<kWidth>& u, const Points<kWidth>& v,
                                                          const Points<kWidth>& w, double shortest) {
    using Reals = Doubles<kWidth>;
    const Points<kWidth> l = cross(v, w), m = cross(w, u), n = cross(u, v);
    const Reals volume = dot(u, l);
    const Reals square = volume * volume;
    const Reals uu = dot(u, u), vv = dot(v, v), ww = dot(w, w);
    const Reals ll = dot(l, l), mm = dot(m, m), nn = dot(n, n);
    Mask<kWidth> good = (volume > 0) & (square * kJacobian >= uu * vv * ww);
    good &= is_angle_good<Reals>(square * uu, mm * nn, dot(m, n));
    good &= is_angle_good<Reals>(square * vv, nn * ll, dot(n, l));
    good &= is_angle_good<Reals>(square * ww, ll * mm, dot(l, m));
    return good & (uu >= shortest) & (vv >= shortest) & (ww >= shortest);
}

using Elements = std::array<const NodeId*, kLookedAtOnce>;

#define MORTISE_CORNER(node, first, second, third) \
    good &= is_corner_good(p[first] - p[node], p[second] - p[node], p[third] - p[node], shortest);
#define MORTISE_GOOD_ELEMENTS(name, nodes, CORNERS, edge)                                              \
    template <std::size_t kWidth>                                                                      \
    [[gnu::always_inline]] inline unsigned name##_in(const double* points, const Elements& elements,   \
                                                     const GoodElementsFrame& frame) {                 \
        const double shortest = (edge) * (edge);                                                       \
        unsigned bits = 0;                                                                             \
        for (std::size_t first = 0; first < kLookedAtOnce; first += kWidth) {                          \
            Points<kWidth> p[nodes];                                                                   \
            for (std::size_t k = 0; k < nodes; ++k)                                                    \
                p[k] = lanes::load_in_cells<kWidth>(points, &elements[first], k, frame);               \
            Mask<kWidth> good = Mask<kWidth>{} - 1;                                                    \
            CORNERS(MORTISE_CORNER)                                                                    \
            for (std::size_t i = 0; i < kWidth; ++i) bits |= (good[i] != 0 ? 1u : 0u) << (first + i);  \
        }                                                                                              \
        return bits;                                                                                   \
    }                                                                                                  \
    MORTISE_BY_WIDTH(unsigned, name,                                                                   \
                     (const double* points, const Elements& elements, const GoodElementsFrame& frame), \
                     (points, elements, frame))

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
