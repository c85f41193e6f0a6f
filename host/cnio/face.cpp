// Meshes of cell faces: whole (F0), cut by one chord (F1), or a fan bisected by each surface in turn (F2).
#include <algorithm>

#include "host/cnio/cell.hpp"
#include "host/tape/reference.hpp"

namespace mortise::cnio {
namespace {

// A face that holds too many surfaces stays as it is then, from both sides.
constexpr std::size_t kMostWork = 1u << 14;  ///< triangles times surfaces
constexpr std::size_t kFewestTriangles = 64;

/// Smallest height of a triangle over its longest side, squared and relative: a measure of shape.
double shape(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    return twice_area(a, b, c) / (longest * longest);
}

}  // namespace

void Cell::partition_face(int f) {
    faces_[f].clear();
    std::vector<LocalNode> loop;
    for (int i = 0; i < 4; ++i) {
        loop.push_back(kFaceCorners[f][i]);
        const auto& inner = edge_nodes_[kFaceEdges[f][i]];
        // The loop runs along the first two edges and against the last two.
        if (i < 2)
            loop.insert(loop.end(), inner.begin(), inner.end());
        else
            loop.insert(loop.end(), inner.rbegin(), inner.rend());
    }
    modes_[f] = face_mode(loop, f);
    if (modes_[f] == FaceMode::kWhole) {
        faces_[f].push_back({{loop[0], loop[1], loop[2], loop[3]}, 4});
    } else if (modes_[f] == FaceMode::kCut) {
        cut_face(loop, f);
    } else {
        fan_face(loop, f);
    }
}

FaceMode Cell::face_mode(const std::vector<LocalNode>& loop, int f) {
    const std::size_t n = surfaces_.size();
    const std::size_t axis = static_cast<std::size_t>(f / 2);
    LatticePoint middle = {kCellUnits / 2, kCellUnits / 2, kCellUnits / 2};
    middle[axis] = (f & 1) * kCellUnits;
    int d[3] = {0, 0, 0};
    d[axis] = (f & 1) != 0 ? 1 : -1;
    const std::uint8_t* active =
        neighbour_active_.data() + static_cast<std::size_t>((d[0] + 1) + 3 * (d[1] + 1) + 9 * (d[2] + 1)) * n;
    std::size_t crossing = n;
    for (std::size_t s = 0; s < n; ++s) {
        if (active[s] == 0) continue;
        bool negative = false;
        bool positive = false;
        for (const LocalNode node : loop) {
            negative = negative || sign(node, s) < 0;
            positive = positive || sign(node, s) > 0;
        }
        if (negative && positive) {
            if (crossing != n) return FaceMode::kFan;
            crossing = s;
            continue;
        }
        const int at_middle = pure_sign(s, middle);
        if ((negative && at_middle > 0) || (positive && at_middle < 0)) return FaceMode::kFan;
    }
    if (crossing == n) return loop.size() == 4 ? FaceMode::kWhole : FaceMode::kFan;
    crossing_ = crossing;
    // One surface: two zero nodes that part the loop into one negative and one positive run.
    int zeros = 0;
    int changes = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const int here = sign(loop[i], crossing);
        const int next = sign(loop[(i + 1) % loop.size()], crossing);
        if (here * next < 0) return FaceMode::kFan;
        if (here == 0) {
            ++zeros;
            const int before = sign(loop[(i + loop.size() - 1) % loop.size()], crossing);
            if (before * next < 0) ++changes;
        } else if (nodes_[loop[i]].code >= 8) {
            return FaceMode::kFan;  // an edge node of another surface
        }
    }
    return zeros == 2 && changes == 2 ? FaceMode::kCut : FaceMode::kFan;
}

void Cell::cut_face(const std::vector<LocalNode>& loop, int f) {
    std::vector<std::size_t> ends;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        if (sign(loop[i], crossing_) == 0) ends.push_back(i);
    }
    for (int side = 0; side < 2; ++side) {
        std::vector<LocalNode> polygon;
        const std::size_t from = ends[static_cast<std::size_t>(side)];
        const std::size_t to = ends[static_cast<std::size_t>(1 - side)];
        for (std::size_t i = from;; i = (i + 1) % loop.size()) {
            polygon.push_back(loop[i]);
            if (i == to) break;
        }
        add_polygon(polygon, f);
    }
}

