#include "host/improve/poor_cells.hpp"

#include <atomic>
#include <cmath>
#include <cstring>

#include "host/common/good_elements.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "kernels/shared/corners.h"

namespace mortise::improve {
namespace {

constexpr std::size_t kChunk = 4096;
constexpr int kTetrahedra = static_cast<int>(ElementType::kTetrahedron);
/// Hexahedra of IN cells, and of their pieces, of which first and last tell that none is near the zone.
constexpr std::size_t kRow = 64;
constexpr std::size_t kPieces = 6;  ///< of a cube
/// A hexahedron, wedge or pyramid with an edge shorter than this, in edges of the smallest leaf at its ends,
/// counts as poor: it may have right angles and still make its neighbours flat.
constexpr double kShortestEdge = 0.35;
/// Up to this level positions are certain to kVolumeRounding of a finest cell.
constexpr int kCertainLevel = 11;

/// The next element from `i` on that is no cube; at most `end`. Most are, so eight are looked at at a time.
std::size_t next_other(const ElementBlock& block, int type, std::size_t i, std::size_t end) {
    if (type != 0) return i;
    static_assert(static_cast<std::uint8_t>(ElementKind::kIn) == 0);
    const std::uint8_t* const kinds = block.kind.data();
    for (std::uint64_t eight = 0; i + sizeof eight <= end; i += sizeof eight) {
        std::memcpy(&eight, kinds + i, sizeof eight);
        if (eight != 0) break;
    }
    while (i < end && is_cube(block, type, i)) ++i;
    return i;
}

/// Whether no element from the first to the last lies in one of these bricks of a uniform tree; all lie in
/// cubes, in the order of the cubes' Morton codes.
bool is_row_far(const Mesh& mesh, const CellFrame& frame, const std::vector<std::uint64_t>& bricks, int type,
                std::size_t first, std::size_t last) {
    const auto brick_of = [&](std::size_t i) {
        const Point p = place_of(mesh, frame, type, i);
        return morton_encode(static_cast<u32>(p[0]), static_cast<u32>(p[1]), static_cast<u32>(p[2])) >>
               (3 * CellSet::kBrickLevels);
    };
    const auto next = std::lower_bound(bricks.begin(), bricks.end(), brick_of(first));
    return next == bricks.end() || *next > brick_of(last);
}

/// The same of the cubes among hexahedra `begin` to `end`.
bool are_cubes_far(const Mesh& mesh, const CellFrame& frame, const std::vector<std::uint64_t>& bricks,
                   std::size_t begin, std::size_t end) {
    const ElementBlock& block = mesh.elements[0];
    while (begin < end && !is_cube(block, 0, begin)) ++begin;
    while (begin < end && !is_cube(block, 0, end - 1)) --end;
    return begin == end || is_row_far(mesh, frame, bricks, 0, begin, end - 1);
}

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
        const std::size_t count = face[3] < 0 ? 3 : 4;
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

bool is_cube(const ElementBlock& block, int type, std::size_t i) {
    return type == 0 && block.kind[i] == static_cast<std::uint8_t>(ElementKind::kIn);
}

double volume_rounding(const CellFrame& frame, int finest_class) {
    return kVolumeRounding * std::ldexp(1.0, std::max(finest_class, frame.level - kCertainLevel));
}

Element element(const Mesh& mesh, int t, std::size_t i) {
    const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
    return {static_cast<ElementType>(t), mesh.elements[static_cast<std::size_t>(t)].nodes.data() + i * size,
            size};
}

Point centroid(const Mesh& mesh, const CellFrame& frame, const Element& e) {
    Point sum = {0, 0, 0};
    for (std::size_t k = 0; k < e.count; ++k) sum = sum + in_cells(mesh, frame, e.node[k]);
    return (1.0 / static_cast<double>(e.count)) * sum;
}

Point place_of(const Mesh& mesh, const CellFrame& frame, int type, std::size_t i) {
    const ElementBlock& block = mesh.elements[static_cast<std::size_t>(type)];
    if (is_cube(block, type, i)) {
        const Point low = in_cells(mesh, frame, block.nodes[8 * i]);
        if (frame.leaves == nullptr) return low + Point{0.5, 0.5, 0.5};
        return 0.5 * (low + in_cells(mesh, frame, block.nodes[8 * i + 6]));
    }
    return centroid(mesh, frame, element(mesh, type, i));
}

CellId Places::cell(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int type,
                    std::size_t i) const {
    const std::uint32_t known = cell_of[static_cast<std::size_t>(type)][i];
    if (known != kLookAnew) return known;
    return cells.index(place_of(mesh, frame, type, element[static_cast<std::size_t>(type)][i]));
}

void find_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, const Known& known,
                int threads, Places& places) {
    const IndexRuns no_pieces;
    std::vector<std::uint64_t> bricks;
    if (!cells.is_graded()) bricks = cells.near_bricks();
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<std::size_t>(t);
        const std::size_t count = mesh.elements[type].size();
        std::vector<std::vector<std::uint32_t>> elements_of(chunk_count(count, kChunk));
        std::vector<std::vector<std::uint32_t>> cells_of(elements_of.size());
        parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            std::vector<std::uint32_t>& list = elements_of[begin / kChunk];
            std::vector<std::uint32_t>& list_of_cells = cells_of[begin / kChunk];
            CellId at = 0;
            const auto add = [&](std::size_t from, std::size_t to, const Point& place) {
                if (!cells.is_graded() && !cells.is_near(place)) return;
                at = cells.index(place, at);
                const auto cell = at < Places::kLookAnew ? static_cast<std::uint32_t>(at) : Places::kLookAnew;
                for (std::size_t i = from; i < to; ++i) {
                    list.push_back(static_cast<std::uint32_t>(i));
                    list_of_cells.push_back(cell);
                }
            };
            // A cube's pieces are in its cell: their zone has taken all of them, or none.
            const auto add_pieces = [&](const IndexRun& run, std::size_t from, std::size_t to) {
                for (std::size_t i = from; i < to;) {
                    const std::size_t row = std::min(to, i + kPieces * kRow);
                    if (!cells.is_graded() && is_row_far(mesh, frame, bricks, t, i, row - 1)) i = row;
                    while (i < row) {
                        const std::size_t next = std::min(row, i + kPieces - (i - run.begin) % kPieces);
                        add(i, next, place_of(mesh, frame, t, i));
                        i = next;
                    }
                }
            };
            // All cubes of the chunk may be far; else they are judged row by row.
            bool cubes_are_far =
                t == 0 && !cells.is_graded() && are_cubes_far(mesh, frame, bricks, begin, end);
            std::size_t judged = cubes_are_far ? end : begin;
            RunFinder pieces(t == kTetrahedra ? known.cube_pieces : no_pieces, begin);
            for (std::size_t i = begin; i < end; ++i) {
                if (const IndexRun* const run = pieces.run_of(i)) {
                    const std::size_t to = std::min(end, run->end);
                    add_pieces(*run, i, to);
                    i = to - 1;
                    continue;
                }
                if (t == 0 && !cells.is_graded() && i >= judged) {
                    judged = std::min(end, i + kRow);
                    cubes_are_far = are_cubes_far(mesh, frame, bricks, i, judged);
                }
                if (cubes_are_far) {
                    const std::size_t next = next_other(mesh.elements[type], t, i, judged);
                    if (next == judged) {
                        i = next - 1;
                        continue;
                    }
                    i = next;
                }
                const bool is_one_cube = is_cube(mesh.elements[type], t, i);
                // No element reaches kNearby cells.
                if (!is_one_cube && !cells.is_graded() &&
                    !cells.is_nearby(in_cells(mesh, frame, *element(mesh, t, i).node)))
                    continue;
                add(i, i + 1, place_of(mesh, frame, t, i));
            }
        });
        append_lists(elements_of, threads, places.element[type]);
        append_lists(cells_of, threads, places.cell_of[type]);
    }
}

