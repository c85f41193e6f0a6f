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

/// Lists the elements of one type near the set, chunk by chunk.
class CellFinder {
  public:
    CellFinder(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
               const std::vector<std::uint64_t>& bricks, const Gone& gone, int type)
        : mesh_(mesh),
          frame_(frame),
          cells_(cells),
          bricks_(bricks),
          gone_(gone.element[static_cast<std::size_t>(type)]),
          block_(mesh.elements[static_cast<std::size_t>(type)]),
          type_(type) {}

    struct Found {
        std::vector<std::uint32_t> elements;
        std::vector<std::uint32_t> cells;
    };

    /// Of a graded tree: all.
    Found find(std::size_t begin, std::size_t end) const {
        Found found;
        CellId at = 0;
        for (std::size_t i = begin; i < end; ++i) add(i, place_of(mesh_, frame_, type_, i), at, found);
        return found;
    }

    /// Of a uniform tree: those near the set.
    Found find(Chunk& chunk) const {
        Found found;
        const bool others_are_far = chunk.is_known && !cells_.any_is_near(chunk.low, chunk.high);
        if (type_ == 0)
            find_hexahedra(chunk, others_are_far, found);
        else if (!others_are_far)
            find_others(chunk, found);
        return found;
    }

  private:
    /// Elements that are no cubes, eight at a time, in ascending order.
    class Batch {
      public:
        Batch(const CellFinder& finder, Chunk& chunk, Found& found)
            : finder_(finder), chunk_(chunk), found_(found) {}

        void add(std::size_t i) {
            index_[count_++] = i;
            if (count_ == kCentroidsAtOnce) finish();
        }
        /// After the last element, and before an element is added without this.
        void finish() {
            if (count_ == 0) return;
            const auto size =
                static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(finder_.type_)]);
            std::array<const NodeId*, kCentroidsAtOnce> elements;
            for (std::size_t k = 0; k < kCentroidsAtOnce; ++k)
                elements[k] = finder_.block_.nodes.data() + size * index_[std::min(k, count_ - 1)];
            const auto middle =
                centroids(finder_.mesh_, finder_.frame_, static_cast<ElementType>(finder_.type_), elements);
            for (std::size_t k = 0; k < count_; ++k) {
                chunk_.include(middle[k]);
                if (finder_.cells_.is_near(middle[k])) finder_.add(index_[k], middle[k], at_, found_);
            }
            count_ = 0;
        }

      private:
        const CellFinder& finder_;
        Chunk& chunk_;
        Found& found_;
        CellId at_ = 0;
        std::array<std::size_t, kCentroidsAtOnce> index_{};
        std::size_t count_ = 0;
    };

    void find_others(Chunk& chunk, Found& found) const {
        chunk.start();
        Batch batch(*this, chunk, found);
        for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
            if (gone_[i] == 0) batch.add(i);
        }
        batch.finish();
    }

    /// Whether none of the cubes among hexahedra `begin` to `end` is near the set.
    bool are_cubes_far(std::size_t begin, std::size_t end) const {
        const auto counts = [this](std::size_t i) { return gone_[i] == 0 && mortise::is_cube(block_, i); };
        while (begin < end && !counts(begin)) ++begin;
        while (begin < end && !counts(end - 1)) --end;
        return begin == end || is_row_far(mesh_, frame_, bricks_, begin, end - 1);
    }

    /// All cubes of a chunk may be far; else they are judged row by row.
    void find_hexahedra(Chunk& chunk, bool others_are_far, Found& found) const {
        const bool all_are_far = are_cubes_far(chunk.begin, chunk.end);
        if (all_are_far && others_are_far) return;
        chunk.start();
        CellId at = 0;
        Batch batch(*this, chunk, found);
        const std::size_t step = all_are_far ? chunk.end - chunk.begin : kRow;
        for (std::size_t row = chunk.begin; row < chunk.end; row += step) {
            const std::size_t row_end = std::min(chunk.end, row + step);
            const bool are_far = all_are_far || are_cubes_far(row, row_end);
            const auto next = [&](std::size_t i) { return are_far ? next_no_cube(block_, i, row_end) : i; };
            for (std::size_t i = next(row); i < row_end; i = next(i + 1)) {
                if (gone_[i] != 0) continue;
                if (!mortise::is_cube(block_, i)) {
                    batch.add(i);
                    continue;
                }
                batch.finish();
                const Point place = place_of(mesh_, frame_, 0, i);
                if (cells_.is_near(place)) add(i, place, at, found);
            }
        }
        batch.finish();
    }

    void add(std::size_t i, const Point& place, CellId& at, Found& found) const {
        at = cells_.index(place, at);
        found.elements.push_back(static_cast<std::uint32_t>(i));
        found.cells.push_back(at < Places::kLookAnew ? static_cast<std::uint32_t>(at) : Places::kLookAnew);
    }

    const Mesh& mesh_;
    const CellFrame& frame_;
    const CellSet& cells_;
    const std::vector<std::uint64_t>& bricks_;
    const std::vector<std::uint8_t>& gone_;  ///< nodes of such elements may be anywhere
    const ElementBlock& block_;
    int type_;
};

}  // namespace

bool is_cube(const ElementBlock& block, int type, std::size_t i) {
    return type == 0 && mortise::is_cube(block, i);
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

void find_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, Known& known, int threads,
                Places& places) {
    known.gone.make_room(mesh);
    std::vector<std::uint64_t> bricks;
    if (!cells.is_graded()) bricks = cells.near_bricks();
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<std::size_t>(t);
        const CellFinder finder(mesh, frame, cells, bricks, known.gone, t);
        const std::size_t count = mesh.elements[type].size();
        std::vector<std::vector<std::uint32_t>> elements, cells_of;
        const auto find_all = [&](std::size_t chunks, std::size_t at_once, const auto& find) {
            elements.resize(chunks);
            cells_of.resize(chunks);
            parallel_chunks(chunks, at_once, threads, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    CellFinder::Found found = find(i);
                    elements[i] = std::move(found.elements);
                    cells_of[i] = std::move(found.cells);
                }
            });
        };
        if (cells.is_graded()) {
            find_all(chunk_count(count, kPlaceChunk), 1, [&](std::size_t i) {
                return finder.find(kPlaceChunk * i, std::min(count, kPlaceChunk * (i + 1)));
            });
        } else {
            std::vector<Chunk>& chunks = known.chunks[type].of(count);
            find_all(chunks.size(), 4, [&](std::size_t i) { return finder.find(chunks[i]); });
        }
        append_lists(elements, threads, places.element[type]);
        append_lists(cells_of, threads, places.cell_of[type]);
    }
}

/// Graded trees list every element: the i-th is element i.
void find_size_classes(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, const Gone& gone,
                       int threads, Places& places) {
    // Which thread lowers a number last does not matter.
    std::vector<std::atomic<std::uint8_t>> least(mesh.node_count());
    for (auto& value : least) value.store(0xff, std::memory_order_relaxed);
    for (int t = 0; t < kElementTypes; ++t) {
        parallel_chunks(mesh.elements[static_cast<std::size_t>(t)].size(), kPlaceChunk, threads,
                        [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t i = begin; i < end; ++i) {
                                if (gone.element[static_cast<std::size_t>(t)][i] != 0) continue;
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