void Cell::add_polygon(const std::vector<LocalNode>& polygon, int f) {
    auto& facets = faces_[f];
    const auto point = [&](std::size_t i) -> const LatticePoint& { return nodes_[polygon[i]].point; };
    if (polygon.size() == 3) {
        facets.push_back({{polygon[0], polygon[1], polygon[2], polygon[2]}, 3});
        return;
    }
    if (polygon.size() == 4) {
        // Two corners and two cuts stay a quadrilateral; with a corner on the surface the better diagonal
        // splits it.
        if (nodes_[polygon[0]].code >= 8 && nodes_[polygon[3]].code >= 8) {
            facets.push_back({{polygon[0], polygon[1], polygon[2], polygon[3]}, 4});
            return;
        }
        const double first =
            std::min(shape(point(0), point(1), point(2)), shape(point(0), point(2), point(3)));
        const double second =
            std::min(shape(point(0), point(1), point(3)), shape(point(1), point(2), point(3)));
        // Ties go to the diagonal through the first corner of the face's loop, whichever way the polygon
        // starts.
        const LocalNode lowest = *std::min_element(polygon.begin(), polygon.end());
        const bool through_first =
            first != second ? first > second : (lowest == polygon[0] || lowest == polygon[2]);
        if (through_first) {
            facets.push_back({{polygon[0], polygon[1], polygon[2], polygon[2]}, 3});
            facets.push_back({{polygon[0], polygon[2], polygon[3], polygon[3]}, 3});
        } else {
            facets.push_back({{polygon[0], polygon[1], polygon[3], polygon[3]}, 3});
            facets.push_back({{polygon[1], polygon[2], polygon[3], polygon[3]}, 3});
        }
        return;
    }
    // Three corners between two cuts: a fan from the middle corner.
    for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
        if (i == 2 || i + 1 == 2) continue;
        facets.push_back({{polygon[2], polygon[i], polygon[i + 1], polygon[i + 1]}, 3});
    }
    facets.push_back({{polygon[2], polygon[4], polygon[0], polygon[0]}, 3});
}

void Cell::fan_face(const std::vector<LocalNode>& loop, int f) {
    const std::size_t n = surfaces_.size();
    const std::size_t axis = static_cast<std::size_t>(f / 2);
    LatticePoint middle = {kCellUnits / 2, kCellUnits / 2, kCellUnits / 2};
    middle[axis] = (f & 1) * kCellUnits;
    fan_nodes_ = loop;
    fan_nodes_.push_back(add_node(middle, static_cast<std::uint8_t>(1u << f)));
    fan_.clear();
    const auto centre = static_cast<std::uint16_t>(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
        fan_.push_back(
            {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>((i + 1) % loop.size()), centre});
    }
    int d[3] = {0, 0, 0};
    d[axis] = (f & 1) != 0 ? 1 : -1;
    const std::size_t neighbour = static_cast<std::size_t>((d[0] + 1) + 3 * (d[1] + 1) + 9 * (d[2] + 1));
    // A neighbour that shares an active surface is an NIO leaf.
    const bool shared =
        std::any_of(neighbour_active_.begin() + static_cast<std::ptrdiff_t>(neighbour * n),
                    neighbour_active_.begin() + static_cast<std::ptrdiff_t>((neighbour + 1) * n),
                    [](std::uint8_t active) { return active != 0; });
    if (shared) {
        load_other_tape(tree_.nio[tree_.nio_index(morton_encode(xyz_[0] + static_cast<u32>(d[0]),
                                                                xyz_[1] + static_cast<u32>(d[1]),
                                                                xyz_[2] + static_cast<u32>(d[2])))]);
    }
    bool again = true;
    for (int round = 0; round < kBisectionRounds && again; ++round) {
        again = false;
        for (std::size_t s = 0; s < n; ++s) {
            if (neighbour_active_[neighbour * n + s] != 0 && split_face(f, s, round)) again = true;
        }
    }
    for (const auto& t : fan_) {
        const LocalNode c = fan_nodes_[t[2]];
        faces_[f].push_back({{fan_nodes_[t[0]], fan_nodes_[t[1]], c, c}, 3});
    }
}

bool Cell::flat(LocalNode a, LocalNode b, LocalNode c) const {
    const LatticePoint& p = nodes_[a].point;
    const LatticePoint& q = nodes_[b].point;
    const LatticePoint& r = nodes_[c].point;
    const double longest = std::max({distance(p, q), distance(q, r), distance(r, p)});
    return twice_area(p, q, r) < longest * std::max(kMinHeight, kMinRelativeArea * longest);
}

/// Whether the certain signs of a triangle for the face's active surfaces tell its region, by the tape of
/// either cell: both cells ask both tapes, so they agree.
bool Cell::is_resolved(const std::array<std::uint16_t, 3>& triangle, const std::uint8_t* active) {
    const std::size_t n = surfaces_.size();
    triangle_signs_.assign(n, 0);
    for (std::size_t s = 0; s < n; ++s) {
        if (active[s] == 0) continue;
        bool negative = false;
        bool positive = false;
        for (const std::uint16_t i : triangle) {
            negative = negative || sign(fan_nodes_[i], s) < 0;
            positive = positive || sign(fan_nodes_[i], s) > 0;
        }
        triangle_signs_[s] =
            static_cast<std::int8_t>(static_cast<int>(positive) - static_cast<int>(negative));
    }
    if (local_tape_.resolve(triangle_signs_.data()) != kUnknown) return true;
    other_signs_.resize(other_surfaces_.size());
    for (std::size_t i = 0; i < other_surfaces_.size(); ++i) {
        other_signs_[i] = other_to_own_[i] < n ? triangle_signs_[other_to_own_[i]] : std::int8_t{0};
    }
    return other_tape_.resolve(other_signs_.data()) != kUnknown;
}

