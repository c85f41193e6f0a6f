// See facet_grid.hpp.
#include "host/report/facet_grid.hpp"

#include <algorithm>
#include <cmath>

namespace mortise::report {
namespace {

constexpr int kFinestLevel = 7;  // 2 million cells

double segment_distance(const Vector& p, const Vector& a, const Vector& b) {
    const Vector along = b - a;
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
    return length(p - (a + t * along));
}

double& component(Vector& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

double triangle_distance(const Vector& p, const Vector& a, const Vector& b, const Vector& c) {
    const Vector normal = cross(b - a, c - a);
    const double square = dot(normal, normal);
    // Over the triangle: on the inner side of its three edges.
    if (square > 0 && dot(cross(b - a, p - a), normal) >= 0 && dot(cross(c - b, p - b), normal) >= 0 &&
        dot(cross(a - c, p - c), normal) >= 0) {
        return std::fabs(dot(p - a, normal)) / std::sqrt(square);
    }
    return std::min({segment_distance(p, a, b), segment_distance(p, b, c), segment_distance(p, c, a)});
}

FacetGrid::FacetGrid(const Mesh& mesh, const tape::BoundModel& model, int level)
    : cells_(1 << std::clamp(level, 0, kFinestLevel)) {
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const NodeId* n = mesh.facets.nodes.data() + 4 * f;
        Vector p[4];
        for (int k = 0; k < 4; ++k) p[k] = features::to_local(model, features::point_of(mesh, n[k]));
        if (n[2] == n[3]) {
            triangles_.push_back({p[0], p[1], p[2]});
            continue;
        }
        const Vector mean = 0.25 * (p[0] + p[1] + p[2] + p[3]);
        for (int k = 0; k < 4; ++k) triangles_.push_back({p[k], p[(k + 1) % 4], mean});
    }
    const auto count = static_cast<std::size_t>(cells_);
    first_.assign(count * count * count + 1, 0);
    for (const Triangle& t : triangles_)
        for_cells(range_of(t), [&](std::size_t cell) { ++first_[cell + 1]; });
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    listing_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        for_cells(range_of(triangles_[i]),
                  [&](std::size_t cell) { listing_[next[cell]++] = static_cast<std::uint32_t>(i); });
    }
}

int FacetGrid::cell_of(double x) const {
    const double cell = x * cells_;
    return cell > 0 ? static_cast<int>(std::min(cell, static_cast<double>(cells_ - 1))) : 0;
}

FacetGrid::Range FacetGrid::range_of(const Triangle& triangle) const {
    Range range{};
    for (int j = 0; j < 3; ++j) {
        Vector a = triangle.a, b = triangle.b, c = triangle.c;
        const double x = component(a, j), y = component(b, j), z = component(c, j);
        range.low[j] = cell_of(std::min({x, y, z}));
        range.high[j] = cell_of(std::max({x, y, z}));
    }
    return range;
}

template <class Visit>
void FacetGrid::for_cells(const Range& range, const Visit& visit) const {
    const auto stride = static_cast<std::size_t>(cells_);
    for (int z = range.low[2]; z <= range.high[2]; ++z) {
        for (int y = range.low[1]; y <= range.high[1]; ++y) {
            const std::size_t row =
                (static_cast<std::size_t>(z) * stride + static_cast<std::size_t>(y)) * stride;
            for (int x = range.low[0]; x <= range.high[0]; ++x) visit(row + static_cast<std::size_t>(x));
        }
    }
}

double FacetGrid::distance(const Vector& local) const {
    const int centre[3] = {cell_of(local.x), cell_of(local.y), cell_of(local.z)};
    double best = HUGE_VAL;
    // Shells of cells about the point's own: beyond shell r, everything is at least r cells away.
    for (int r = 0; r < cells_; ++r) {
        if (best * cells_ <= r - 1) break;
        Range range{};
        for (int j = 0; j < 3; ++j) {
            range.low[j] = std::max(centre[j] - r, 0);
            range.high[j] = std::min(centre[j] + r, cells_ - 1);
        }
        for (int z = range.low[2]; z <= range.high[2]; ++z) {
            for (int y = range.low[1]; y <= range.high[1]; ++y) {
                const bool shell = std::abs(z - centre[2]) == r || std::abs(y - centre[1]) == r;
                for (int x = range.low[0]; x <= range.high[0]; ++x) {
                    if (!shell && std::abs(x - centre[0]) != r) continue;
                    const std::size_t side = static_cast<std::size_t>(cells_);
                    const std::size_t cell =
                        (static_cast<std::size_t>(z) * side + static_cast<std::size_t>(y)) * side +
                        static_cast<std::size_t>(x);
                    for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
                        const Triangle& t = triangles_[listing_[i]];
                        best = std::min(best, triangle_distance(local, t.a, t.b, t.c));
                    }
                }
            }
        }
    }
    return best;
}

}  // namespace mortise::report
