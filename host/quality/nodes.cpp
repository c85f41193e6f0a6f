// Nodes: finite coordinates, every node used, no two in the same place.
//
// Coincidence by grid hashing: cells of 16 tolerances; a node enters every cell that its neighbourhood of one
// tolerance touches (nearly always one), so two nodes closer than that share a cell. Entries are sorted by
// the hash of their cell, bucket by bucket; unequal cells with equal hashes only cost comparisons.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "host/common/parallel.hpp"
#include "host/quality/passes.hpp"
#include "host/quality/vector.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kPlaceChunk = 65536;
constexpr double kRelativeTolerance = 1e-12;
constexpr double kCellTolerances = 16;
constexpr std::size_t kBuckets = 1024;

bool is_finite(const Vector& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

struct Grid {
    Vector origin;
    double tolerance = 0;
    double cell = 1;

    std::int64_t index(double offset) const {
        // Coordinates so large that their difference overflows end in the last cell.
        const double quotient = std::floor(offset / cell);
        return quotient < 1e15 ? static_cast<std::int64_t>(quotient) : std::int64_t{1000000000000000};
    }
};

Grid make_grid(const Mesh& mesh) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Vector low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
    for (std::size_t i = 0; i < mesh.node_count(); ++i) {
        const Vector p = point_of(mesh, static_cast<NodeId>(i));
        if (!is_finite(p)) continue;
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    Grid grid;
    if (!(low.x <= high.x)) return grid;
    const double diagonal = std::hypot(high.x - low.x, high.y - low.y, high.z - low.z);
    grid.tolerance = std::min(kRelativeTolerance * diagonal, std::numeric_limits<double>::max() / 64);
    if (grid.tolerance > 0) grid.cell = kCellTolerances * grid.tolerance;
    // Half a cell and one tolerance below the lowest point: a regular mesh does not sit on cell faces.
    grid.origin = low - Vector{0.53 * grid.cell, 0.53 * grid.cell, 0.53 * grid.cell};
    return grid;
}

std::uint64_t mix(std::uint64_t value) {
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

struct NodePlace {
    std::uint64_t hash;
    NodeId node;
};

/// Calls visit(hash) for every cell that the neighbourhood of a point touches.
template <class Visit>
void visit_cells(const Grid& grid, const Vector& p, const Visit& visit) {
    const Vector offset = p - grid.origin;
    std::int64_t range[3][2];
    const double offsets[3] = {offset.x, offset.y, offset.z};
    for (int axis = 0; axis < 3; ++axis) {
        range[axis][0] = grid.index(offsets[axis] - grid.tolerance);
        range[axis][1] = grid.index(offsets[axis] + grid.tolerance);
    }
    for (std::int64_t i = range[0][0]; i <= range[0][1]; ++i) {
        for (std::int64_t j = range[1][0]; j <= range[1][1]; ++j) {
            for (std::int64_t k = range[2][0]; k <= range[2][1]; ++k) {
                visit(mix(static_cast<std::uint64_t>(i) +
                          mix(static_cast<std::uint64_t>(j) + mix(static_cast<std::uint64_t>(k)))));
            }
        }
    }
}

std::size_t bucket_of(std::uint64_t hash) { return hash % kBuckets; }

/// Entries of all finite nodes, grouped by bucket; `starts` gets kBuckets + 1 offsets.
std::vector<NodePlace> make_entries(const Mesh& mesh, const Grid& grid, int threads,
                                    std::vector<std::size_t>& starts) {
    std::vector<std::atomic<std::size_t>> cursors(kBuckets);
    const auto visit_all = [&](const auto& visit) {
        parallel_chunks(
            mesh.node_count(), kPlaceChunk, threads, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    const Vector p = point_of(mesh, static_cast<NodeId>(i));
                    if (!is_finite(p)) continue;
                    visit_cells(grid, p, [&](std::uint64_t hash) { visit(hash, static_cast<NodeId>(i)); });
                }
            });
    };
    visit_all([&](std::uint64_t hash, NodeId) {
        cursors[bucket_of(hash)].fetch_add(1, std::memory_order_relaxed);
    });
    starts.assign(kBuckets + 1, 0);
    for (std::size_t b = 0; b < kBuckets; ++b) {
        starts[b + 1] = starts[b] + cursors[b];
        cursors[b] = starts[b];
    }
    std::vector<NodePlace> entries(starts[kBuckets]);
    visit_all([&](std::uint64_t hash, NodeId node) {
        entries[cursors[bucket_of(hash)].fetch_add(1, std::memory_order_relaxed)] = {hash, node};
    });
    return entries;
}

