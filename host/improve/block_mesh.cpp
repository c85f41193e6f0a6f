#include "host/improve/block_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/sort_unique.hpp"

namespace mortise::improve {
bool BlockMesh::is_inside(const std::array<Local, 4>& node) const {
    return std::all_of(node.begin(), node.end(), [this](Local n) { return free_[n] != 0; });
}

double BlockMesh::quality(const std::array<Local, 4>& n) const {
    ++evaluated_;
    return tetrahedron_quality(points_[n[0]], points_[n[1]], points_[n[2]], points_[n[3]], rounding_);
}

std::array<Point, 5> BlockMesh::corners(const std::array<Local, 5>& n) const {
    return {points_[n[0]], points_[n[1]], points_[n[2]], points_[n[3]], points_[n[4]]};
}

std::size_t BlockMesh::count_alive() const {
    return static_cast<std::size_t>(std::count(alive_.begin(), alive_.end(), 1));
}

std::size_t BlockMesh::count_below(double quality) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i)
        count += alive_[i] != 0 && tetrahedra_[i].quality < quality ? 1 : 0;
    return count;
}

std::uint32_t BlockMesh::across(std::uint32_t tetrahedron, std::size_t face) const {
    const auto& node = tetrahedra_[tetrahedron].node;
    const Local a = node[kOpposite[face][0]];
    const Local b = node[kOpposite[face][1]];
    const Local c = node[kOpposite[face][2]];
    const Local least = star_[a].size() <= star_[b].size() ? (star_[a].size() <= star_[c].size() ? a : c)
                                                           : (star_[b].size() <= star_[c].size() ? b : c);
    for (const std::uint32_t i : star_[least]) {
        if (i != tetrahedron && has(tetrahedra_[i].node, a) && has(tetrahedra_[i].node, b) &&
            has(tetrahedra_[i].node, c))
            return i;
    }
    return kNone;
}

FaceTag BlockMesh::tag_of(std::uint32_t tetrahedron, Local a, Local b, Local c) const {
    const Tetrahedron& t = tetrahedra_[tetrahedron];
    for (std::size_t f = 0; f < 4; ++f) {
        if (t.node[f] != a && t.node[f] != b && t.node[f] != c) return t.tag[f];
    }
    return 0;
}

bool BlockMesh::gather_ring(Local a, Local b, std::size_t longest, Ring& ring) const {
    ring.tetrahedra.clear();
    ring.nodes.clear();
    // Positive (a, b, c, d): the ring runs from c to d, counter-clockwise seen from b.
    std::array<std::array<Local, 3>, 16> link{};
    std::size_t count = 0;
    const bool around_a = star_[a].size() <= star_[b].size();
    const Local other = around_a ? b : a;
    for (const std::uint32_t i : star_[around_a ? a : b]) {
        const auto& n = tetrahedra_[i].node;
        if (!has(n, other)) continue;
        if (count == longest) return false;
        const auto ia = static_cast<std::size_t>(std::find(n.begin(), n.end(), a) - n.begin());
        // Nodes of the face opposite a, inward: (a, x, y, z) is positive.
        Local x = n[kOpposite[ia][0]];
        Local y = n[kOpposite[ia][1]];
        Local z = n[kOpposite[ia][2]];
        while (x != b) {
            const Local first = x;
            x = y;
            y = z;
            z = first;
        }
        link[count++] = {y, z, i};
    }
    if (count == 0) return false;
    std::size_t start = 0;
    ring.closed = true;
    for (std::size_t k = 0; k < count; ++k) {
        bool preceded = false;
        for (std::size_t j = 0; j < count; ++j) preceded = preceded || link[j][1] == link[k][0];
        if (preceded) continue;
        if (!ring.closed) return false;  // two gaps around the edge
        ring.closed = false;
        start = k;
    }
    std::size_t at = start;
    ring.nodes.push_back(link[at][0]);
    while (true) {
        ring.tetrahedra.push_back(link[at][2]);
        const Local end = link[at][1];
        if (ring.closed && end == ring.nodes[0]) break;
        ring.nodes.push_back(end);
        std::size_t next = count;
        for (std::size_t k = 0; k < count; ++k) {
            if (link[k][0] == end) next = k;
        }
        if (next == count) break;
        at = next;
        if (ring.tetrahedra.size() == count) return false;
    }
    return ring.tetrahedra.size() == count;
}

/// Nodes at the other ends of a node's edges, ascending.
std::vector<BlockMesh::Local> BlockMesh::neighbours(Local node) const {
    std::vector<Local> result;
    for (const std::uint32_t i : star_[node]) {
        for (const Local n : tetrahedra_[i].node) {
            if (n != node) result.push_back(n);
        }
    }
    sort_unique(result);
    return result;
}