void Cell::load_other_tape(const TreeNode& other) {
    const std::uint32_t* words = tree_.tapes.data() + other.tape_offset;
    other_surfaces_.clear();
    for (std::uint32_t i = 0; i < other.tape_length; ++i) {
        if (tape_operation(words[i]) == kTapeLiteral) other_surfaces_.push_back(tape_surface(words[i]));
    }
    std::sort(other_surfaces_.begin(), other_surfaces_.end());
    other_surfaces_.erase(std::unique(other_surfaces_.begin(), other_surfaces_.end()), other_surfaces_.end());
    other_tape_.load(words, other.tape_length, other_surfaces_);
    other_to_own_.clear();
    for (const std::uint32_t surface : other_surfaces_) {
        const auto found = std::lower_bound(surfaces_.begin(), surfaces_.end(), surface);
        const bool own = found != surfaces_.end() && *found == surface;
        other_to_own_.push_back(own ? static_cast<std::size_t>(found - surfaces_.begin()) : surfaces_.size());
    }
}

/// Splits the face's mixed inner edges for surface p; tells whether there were any. Later rounds split only
/// what matters: beside an edge of the cell where several surfaces are not active, they would not end.
bool Cell::split_face(int f, std::size_t p, int round) {
    bool any = false;
    const std::uint8_t own = static_cast<std::uint8_t>(1u << f);
    int d[3] = {0, 0, 0};
    d[f / 2] = (f & 1) != 0 ? 1 : -1;
    const std::size_t n = surfaces_.size();
    const std::uint8_t* active =
        neighbour_active_.data() + static_cast<std::size_t>((d[0] + 1) + 3 * (d[1] + 1) + 9 * (d[2] + 1)) * n;
    // Of the face, not of the cell: both sides must stop at the same triangle.
    const auto on_face = static_cast<std::size_t>(std::count(active, active + n, std::uint8_t{1}));
    mixed_.clear();
    for (const auto& t : fan_) {
        const std::size_t before = mixed_.size();
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint16_t a = std::min(t[i], t[(i + 1) % 3]);
            const std::uint16_t b = std::max(t[i], t[(i + 1) % 3]);
            const bool interior = (nodes_[fan_nodes_[a]].faces & nodes_[fan_nodes_[b]].faces) == own;
            if (interior && sign(fan_nodes_[a], p) * sign(fan_nodes_[b], p) < 0) mixed_.push_back({a, b});
        }
        if (round > 0 && mixed_.size() > before && is_resolved(t, active)) mixed_.resize(before);
    }
    std::sort(mixed_.begin(), mixed_.end());
    mixed_.erase(std::unique(mixed_.begin(), mixed_.end()), mixed_.end());
    for (const auto& [a, b] : mixed_) {
        const LocalNode na = fan_nodes_[a];
        const LocalNode nb = fan_nodes_[b];
        if (sign(na, p) * sign(nb, p) >= 0) continue;  // an end was snapped
        if (fan_.size() >= std::max(kFewestTriangles, kMostWork / on_face)) {
            ++counters.refused;
            return false;
        }
        const LatticePoint at = root(p, na, nb);
        if (snap_end(p, na, nb, at, kMergeDistance, true)) {
            any = true;
            continue;
        }
        const LocalNode m = split_node(p, na, nb, at, round, active);
        const auto local = static_cast<std::uint16_t>(fan_nodes_.size());
        fan_nodes_.push_back(m);
        bool refused = false;
        const std::size_t count = fan_.size();
        for (std::size_t i = 0; i < count && !refused; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint16_t u = fan_[i][k];
                const std::uint16_t v = fan_[i][(k + 1) % 3];
                const std::uint16_t w = fan_[i][(k + 2) % 3];
                if ((u == a && v == b) || (u == b && v == a)) {
                    refused = refused || flat(fan_nodes_[u], m, fan_nodes_[w]) ||
                              flat(m, fan_nodes_[v], fan_nodes_[w]);
                }
            }
        }
        if (refused) {
            fan_nodes_.pop_back();
            remove_last_node();
            if (!snap_end(p, na, nb, at, kSnapDistance, true)) ++counters.refused;
            continue;
        }
        any = true;
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint16_t u = fan_[i][k];
                const std::uint16_t v = fan_[i][(k + 1) % 3];
                const std::uint16_t w = fan_[i][(k + 2) % 3];
                if (!((u == a && v == b) || (u == b && v == a))) continue;
                fan_[i] = {u, local, w};
                fan_.push_back({local, v, w});
                break;
            }
        }
    }
    return any;
}

}  // namespace mortise::cnio
