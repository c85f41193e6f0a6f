#include "host/reposition/near_cubes.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "kernels/shared/lattice.h"

namespace mortise::reposition {
namespace {

constexpr std::size_t kRowsPerChunk = 256;

std::uint64_t brick(std::int64_t x, std::int64_t y, std::int64_t z, int levels) {
    return morton_encode(static_cast<u32>(x), static_cast<u32>(y), static_cast<u32>(z)) >> (3 * levels);
}

}  // namespace

NearCubes::NearCubes(const Mesh& mesh, const Frame& frame, const IndexSet& nodes, const Options& options)
    : mesh_(mesh), frame_(frame) {
    if (!options.is_uniform()) return;
    find_bricks(nodes);
    is_near_.resize(chunk_count(mesh.elements[0].size(), kRow));
    parallel_chunks(is_near_.size(), kRowsPerChunk, options.threads,
                    [&](std::size_t begin, std::size_t end, int) { mark_rows(begin, end); });
}

/// Looks at many rows at once: what is far is far as a whole, mostly.
void NearCubes::mark_rows(std::size_t begin, std::size_t end) {
    if (!are_near(begin * kRow, std::min(mesh_.elements[0].size(), end * kRow))) return;
    if (end - begin == 1) {
        is_near_[begin] = 1;
        return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    mark_rows(begin, middle);
    mark_rows(middle, end);
}

bool NearCubes::is_cube(std::size_t hexahedron) const {
    return mesh_.elements[0].kind[hexahedron] == static_cast<std::uint8_t>(ElementKind::kIn);
}

/// The cell that holds a node, moved by `offset` cells along each axis; cells of the grid only.
std::array<std::int64_t, 3> NearCubes::cell_at(NodeId node, double offset) const {
    const std::int64_t last = (std::int64_t{1} << frame_.level) - 1;
    double local[3];
    frame_.to_lattice(mesh_, node, local);
    std::array<std::int64_t, 3> cell{};
    for (std::size_t j = 0; j < 3; ++j) {
        const double place = std::floor(local[j] / frame_.scale.cell + offset);
        cell[j] = std::clamp(static_cast<std::int64_t>(place), std::int64_t{0}, last);
    }
    return cell;
}

std::uint64_t NearCubes::brick_of(std::size_t hexahedron) const {
    const auto cell = cell_at(mesh_.elements[0].nodes[8 * hexahedron], 0.5);
    return brick(cell[0], cell[1], cell[2], kBrickLevels);
}

void NearCubes::find_bricks(const IndexSet& nodes) {
    constexpr std::int64_t kEdge = std::int64_t{1} << kBrickLevels;
    for (const NodeId node : nodes.members()) {
        const auto low = cell_at(node, -1), high = cell_at(node, 1);
        for (std::int64_t z = low[2] / kEdge; z <= high[2] / kEdge; ++z) {
            for (std::int64_t y = low[1] / kEdge; y <= high[1] / kEdge; ++y) {
                for (std::int64_t x = low[0] / kEdge; x <= high[0] / kEdge; ++x)
                    bricks_.push_back(brick(x, y, z, 0));
            }
        }
    }
    sort_unique(bricks_);
}

bool NearCubes::are_near(std::size_t begin, std::size_t end) const {
    while (begin < end && !is_cube(begin)) ++begin;
    while (begin < end && !is_cube(end - 1)) --end;
    if (begin == end) return false;
    const auto next = std::lower_bound(bricks_.begin(), bricks_.end(), brick_of(begin));
    return next != bricks_.end() && *next <= brick_of(end - 1);
}

}  // namespace mortise::reposition
