// Whether two skins of the boundary come to cross.
//
// Elements on both sides of a wall keep its two sides apart: they stay positive. Across a gap there are none,
// so nothing local tells when a facet is moved through one on the gap's other side, which may share a node
// with it. A block is looked through when it is done; if facets have come to cross, it is done again, and
// every change of facets there, or everywhere if it still happens, is held against those around it.
#include <algorithm>
#include <cmath>

#include "host/common/watch.hpp"
#include "host/improve/block.hpp"
#include "host/improve/crossing.hpp"

namespace mortise::improve {
namespace {

/// The grid is made anew when it has grown by this factor.
constexpr std::size_t kMostStale = 2;
constexpr std::size_t kMostCrossed = 32;  ///< places that are watched apart
constexpr double kAroundCrossed = 1;      ///< cells around facets that cross

}  // namespace

Triangle Block::triangle(const std::array<Local, 3>& node) const {
    return {points_[node[0]], points_[node[1]], points_[node[2]]};
}

bool Block::stab_each_other(const std::array<Local, 3>& a, const std::array<Local, 3>& b) const {
    const Triangle at_a = triangle(a);
    const Triangle at_b = triangle(b);
    const double depth = kCrossingDepth * unit_;
    return common_nodes(a, b) < 2 && (stabs(at_a, at_b, depth) || stabs(at_b, at_a, depth));
}

bool Block::cross_each_other(const std::array<Local, 3>& a, const std::array<Local, 3>& b) const {
    ++evaluated_;
    return stab_each_other(a, b);
}

bool Block::is_watched(const Bounds& facet) const {
    return options_.watched.empty() || std::any_of(options_.watched.begin(), options_.watched.end(),
                                                   [&](const Bounds& place) { return place.overlap(facet); });
}

/// Enters the element's facets where they are now.
void Block::list_facets(std::uint32_t tetrahedron) {
    if (!options_.watch_facets) return;
    // What a trial has removed may come back: its entries stay until it ends.
    if (grid_.size() > most_listed_ && !running_.on) list_watched_facets();
    const Tetrahedron& t = tetrahedra_[tetrahedron];
    for (std::uint32_t f = 0; f < 4; ++f) {
        if (!is_outer(t.tag[f])) continue;
        const Bounds facet = bounds(triangle(face_nodes(t, f)));
        if (is_watched(facet)) grid_.add(facet, tetrahedron, f);
    }
}

void Block::list_watched_facets() {
    list_facets_if([this](const Bounds& facet) { return is_watched(facet); });
}

/// Makes the grid anew, of the facets of whose bounds `listed` holds.
template <class Listed>
void Block::list_facets_if(const Listed& listed) {
    const auto for_facets = [&](const auto& visit) {
        for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
            for (std::uint32_t f = 0; f < 4 && alive_[i] != 0; ++f) {
                if (!is_outer(tetrahedra_[i].tag[f])) continue;
                const Bounds facet = bounds(triangle(face_nodes(tetrahedra_[i], f)));
                if (listed(facet)) visit(facet, i, f);
            }
        }
    };
    Bounds all = kNoBounds;
    std::size_t count = 0;
    for_facets([&](const Bounds& facet, std::uint32_t, std::uint32_t) {
        ++count;
        all.include(facet);
    });
    grid_.reset(all, count);
    for_facets([this](const Bounds& facet, std::uint32_t i, std::uint32_t f) { grid_.add(facet, i, f); });
    most_listed_ = kMostStale * grid_.size();
}

/// Whether one of `facets` crosses another one of them, or one of the block's that `stays` keeps. They lie
/// side by side: the grid is asked once for all.
template <class Stays>
bool Block::any_crosses(const std::vector<std::array<Local, 3>>& facets, const Stays& stays) {
    Bounds all = kNoBounds;
    boxes_.clear();
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const Bounds box = bounds(triangle(facets[i]));
        for (std::size_t k = 0; k < i; ++k) {
            ++evaluated_;
            if (box.overlap(boxes_[k]) && stab_each_other(facets[i], facets[k])) return true;
        }
        boxes_.push_back(box);
        all.include(box);
    }
    return !facets.empty() && grid_.any(all, [&](std::uint32_t t, std::uint32_t f) {
        if (t >= tetrahedra_.size() || alive_[t] == 0 || !is_outer(tetrahedra_[t].tag[f])) return false;
        const std::array<Local, 3> other = face_nodes(tetrahedra_[t], f);
        const Bounds box = bounds(triangle(other));
        if (!box.overlap(all) || !stays(t, other)) return false;
        for (std::size_t i = 0; i < facets.size(); ++i) {
            if (box.overlap(boxes_[i]) && cross_each_other(facets[i], other)) return true;
        }
        return false;
    });
}

