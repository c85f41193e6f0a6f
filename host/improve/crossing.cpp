// Whether two skins of the boundary have come to cross.
//
// Elements on both sides of a wall keep its two sides apart: they stay positive. Across a gap there are none,
// so nothing local tells when a facet is moved through one on the gap's other side.
#include <algorithm>
#include <cmath>

#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

/// Facets that touch do not cross: edges of the finest leaves.
constexpr double kCrossingDepth = 1e-5;

constexpr std::size_t kMostTetrahedra = 1 << 15;

struct Facet {
    std::array<std::uint32_t, 3> node;
    Point low;
    Point high;
    Point normal;  ///< outward
};

double volume(const Point& a, const Point& b, const Point& c, const Point& d) {
    return dot(cross(b - a, c - a), d - a);
}

bool has_common_node(const Facet& a, const Facet& b) {
    for (const std::uint32_t n : a.node) {
        if (n == b.node[0] || n == b.node[1] || n == b.node[2]) return true;
    }
    return false;
}

/// Whether an edge of `a` passes through the inside of `b`, from one side of it to the other by more than
/// `depth`.
bool stabs(const std::vector<Point>& points, const Facet& a, const Facet& b, double depth) {
    const Point& x = points[b.node[0]];
    const Point& y = points[b.node[1]];
    const Point& z = points[b.node[2]];
    const double least = depth * length(b.normal);
    double side[3];
    for (std::size_t k = 0; k < 3; ++k) side[k] = volume(x, y, z, points[a.node[k]]);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        if (!(std::min(side[k], side[next]) < -least && std::max(side[k], side[next]) > least)) continue;
        const Point& p = points[a.node[k]];
        const Point& q = points[a.node[next]];
        const double u = volume(p, q, x, y);
        const double v = volume(p, q, y, z);
        const double w = volume(p, q, z, x);
        if ((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)) return true;
    }
    return false;
}

bool may_cross(const Facet& a, const Facet& b) {
    for (std::size_t j = 0; j < 3; ++j) {
        if (a.low[j] > b.high[j] || b.low[j] > a.high[j]) return false;
    }
    // The sides of a gap look at each other.
    return dot(a.normal, b.normal) < 0 && !has_common_node(a, b);
}

/// Facets by columns along x; a facet may be in several.
std::vector<std::vector<std::uint32_t>> columns_of(const std::vector<Facet>& facets) {
    constexpr double kPerColumn = 16;
    constexpr double kMost = 64;  // along y, and along z
    if (facets.empty()) return {};
    double low[2] = {facets[0].low[1], facets[0].low[2]};
    double high[2] = {facets[0].high[1], facets[0].high[2]};
    for (const Facet& f : facets) {
        for (std::size_t j = 0; j < 2; ++j) {
            low[j] = std::min(low[j], f.low[j + 1]);
            high[j] = std::max(high[j], f.high[j + 1]);
        }
    }
    const double count = std::clamp(std::sqrt(static_cast<double>(facets.size()) / kPerColumn), 1.0, kMost);
    const auto columns = static_cast<std::size_t>(count);
    std::vector<std::vector<std::uint32_t>> result(columns * columns);
    const auto place = [&](double x, std::size_t j) {
        const double width = std::max(high[j] - low[j], 1e-300);
        return std::min(columns - 1,
                        static_cast<std::size_t>((x - low[j]) / width * static_cast<double>(columns)));
    };
    for (std::uint32_t i = 0; i < facets.size(); ++i) {
        const Facet& f = facets[i];
        for (std::size_t y = place(f.low[1], 0); y <= place(f.high[1], 0); ++y) {
            for (std::size_t z = place(f.low[2], 1); z <= place(f.high[2], 1); ++z)
                result[y * columns + z].push_back(i);
        }
    }
    return result;
}

/// Pairs of facets that cross; those in several columns count more than once.
template <class Use>
std::size_t count_crossings(const std::vector<Tetrahedron>& tetrahedra, const std::vector<Point>& points,
                            double depth, const Use& used) {
    std::vector<Facet> facets;
    for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
        const Tetrahedron& t = tetrahedra[i];
        if (!used(i)) continue;
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || (t.tag[f] & kTagInterface) != 0) continue;
            Facet facet;
            for (std::size_t k = 0; k < 3; ++k) facet.node[k] = t.node[kOpposite[f][k]];
            const Point& a = points[facet.node[0]];
            const Point& b = points[facet.node[1]];
            const Point& c = points[facet.node[2]];
            for (std::size_t j = 0; j < 3; ++j) {
                facet.low[j] = std::min({a[j], b[j], c[j]});
                facet.high[j] = std::max({a[j], b[j], c[j]});
            }
            facet.normal = cross(b - a, c - a);
            facets.push_back(facet);
        }
    }
    std::size_t count = 0;
    for (std::vector<std::uint32_t>& column : columns_of(facets)) {
        std::sort(column.begin(), column.end(), [&](std::uint32_t i, std::uint32_t j) {
            return facets[i].low[0] != facets[j].low[0] ? facets[i].low[0] < facets[j].low[0] : i < j;
        });
        for (std::size_t i = 0; i < column.size(); ++i) {
            const Facet& f = facets[column[i]];
            for (std::size_t j = i + 1; j < column.size() && facets[column[j]].low[0] <= f.high[0]; ++j) {
                const Facet& g = facets[column[j]];
                if (may_cross(f, g) && (stabs(points, f, g, depth) || stabs(points, g, f, depth))) ++count;
            }
        }
    }
    return count;
}

}  // namespace

/// Blocks crowded with features far below the cell size are not looked at: their skins cross wherever they
/// are simplified, and unsimplified they are ten times as many elements.
bool Block::has_crossed() const {
    if (original_.size() > kMostTetrahedra) return false;
    const double depth = kCrossingDepth * unit_;
    const std::size_t after =
        count_crossings(tetrahedra_, points_, depth, [&](std::size_t i) { return alive_[i] != 0; });
    if (after == 0) return false;
    return after > count_crossings(original_, original_points_, depth, [](std::size_t) { return true; });
}

}  // namespace mortise::improve