/// Graded trees list every element: the i-th is element i.
void find_size_classes(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int threads,
                       Places& places) {
    // Which thread lowers a number last does not matter.
    std::vector<std::atomic<std::uint8_t>> least(mesh.node_count());
    for (auto& value : least) value.store(0xff, std::memory_order_relaxed);
    for (int t = 0; t < kElementTypes; ++t) {
        parallel_chunks(mesh.elements[static_cast<std::size_t>(t)].size(), kChunk, threads,
                        [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t i = begin; i < end; ++i) {
                                const Element e = element(mesh, t, i);
                                const auto size = static_cast<std::uint8_t>(
                                    cells.size_class(places.cell(mesh, frame, cells, t, i)));
                                for (std::size_t k = 0; k < e.count; ++k) {
                                    std::atomic<std::uint8_t>& value = least[e.node[k]];
                                    std::uint8_t known = value.load(std::memory_order_relaxed);
                                    while (size < known && !value.compare_exchange_weak(
                                                               known, size, std::memory_order_relaxed)) {
                                    }
                                }
                            }
                        });
    }
    places.node_class.resize(least.size());
    for (std::size_t i = 0; i < least.size(); ++i) places.node_class[i] = least[i];
}

std::vector<CellId> poor_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                               const Places& places, double rounding, double least, int threads,
                               const Known& known) {
    // Cubes are split into good tetrahedra.
    const IndexRuns no_pieces;
    const IndexRuns& good_pieces = least > kGoodQuality ? no_pieces : known.cube_pieces;
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
        std::vector<std::vector<CellId>> found(chunk_count(count, kChunk));
        parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            std::vector<CellId>& list = found[begin / kChunk];
            const auto look = [&](std::size_t i) {
                const Element e = element(mesh, t, i);
                if (element_quality(mesh, frame, e, static_cast<ElementKind>(block.kind[i]), rounding) <
                        least ||
                    (t < 3 && is_flat(mesh, frame, places, e)))
                    list.push_back(cells.index(centroid(mesh, frame, e)));
            };
            GoodElementsFilter filter(mesh, static_cast<ElementType>(t), quick, look);
            RunFinder pieces(t == kTetrahedra ? good_pieces : no_pieces, before + begin);
            for (std::size_t i = before + begin; i < before + end; ++i) {
                if (const IndexRun* const run = pieces.run_of(i)) {
                    i = run->end - 1;
                    continue;
                }
                i = next_other(block, t, i, before + end);
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
    std::sort(poor.begin(), poor.end());
    poor.erase(std::unique(poor.begin(), poor.end()), poor.end());
    return poor;
}

std::uint64_t count_below(const Mesh& mesh, const CellFrame& frame, double least, int threads) {
    const double rounding = volume_rounding(frame, frame.leaves == nullptr ? 0 : finest_class(*frame.leaves));
    std::atomic<std::uint64_t> count{0};
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[static_cast<std::size_t>(t)];
        parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
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