struct Coincidence {
    NodeId node;
    NodeId earlier;
};

/// All nodes of one bucket that have an earlier node within the tolerance, each with one such node.
void find_in_bucket(const Mesh& mesh, double tolerance, NodePlace* begin, NodePlace* end,
                    std::vector<Coincidence>& found) {
    std::sort(begin, end, [](const NodePlace& a, const NodePlace& b) {
        return a.hash != b.hash ? a.hash < b.hash : a.node < b.node;
    });
    for (NodePlace* entry = begin; entry != end; ++entry) {
        const Vector p = point_of(mesh, entry->node);
        for (NodePlace* other = entry; other != begin && (other - 1)->hash == entry->hash;) {
            --other;
            if (other->node == entry->node) continue;  // two of its own cells with one hash
            const Vector q = point_of(mesh, other->node);
            if (std::hypot(p.x - q.x, p.y - q.y, p.z - q.z) > tolerance) continue;
            found.push_back({entry->node, other->node});
            break;
        }
    }
}

void check_coincident(const Mesh& mesh, int threads, DefectLog& log) {
    const Grid grid = make_grid(mesh);
    std::vector<std::size_t> starts;
    std::vector<NodePlace> entries = make_entries(mesh, grid, threads, starts);
    std::vector<std::vector<Coincidence>> found(kBuckets);
    parallel_chunks(kBuckets, 1, threads, [&](std::size_t bucket, std::size_t, int) {
        find_in_bucket(mesh, grid.tolerance, entries.data() + starts[bucket],
                       entries.data() + starts[bucket + 1], found[bucket]);
    });
    std::vector<Coincidence> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    std::sort(all.begin(), all.end(), [](const Coincidence& a, const Coincidence& b) {
        return a.node != b.node ? a.node < b.node : a.earlier < b.earlier;
    });
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i > 0 && all[i].node == all[i - 1].node) continue;  // seen in two cells
        log.add(DefectKind::kNodeCoincident, [&] {
            return "nodes " + std::to_string(all[i].earlier) + " and " + std::to_string(all[i].node) +
                   " at " + point_text(mesh, all[i].node);
        });
    }
}

}  // namespace

void check_nodes(const Mesh& mesh, int threads, DefectLog& log) {
    std::unique_ptr<std::atomic<bool>[]> used(new std::atomic<bool>[mesh.node_count()]());
    for (const ElementBlock& block : mesh.elements) {
        for (const std::vector<NodeId>* nodes : {&block.nodes, &block.middles}) {
            parallel_chunks(nodes->size(), kPlaceChunk, threads,
                            [&](std::size_t begin, std::size_t end, int) {
                                for (std::size_t i = begin; i < end; ++i)
                                    used[(*nodes)[i]].store(true, std::memory_order_relaxed);
                            });
        }
    }
    for (std::size_t i = 0; i < mesh.node_count(); ++i) {
        const NodeId node = static_cast<NodeId>(i);
        const auto describe = [&] { return "node " + std::to_string(i) + " at " + point_text(mesh, node); };
        if (!used[i]) log.add(DefectKind::kNodeUnused, describe);
        if (!is_finite(point_of(mesh, node))) log.add(DefectKind::kNodeNotFinite, describe);
    }
    check_coincident(mesh, threads, log);
}

}  // namespace mortise::quality
