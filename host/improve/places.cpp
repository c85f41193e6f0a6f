#include "host/improve/places.hpp"

#include <atomic>

#include "host/common/cubes.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/improve/centroids.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kPlaceChunk = 4096;
/// Hexahedra of IN cells of which first and last tell that none is near the zone.
constexpr std::size_t kRow = 64;

/// Whether no cube from the first to the last lies in one of these bricks of a uniform tree.
bool is_row_far(const Mesh& mesh, const CellFrame& frame, const std::vector<std::uint64_t>& bricks,
                std::size_t first, std::size_t last) {
    const auto brick_of = [&](std::size_t i) {
        const Point p = place_of(mesh, frame, 0, i);
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
    return begin == end || is_row_far(mesh, frame, bricks, begin, end - 1);
}

/// Lists the elements of one type near the set, chunk by chunk.
class CellFinder {
  public:
    CellFinder(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
               const std::vector<std::uint64_t>& bricks, int type)
        : mesh_(mesh),
          frame_(frame),
          cells_(cells),
          bricks_(bricks),
          block_(mesh.elements[static_cast<std::size_t>(type)]),
          type_(type) {}

    struct Found {
        std::vector<std::uint32_t> elements;
        std::vector<std::uint32_t> cells;
    };

    Found find(std::size_t begin, std::size_t end) const {
        Found found;
        CellId at = 0;
        if (type_ == 0 && !cells_.is_graded()) {
            add_hexahedra(begin, end, at, found);
        } else if (!cells_.is_graded()) {
            add_others(begin, end, found);
        } else {
            for (std::size_t i = begin; i < end; ++i) add_if_near(i, at, found);
        }
        return found;
    }

  private:
    void add_if_near(std::size_t i, CellId& at, Found& found) const {
        // No element reaches kNearby cells.
        if (!is_cube(block_, type_, i) && !cells_.is_graded() &&
            !cells_.is_nearby(in_cells(mesh_, frame_, *element(mesh_, type_, i).node)))
            return;
        const Point place = place_of(mesh_, frame_, type_, i);
        if (cells_.is_graded() || cells_.is_near(place)) add(i, place, at, found);
    }

    void add(std::size_t i, const Point& place, CellId& at, Found& found) const {
        at = cells_.index(place, at);
        found.elements.push_back(static_cast<std::uint32_t>(i));
        found.cells.push_back(at < Places::kLookAnew ? static_cast<std::uint32_t>(at) : Places::kLookAnew);
    }

    /// Wedges, pyramids or tetrahedra of a uniform tree, eight at a time.
    void add_others(std::size_t begin, std::size_t end, Found& found) const {
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type_)]);
        CellId at = 0;
        for (std::size_t i = begin; i < end; i += kCentroidsAtOnce) {
            const std::size_t count = std::min(kCentroidsAtOnce, end - i);
            std::array<const NodeId*, kCentroidsAtOnce> elements;
            for (std::size_t k = 0; k < kCentroidsAtOnce; ++k)
                elements[k] = block_.nodes.data() + size * (i + std::min(k, count - 1));
            const Centroids found_at = centroids(mesh_, frame_, static_cast<ElementType>(type_), elements);
            for (std::size_t k = 0; k < count; ++k) {
                if (cells_.is_nearby(found_at.node[k]) && cells_.is_near(found_at.middle[k]))
                    add(i + k, found_at.middle[k], at, found);
            }
        }
    }

    /// All cubes of a chunk may be far; else they are judged row by row.
    void add_hexahedra(std::size_t begin, std::size_t end, CellId& at, Found& found) const {
        const bool all_are_far = are_cubes_far(mesh_, frame_, bricks_, begin, end);
        const std::size_t step = all_are_far ? end - begin : kRow;
        for (std::size_t row = begin; row < end; row += step) {
            const std::size_t row_end = std::min(end, row + step);
            const bool are_far = all_are_far || are_cubes_far(mesh_, frame_, bricks_, row, row_end);
            const auto next = [&](std::size_t i) { return are_far ? next_no_cube(block_, i, row_end) : i; };
            for (std::size_t i = next(row); i < row_end; i = next(i + 1)) add_if_near(i, at, found);
        }
    }

    const Mesh& mesh_;
    const CellFrame& frame_;
    const CellSet& cells_;
    const std::vector<std::uint64_t>& bricks_;
    const ElementBlock& block_;
    int type_;
};

}  // namespace

bool is_cube(const ElementBlock& block, int type, std::size_t i) {
    return type == 0 && block.kind[i] == static_cast<std::uint8_t>(ElementKind::kIn);
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

void find_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int threads, Places& places) {
    std::vector<std::uint64_t> bricks;
    if (!cells.is_graded()) bricks = cells.near_bricks();
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<std::size_t>(t);
        const CellFinder finder(mesh, frame, cells, bricks, t);
        const std::size_t count = mesh.elements[type].size();
        std::vector<std::vector<std::uint32_t>> elements(chunk_count(count, kPlaceChunk));
        std::vector<std::vector<std::uint32_t>> cells_of(elements.size());
        parallel_chunks(count, kPlaceChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            CellFinder::Found found = finder.find(begin, end);
            elements[begin / kPlaceChunk] = std::move(found.elements);
            cells_of[begin / kPlaceChunk] = std::move(found.cells);
        });
        append_lists(elements, threads, places.element[type]);
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
        parallel_chunks(mesh.elements[static_cast<std::size_t>(t)].size(), kPlaceChunk, threads,
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

}  // namespace mortise::improve
