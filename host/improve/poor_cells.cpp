#include "host/improve/poor_cells.hpp"

#include <atomic>
#include <cmath>

#include "host/common/cubes.hpp"
#include "host/common/good_elements.hpp"
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "kernels/shared/corners.h"

namespace mortise::improve {
namespace {

constexpr std::size_t kPoorChunk = 4096;
/// A hexahedron, wedge or pyramid with an edge shorter than this, in edges of the smallest leaf at its ends,
/// counts as poor: it may have right angles and still make its neighbours flat.
constexpr double kShortestEdge = 0.35;
/// Up to this level positions are certain to kVolumeRounding of a finest cell.
constexpr int kCertainLevel = 11;

/// Corners by type: a node, and the ends of its three edges, right-handed.
#define MORTISE_CORNER(node, first, second, third) {node, first, second, third},
constexpr std::uint8_t kCorners[4][8][4] = {{MORTISE_HEXAHEDRON_CORNERS(MORTISE_CORNER)},
                                            {MORTISE_WEDGE_CORNERS(MORTISE_CORNER)},
                                            {MORTISE_PYRAMID_CORNERS(MORTISE_CORNER)},
                                            {MORTISE_TETRAHEDRON_CORNERS(MORTISE_CORNER)}};
#undef MORTISE_CORNER
constexpr std::size_t kCornerCount[kElementTypes] = {8, 6, 4, 4};

/// Of elements between cells of two sizes angles alone count: their templates have scaled Jacobians of 0.258,
/// and replacing them all for that would turn the cells around into tetrahedra, too.
double element_quality(const Mesh& mesh, const CellFrame& frame, const Element& e, ElementKind kind,
                       double rounding) {
    std::array<Point, 8> p;
    for (std::size_t k = 0; k < e.count; ++k) p[k] = in_cells(mesh, frame, e.node[k]);
    const bool is_transition = kind == ElementKind::kTransition;
    if (e.type == ElementType::kTetrahedron && !is_transition)
        return tetrahedron_quality(p[0], p[1], p[2], p[3], rounding);
    const auto type = static_cast<std::size_t>(e.type);
    double worst = 2;
    for (std::size_t i = 0; i < kCornerCount[type]; ++i) {
        const auto& c = kCorners[type][i];
        const Point& o = p[c[0]];
        worst = std::min(worst, corner_quality(p[c[1]] - o, p[c[2]] - o, p[c[3]] - o,
                                               is_transition ? kAnglesOnly : kJacobianWeight));
    }
    return worst;
}

/// Whether an element that is no tetrahedron is too flat to be split into good ones.
bool is_flat(const Mesh& mesh, const CellFrame& frame, const Places& places, const Element& e) {
    const LocalFaces faces = local_faces(e.type);
    for (int f = 0; f < faces.count; ++f) {
        const LocalFace& face = faces.faces[f];
        const std::size_t count = corner_count(face);
        for (std::size_t k = 0; k < count; ++k) {
            const NodeId a = e.node[face[k]], b = e.node[face[(k + 1) % count]];
            const Point edge = in_cells(mesh, frame, a) - in_cells(mesh, frame, b);
            const double shortest =
                kShortestEdge * edge_of(std::min(places.size_class(a), places.size_class(b)));
            if (squared_length(edge) < shortest * shortest) return true;
        }
    }
    return false;
}

}  // namespace

double volume_rounding(const CellFrame& frame, int finest_class) {
    return kVolumeRounding * std::ldexp(1.0, std::max(finest_class, frame.level - kCertainLevel));
}

std::vector<CellId> poor_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                               const Places& places, double rounding, double least, int threads,
                               const Known& known) {
    const bool is_quick = !(least > kGoodQuality) && frame.leaves == nullptr && frame.level <= kCertainLevel;
    GoodElementsFrame quick;
    quick.origin = frame.origin;
    quick.per_cell = frame.per_cell;
    quick.on_lattice = frame.on_lattice;
    quick.shortest = kShortestEdge;
    std::vector<CellId> poor;
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        const std::size_t before = known.old[static_cast<std::size_t>(t)];
        const std::size_t count = block.size() - before;
        std::vector<std::vector<CellId>> found(chunk_count(count, kPoorChunk));
        parallel_chunks(count, kPoorChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            std::vector<CellId>& list = found[begin / kPoorChunk];
            const auto look = [&](std::size_t i) {
                const Element e = element(mesh, t, i);
                if (element_quality(mesh, frame, e, static_cast<ElementKind>(block.kind[i]), rounding) <
                        least ||
                    (t < 3 && is_flat(mesh, frame, places, e)))
                    list.push_back(cells.index(centroid(mesh, frame, e)));
            };
            GoodElementsFilter filter(mesh, static_cast<ElementType>(t), quick, look);
            for (std::size_t i = before + begin; i < before + end; ++i) {
                if (t == 0) i = next_no_cube(block, i, before + end);
                if (i == before + end) break;
                if (is_quick)
                    filter.look_at(i);
                else
                    look(i);
            }
            filter.finish();
        });
        for (const auto& list : found) poor.insert(poor.end(), list.begin(), list.end());
    }
    sort_unique(poor);
    return poor;
}

std::uint64_t count_below(const Mesh& mesh, const CellFrame& frame, double least, int threads) {
    const double rounding = volume_rounding(frame, frame.leaves == nullptr ? 0 : finest_class(*frame.leaves));
    std::atomic<std::uint64_t> count{0};
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        parallel_chunks(block.size(), kPoorChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            std::uint64_t below = 0;
            for (std::size_t i = begin; i < end; ++i) {
                below += !is_cube(block, t, i) &&
                                 element_quality(mesh, frame, element(mesh, t, i),
                                                 static_cast<ElementKind>(block.kind[i]), rounding) < least
                             ? 1
                             : 0;
            }
            count += below;
        });
    }
    return count;
}

}  // namespace mortise::improve
