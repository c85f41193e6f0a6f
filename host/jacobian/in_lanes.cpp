#include "host/jacobian/in_lanes.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/point_lanes.hpp"
#include "host/common/wide.hpp"
#include "kernels/shared/corners.h"
#include "mortise/check.hpp"

namespace mortise::jacobian {

#ifdef MORTISE_HAS_LANES
namespace {

using lanes::Doubles;
using lanes::Points;

constexpr std::size_t kChunk = 4096;
constexpr std::size_t kAtOnce = 8;
static_assert(kChunk % kAtOnce == 0);

/// The square of the scaled Jacobian at a corner, with its sign: as kernels/jacobian/corner_value.h.
template <std::size_t kWidth>
[[gnu::always_inline]] inline Doubles<kWidth> corner_value(const Points<kWidth>& a, const Points<kWidth>& b,
                                                           const Points<kWidth>& c) {
    const Doubles<kWidth> determinant = dot(lanes::cross(a, b), c);
    const Doubles<kWidth> squares = dot(a, a) * dot(b, b) * dot(c, c);
    const Doubles<kWidth> size = determinant < 0 ? -determinant : determinant;
    return squares > 0 ? determinant * size / squares : Doubles<kWidth>{};
}

#define MORTISE_CORNER(node, first, second, third)                                     \
    {                                                                                  \
        const Doubles<kWidth> value =                                                  \
            corner_value(p[first] - p[node], p[second] - p[node], p[third] - p[node]); \
        smallest = value < smallest ? value : smallest;                                \
    }

/// Values of up to eight elements, by their nodes, one after another; at least one.
#define MORTISE_SMALLEST_CORNERS(name, node_count, CORNERS)                                                 \
    template <std::size_t kWidth>                                                                           \
    [[gnu::always_inline]] inline void name##_in(const double* points, const NodeId* nodes,                 \
                                                 std::size_t count, float* values) {                        \
        for (std::size_t at = 0; at < count; at += kWidth) {                                                \
            const NodeId* elements[kWidth];                                                                 \
            for (std::size_t i = 0; i < kWidth; ++i)                                                        \
                elements[i] = nodes + (node_count)*std::min(at + i, count - 1);                             \
            Points<kWidth> p[node_count];                                                                   \
            for (std::size_t k = 0; k < (node_count); ++k) p[k] = lanes::load<kWidth>(points, elements, k); \
            Doubles<kWidth> smallest = Doubles<kWidth>{} + 1;                                               \
            CORNERS(MORTISE_CORNER)                                                                         \
            for (std::size_t i = 0; i < kWidth && at + i < count; ++i) {                                    \
                const double square = smallest[i];                                                          \
                values[at + i] = static_cast<float>(std::copysign(std::sqrt(std::fabs(square)), square));   \
            }                                                                                               \
        }                                                                                                   \
    }                                                                                                       \
    MORTISE_BY_WIDTH(void, name,                                                                            \
                     (const double* points, const NodeId* nodes, std::size_t count, float* values),         \
                     (points, nodes, count, values))

MORTISE_SMALLEST_CORNERS(hexahedra, 8, MORTISE_HEXAHEDRON_CORNERS)
MORTISE_SMALLEST_CORNERS(wedges, 6, MORTISE_WEDGE_CORNERS)
MORTISE_SMALLEST_CORNERS(pyramids, 5, MORTISE_PYRAMID_CORNERS)
MORTISE_SMALLEST_CORNERS(tetrahedra, 4, MORTISE_TETRAHEDRON_CORNERS)
#undef MORTISE_SMALLEST_CORNERS
#undef MORTISE_CORNER

using SmallestCorners = void (*)(const double*, const NodeId*, std::size_t, float*);
constexpr SmallestCorners kSmallestCorners[kElementTypes] = {hexahedra, wedges, pyramids, tetrahedra};

/// Whether all of these are of kind kIn.
bool are_cubes(const std::uint8_t* kinds, std::size_t count) {
    return std::all_of(kinds, kinds + count,
                       [](std::uint8_t kind) { return kind == static_cast<std::uint8_t>(ElementKind::kIn); });
}

}  // namespace

void correct_cubes(const Mesh& mesh, const IndexRuns& cubes, float* values) {
    for (const IndexRun& run : cubes) {
        for (std::size_t i = run.begin; i < run.end; ++i)
            hexahedra(mesh.points.data(), mesh.elements[0].nodes.data() + 8 * i, 1, values + i);
    }
}

std::size_t tetrahedra_with_sixths(const Mesh& mesh, const IndexRuns& sixths, int threads, float* values) {
    const ElementBlock& block = mesh.block(ElementType::kTetrahedron);
    const std::size_t count = sixths.empty() ? 0 : sixths.back().end;
    parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        RunFinder finder(sixths, begin);
        for (std::size_t i = begin; i < end;) {
            const IndexRun* const run = finder.run_of(i);
            if (run != nullptr) {
                const std::size_t to = std::min(end, run->end);
                std::fill(values + i, values + to, kSixth);
                i = to;
                continue;
            }
            std::size_t to = i + 1;
            while (to < end && finder.run_of(to) == nullptr) ++to;
            tetrahedra(mesh.points.data(), block.nodes.data() + 4 * i, to - i, values + i);
            i = to;
        }
    });
    return count;
}

std::vector<float> scaled_jacobians_in_lanes(const Mesh& mesh, int threads, const KnownShapes& known) {
    std::vector<float> values;
    resize_large(values, mesh.element_count(), threads);
    float* out = values.data();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const auto size = static_cast<std::size_t>(kElementNodes[t]);
        const std::size_t done =
            t == 3 && known.sixths != nullptr ? tetrahedra_with_sixths(mesh, *known.sixths, threads, out) : 0;
        parallel_chunks(block.size() - done, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = done + begin; i < done + end; i += kAtOnce) {
                const std::size_t count = std::min(kAtOnce, done + end - i);
                if (t == 0 && known.moved_cubes != nullptr && are_cubes(block.kind.data() + i, count)) {
                    std::fill_n(out + i, count, 1.0f);
                    continue;
                }
                kSmallestCorners[t](mesh.points.data(), block.nodes.data() + size * i, count, out + i);
            }
        });
        out += block.size();
    }
    if (known.moved_cubes != nullptr) correct_cubes(mesh, *known.moved_cubes, values.data());
    return values;
}
#else
void correct_cubes(const Mesh& mesh, const IndexRuns& cubes, float* values) {
    if (cubes.empty()) return;
    const std::vector<float> all = mortise::scaled_jacobians(mesh);
    for (const IndexRun& run : cubes) std::copy(&all[run.begin], &all[run.end], values + run.begin);
}

std::size_t tetrahedra_with_sixths(const Mesh&, const IndexRuns&, int, float*) { return 0; }

std::vector<float> scaled_jacobians_in_lanes(const Mesh& mesh, int, const KnownShapes&) {
    return mortise::scaled_jacobians(mesh);
}
#endif

}  // namespace mortise::jacobian
