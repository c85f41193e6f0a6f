#include "host/common/good_elements.hpp"

#include "host/common/lattice_rounding.hpp"
#include "host/common/point_lanes.hpp"
#include "host/common/wide.hpp"
#include "kernels/shared/corners.h"

namespace mortise {

#ifdef MORTISE_HAS_LANES
namespace {

using lanes::cross;
using lanes::dot;
using lanes::Doubles;
using lanes::Mask;
using lanes::Points;
static_assert(kLookedAtOnce == lanes::kWidth);

constexpr double kMargin = 1 - 1e-6;
constexpr double kJacobian = kMargin / 0.04;             // per square of the least scaled Jacobian
constexpr double kAcute = kMargin / 0.0954915028125263;  // per square of the sine of 18 degrees
constexpr double kObtuse = kMargin / 0.178606194956727;  // of 155

/// An angle between faces, by what is said of it at a corner: the square of the volume times that of their
/// edge, the product of the squares of their normals, and the product of these, positive where it is obtuse.
[[gnu::always_inline]] inline Mask is_angle_good(const Doubles& square, const Doubles& normals,
                                                 const Doubles& inner) {
    const Doubles scale = inner < 0 ? Doubles{} + kAcute : Doubles{} + kObtuse;
    return square * scale >= normals;
}

/// A corner with edges u, v, w, right-handed (scaled_corner_quality in kernels/shared/corner_quality.h,
/// without its divisions).
[[gnu::always_inline]] inline Mask is_corner_good(const Points& u, const Points& v, const Points& w,
                                                  double shortest) {
    const Points l = cross(v, w), m = cross(w, u), n = cross(u, v);
    const Doubles volume = dot(u, l);
    const Doubles square = volume * volume;
    const Doubles uu = dot(u, u), vv = dot(v, v), ww = dot(w, w);
    const Doubles ll = dot(l, l), mm = dot(m, m), nn = dot(n, n);
    Mask good = (volume > 0) & (square * kJacobian >= uu * vv * ww);
    good &= is_angle_good(square * uu, mm * nn, dot(m, n));
    good &= is_angle_good(square * vv, nn * ll, dot(n, l));
    good &= is_angle_good(square * ww, ll * mm, dot(l, m));
    return good & (uu >= shortest) & (vv >= shortest) & (ww >= shortest);
}

[[gnu::always_inline]] inline Doubles in_cells(const Doubles& model, double origin,
                                               const GoodElementsFrame& frame) {
    const Doubles cells = (model - origin) * frame.per_cell;
    return frame.on_lattice ? round_to_lattice(cells) : cells;
}

/// Node k of eight elements, in cells.
[[gnu::always_inline]] inline Points load_in_cells(const double* points, const NodeId* const* elements,
                                                   std::size_t k, const GoodElementsFrame& frame) {
    const Points model = lanes::load(points, elements, k);
    return {in_cells(model.x, frame.origin[0], frame), in_cells(model.y, frame.origin[1], frame),
            in_cells(model.z, frame.origin[2], frame)};
}

#define MORTISE_CORNER(node, first, second, third) \
    good &= is_corner_good(p[first] - p[node], p[second] - p[node], p[third] - p[node], shortest);
#define MORTISE_GOOD_ELEMENTS(name, nodes, CORNERS, edge)                                                \
    MORTISE_WIDE unsigned name(const double* points,                                                     \
                               const std::array<const NodeId*, kLookedAtOnce>& elements,                 \
                               const GoodElementsFrame& frame) {                                         \
        Points p[nodes];                                                                                 \
        for (std::size_t k = 0; k < nodes; ++k) p[k] = load_in_cells(points, elements.data(), k, frame); \
        const double shortest = (edge) * (edge);                                                         \
        Mask good = Mask{} - 1;                                                                          \
        CORNERS(MORTISE_CORNER)                                                                          \
        unsigned bits = 0;                                                                               \
        for (std::size_t i = 0; i < kLookedAtOnce; ++i) bits |= (good[i] != 0 ? 1u : 0u) << i;           \
        return bits;                                                                                     \
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
