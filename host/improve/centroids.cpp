#include "host/improve/centroids.hpp"

#include "host/common/point_lanes.hpp"

namespace mortise::improve {

#ifdef MORTISE_HAS_LANES
namespace {

using lanes::Doubles;
using lanes::Points;
using Elements = std::array<const NodeId*, kCentroidsAtOnce>;
using Middles = std::array<Point, kCentroidsAtOnce>;

/// In the order of centroid(), for the same bits.
#define MORTISE_CENTROIDS(name, node_count)                                                                  \
    template <std::size_t kWidth>                                                                            \
    [[gnu::always_inline]] inline void name##_in(const double* points, const Elements& elements,             \
                                                 const CellFrame& frame, Middles& out) {                     \
        for (std::size_t first = 0; first < kCentroidsAtOnce; first += kWidth) {                             \
            const Points<kWidth> p = lanes::load_in_cells<kWidth>(points, &elements[first], 0, frame);       \
            Points<kWidth> sum = {p.x + 0, p.y + 0, p.z + 0};                                                \
            for (std::size_t k = 1; k < (node_count); ++k) {                                                 \
                const Points<kWidth> next =                                                                  \
                    lanes::load_in_cells<kWidth>(points, &elements[first], k, frame);                        \
                sum = {sum.x + next.x, sum.y + next.y, sum.z + next.z};                                      \
            }                                                                                                \
            constexpr double kPart = 1.0 / (node_count);                                                     \
            for (std::size_t i = 0; i < kWidth; ++i) {                                                       \
                out[first + i] = {kPart * sum.x[i], kPart * sum.y[i], kPart * sum.z[i]};                     \
            }                                                                                                \
        }                                                                                                    \
    }                                                                                                        \
    MORTISE_BY_WIDTH(void, name,                                                                             \
                     (const double* points, const Elements& elements, const CellFrame& frame, Middles& out), \
                     (points, elements, frame, out))

MORTISE_CENTROIDS(of_hexahedra, 8)
MORTISE_CENTROIDS(of_wedges, 6)
MORTISE_CENTROIDS(of_pyramids, 5)
MORTISE_CENTROIDS(of_tetrahedra, 4)
#undef MORTISE_CENTROIDS

}  // namespace

Middles centroids(const Mesh& mesh, const CellFrame& frame, ElementType type, const Elements& elements) {
    Middles out;
    const double* const points = mesh.points.data();
    switch (type) {
        case ElementType::kHexahedron: of_hexahedra(points, elements, frame, out); break;
        case ElementType::kWedge: of_wedges(points, elements, frame, out); break;
        case ElementType::kPyramid: of_pyramids(points, elements, frame, out); break;
        default: of_tetrahedra(points, elements, frame, out); break;
    }
    return out;
}
#else
std::array<Point, kCentroidsAtOnce> centroids(const Mesh& mesh, const CellFrame& frame, ElementType type,
                                              const std::array<const NodeId*, kCentroidsAtOnce>& elements) {
    std::array<Point, kCentroidsAtOnce> out;
    const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    for (std::size_t i = 0; i < kCentroidsAtOnce; ++i)
        out[i] = centroid(mesh, frame, {type, elements[i], size});
    return out;
}
#endif

}  // namespace mortise::improve