bool BlockMesh::share_tetrahedron(Local a, Local b) const {
    const auto& star = star_[a];
    return std::any_of(star.begin(), star.end(), [&](std::uint32_t i) {
        const auto& n = tetrahedra_[i].node;
        return std::find(n.begin(), n.end(), b) != n.end();
    });
}

double BlockMesh::star_quality(Local node, double enough) const {
    double worst = 2;
    for (const std::uint32_t i : star_[node]) {
        worst = std::min(worst, quality(tetrahedra_[i].node));
        if (!(worst > enough)) return worst;
    }
    for (const std::uint32_t i : pyramid_star_[node]) {
        worst = std::min(worst, pyramid_quality(corners(pyramids_[i])));
        if (!(worst > enough)) return worst;
    }
    return worst;
}

/// The same, all of it, where no node has moved since the tetrahedra were last evaluated.
double BlockMesh::known_star_quality(Local node) const {
    double worst = 2;
    for (const std::uint32_t i : star_[node]) worst = std::min(worst, tetrahedra_[i].quality);
    for (const std::uint32_t i : pyramid_star_[node])
        worst = std::min(worst, pyramid_quality(corners(pyramids_[i])));
    return worst;
}

BlockMesh::Fit BlockMesh::fit(std::uint32_t surface, const Point& a, const Point& b, const Point& c) const {
    const Point normal = cross(b - a, c - a);
    const Surfaces::Sample s = surfaces_->sample(surface, (1.0 / 3) * (a + b + c));
    if (!s.valid) return {};
    const double slope = length(s.gradient);
    const double product = length(normal) * slope;
    return {product > 0 ? dot(normal, s.gradient) / product : 0, std::fabs(s.value) / slope};
}

/// Smallest cosine between the node's facets on curved surfaces and those surfaces, whichever way both point,
/// and the largest distance.
BlockMesh::Fit BlockMesh::worst_fit(Local node) const {
    Fit worst = {1, 0};
    for (const std::uint32_t i : star_[node]) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || t.node[f] == node || is_plane(tag_surface(t.tag[f]))) continue;
            const auto& o = kOpposite[f];
            const Fit here = fit(tag_surface(t.tag[f]), points_[t.node[o[0]]], points_[t.node[o[1]]],
                                 points_[t.node[o[2]]]);
            worst.alignment = std::min(worst.alignment, std::fabs(here.alignment));
            worst.sag = std::max(worst.sag, here.sag);
        }
    }
    return worst;
}

/// How far the middle of a facet of the element is from its curved surface, in edges of the smallest leaf.
double BlockMesh::worst_sag(std::uint32_t tetrahedron) const {
    const Tetrahedron& t = tetrahedra_[tetrahedron];
    double worst = 0;
    for (std::size_t f = 0; f < 4; ++f) {
        if (t.tag[f] == 0 || is_plane(tag_surface(t.tag[f]))) continue;
        const auto& o = kOpposite[f];
        const Local n[3] = {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
        const Surfaces::Sample s = surfaces_->sample(
            tag_surface(t.tag[f]), (1.0 / 3) * (points_[n[0]] + points_[n[1]] + points_[n[2]]));
        if (!s.valid) continue;
        const double size = std::min({size_[n[0]], size_[n[1]], size_[n[2]]});
        worst = std::max(worst, std::fabs(s.value) / (length(s.gradient) * size));
    }
    return worst;
}

/// Whether the edge runs along everything that `gone` lies on.
bool BlockMesh::edge_is_on_stratum(Local gone, Local kept) const {
    const std::vector<std::uint32_t>& on = strata_[gone];
    if (on.empty()) return true;
    if (on.size() > kMostSurfaces) return false;
    if (!std::includes(strata_[kept].begin(), strata_[kept].end(), on.begin(), on.end())) return false;
    std::uint32_t seen[kMostSurfaces] = {};
    for (const std::uint32_t i : star_[gone]) {
        const Tetrahedron& t = tetrahedra_[i];
        if (!has(t.node, kept)) continue;
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || t.node[f] == gone || t.node[f] == kept) continue;
            const std::uint32_t surface = tag_surface(t.tag[f]);
            for (std::size_t k = 0; k < on.size(); ++k) seen[k] += surface == on[k] ? 1u : 0u;
            if (std::find(on.begin(), on.end(), surface) == on.end()) return false;
        }
    }
    return std::all_of(seen, seen + on.size(), [](std::uint32_t count) { return count > 0; });
}

/// Places of the nodes next to one on a crease.
std::vector<Point> BlockMesh::crease_neighbours(Local node) const {
    std::vector<Point> found;
    for (const std::uint32_t i : star_[node]) {
        for (const Local n : tetrahedra_[i].node) {
            if (n != node && strata_[n].size() > 1 && edge_is_on_stratum(node, n))
                found.push_back(points_[n]);
        }
    }
    return found;
}

}  // namespace mortise::improve