/// Whether any two facets cross. All such places are found, unless they are many.
bool Block::has_crossed() {
    list_facets_if([](const Bounds&) { return true; });
    crossed_.clear();
    // Facets that were there when the block was loaded do not cross each other.
    const auto is_new = [this](std::uint32_t i, std::size_t f) {
        if (i >= original_.size() || !is_outer(original_[i].tag[f])) return true;
        const std::array<Local, 3> node = face_nodes(tetrahedra_[i], f);
        return std::any_of(node.begin(), node.end(),
                           [this](Local n) { return points_[n] != original_points_[n]; });
    };
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        if (alive_[i] == 0) continue;
        keep_watch();
        for (std::size_t f = 0; f < 4; ++f) {
            if (!is_outer(tetrahedra_[i].tag[f]) || !is_new(i, f)) continue;
            const std::array<Local, 3> facet = face_nodes(tetrahedra_[i], f);
            const bool crossed = grid_.any(bounds(triangle(facet)), [&](std::uint32_t t, std::uint32_t g) {
                if (t <= i && is_new(t, g)) return false;  // has been seen, or is this one
                const std::array<Local, 3> other = face_nodes(tetrahedra_[t], g);
                if (!stab_each_other(facet, other)) return false;
                note_crossing(facet, other);
                return crossed_.size() > kMostCrossed;
            });
            if (crossed) return true;
        }
    }
    return !crossed_.empty();
}

void Block::note_crossing(const std::array<Local, 3>& a, const std::array<Local, 3>& b) {
    Bounds place = bounds(triangle(a));
    place.include(bounds(triangle(b)));
    const double around = kAroundCrossed * std::max(size_[a[0]], size_[b[0]]);
    for (std::size_t j = 0; j < 3; ++j) {
        place.low[j] -= around;
        place.high[j] += around;
    }
    const auto known = std::find_if(crossed_.begin(), crossed_.end(),
                                    [&](const Bounds& other) { return other.overlap(place); });
    if (known != crossed_.end())
        known->include(place);
    else
        crossed_.push_back(place);
}

std::vector<Bounds> Block::crossed_places() const {
    return crossed_.size() > kMostCrossed || has_much_poor() ? std::vector<Bounds>{} : crossed_;
}

void Block::drop_unwatched(std::vector<std::array<Local, 3>>& facets) const {
    if (options_.watched.empty()) return;
    const auto is_far = [this](const auto& facet) { return !is_watched(bounds(triangle(facet))); };
    facets.erase(std::remove_if(facets.begin(), facets.end(), is_far), facets.end());
}

/// Whether facets that the change makes would cross others.
bool Block::crosses(const Change& change) {
    if (!options_.watch_facets) return false;
    // Merged nodes have stars of hundreds of elements.
    faces_before_.clear();
    removed_.assign(change.removed.begin(), change.removed.end());
    std::sort(removed_.begin(), removed_.end());
    for (const std::uint32_t i : removed_) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (is_outer(t.tag[f])) faces_before_.push_back(sorted_face(face_nodes(t, f)));
        }
    }
    std::sort(faces_before_.begin(), faces_before_.end());
    facets_.clear();
    const auto add = [&](const std::array<Local, 3>& facet) {
        const bool was_there =
            std::binary_search(faces_before_.begin(), faces_before_.end(), sorted_face(facet));
        if (!was_there) facets_.push_back(facet);
    };
    for (const Tetrahedron& t : change.added) {
        for (std::size_t f = 0; f < 4; ++f) {
            if (is_outer(t.tag[f])) add(face_nodes(t, f));
        }
    }
    for (const Change::Retag& r : change.retagged) {
        if (is_outer(r.tag)) add(face_nodes(tetrahedra_[r.tetrahedron], r.face));
    }
    drop_unwatched(facets_);
    return any_crosses(facets_, [&](std::uint32_t t, const std::array<Local, 3>&) {
        return !std::binary_search(removed_.begin(), removed_.end(), t);
    });
}

/// Whether facets of a node that has moved cross others.
bool Block::facets_cross(Local node) {
    if (!options_.watch_facets) return false;
    facets_.clear();
    for (const std::uint32_t i : star_[node]) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (is_outer(t.tag[f]) && t.node[f] != node) facets_.push_back(face_nodes(t, f));
        }
    }
    drop_unwatched(facets_);
    return any_crosses(facets_, [node](std::uint32_t, const std::array<Local, 3>& other) {
        return other[0] != node && other[1] != node && other[2] != node;
    });
}

}  // namespace mortise::improve
