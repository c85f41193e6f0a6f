// Whether two skins of the boundary have come to cross.
//
// Elements on both sides of a wall keep its two sides apart: they stay positive. Across a gap there are none,
// so nothing local tells when a facet is moved through one on the gap's other side.
#include <algorithm>

#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

struct Facet {
    std::array<std::uint32_t, 3> node;
    Point low;
    Point high;
    Point normal;  ///< outward

    bool operator<(const Facet& other) const { return low[0] < other.low[0]; }
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

/// Whether an edge of `a` passes through the inside of `b`.
bool stabs(const std::vector<Point>& points, const Facet& a, const Facet& b) {
    const Point& x = points[b.node[0]];
    const Point& y = points[b.node[1]];
    const Point& z = points[b.node[2]];
    double side[3];
    for (std::size_t k = 0; k < 3; ++k) side[k] = volume(x, y, z, points[a.node[k]]);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        if (!(side[k] * side[next] < 0)) continue;
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

template <class Use>
std::size_t count_crossings(const std::vector<Tetrahedron>& tetrahedra, const std::vector<Point>& points,
                            const Use& used) {
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
    std::sort(facets.begin(), facets.end());
    std::size_t count = 0;
    for (std::size_t i = 0; i < facets.size(); ++i) {
        for (std::size_t j = i + 1; j < facets.size() && facets[j].low[0] <= facets[i].high[0]; ++j) {
            if (!may_cross(facets[i], facets[j])) continue;
            if (stabs(points, facets[i], facets[j]) || stabs(points, facets[j], facets[i])) ++count;
        }
    }
    return count;
}

}  // namespace

bool Block::has_crossed() const {
    const std::size_t after =
        count_crossings(tetrahedra_, points_, [&](std::size_t i) { return alive_[i] != 0; });
    if (after == 0) return false;
    return after > count_crossings(original_, original_points_, [](std::size_t) { return true; });
}

}  // namespace mortise::improve
