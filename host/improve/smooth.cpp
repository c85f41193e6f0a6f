#include <algorithm>

#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

constexpr double kLongestCreaseEdge = 2;  ///< cells; longer ones may only shrink
constexpr double kSamePlace = 1e-6;       ///< cells: targets closer than this are one point of the model
constexpr double kFlatAtCorner = 0.01;
constexpr double kFirstStep = 0.25;  ///< of the mean length of the node's edges
constexpr int kHalvings = 4;
constexpr double kLongest = 1e9;
constexpr double kCluster = 0.05;       ///< shortest per mean edge
constexpr double kSame = 1 - 1e-12;     ///< a quality that is not lower, but for rounding
constexpr double kLeastRelief = 0.999;  ///< what is left of a shortfall

/// What the elements around a node have with its best place so far, and what they need at a better one.
struct Goal {
    bool is_sum;       ///< Wish::kAllBetter
    double worst;      ///< quality of the worst element
    double lowest;     ///< of a sum: no element may be worse
    double shortfall;  ///< of a sum

    double needed() const { return is_sum ? lowest * kSame : std::max(worst * kLeastGain, kLowestQuality); }
    bool is_nearer(double left) const { return !is_sum || left < shortfall * kLeastRelief; }
    bool is_met(double target) const { return is_sum ? !(shortfall > 0) : worst >= target; }
};

}  // namespace

double Block::star_quality(Local node, double enough) const {
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
double Block::known_star_quality(Local node) const {
    double worst = 2;
    for (const std::uint32_t i : star_[node]) worst = std::min(worst, tetrahedra_[i].quality);
    for (const std::uint32_t i : pyramid_star_[node])
        worst = std::min(worst, pyramid_quality(corners(pyramids_[i])));
    return worst;
}

/// Smallest cosine between the node's facets on curved surfaces and those surfaces, whichever way both point,
/// and the largest distance.
Block::Fit Block::worst_fit(Local node) const {
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

/// Nodes of the certificate lie on their surfaces to within the chords of curved creases: puts them there.
/// Where a mesh touches itself, two nodes may have the same target: they stay. False if a node had to stay
/// because an element would have become too flat.
bool Block::project_nodes(Local first) {
    if (!options_.move_boundary) return true;
    struct Target {
        Point at;
        Local node;
        bool moves;
    };
    std::vector<Target> targets;
    double largest = 0;
    for (Local n = first; n < points_.size(); ++n) {
        if (star_[n].empty() || strata_[n].empty()) continue;
        largest = std::max(largest, size_[n]);
        Target t{points_[n], n, false};
        if (free_[n] != 0 && tip_[n] != 0) {
            t.at = tips_[tip_[n] - 1u];
            t.moves = t.at != points_[n];
        } else if (free_[n] != 0 && (options_.change_boundary || strata_[n].size() < 3)) {
            t.moves = surfaces_->project(strata_[n].data(), strata_[n].size(), size_[n], &t.at) &&
                      t.at != points_[n];
        }
        targets.push_back(t);
    }
    for (bool again = true; again;) {
        again = false;
        std::sort(targets.begin(), targets.end(), [](const Target& a, const Target& b) {
            return a.at != b.at ? a.at < b.at : a.node < b.node;
        });
        for (std::size_t i = 0; i < targets.size(); ++i) {
            for (std::size_t j = i + 1; j < targets.size(); ++j) {
                const Point d = targets[j].at - targets[i].at;
                if (d[0] > kSamePlace * largest) break;
                const double same = kSamePlace * std::max(size_[targets[i].node], size_[targets[j].node]);
                if (squared_length(d) > same * same) continue;
                for (Target* t : {&targets[i], &targets[j]}) {
                    again = again || t->moves;
                    t->moves = false;
                    t->at = points_[t->node];
                }
            }
        }
    }
    std::sort(targets.begin(), targets.end(),
              [](const Target& a, const Target& b) { return a.node < b.node; });
    bool all = true;
    for (const Target& t : targets) {
        if (!t.moves) continue;
        const Point before = points_[t.node];
        const double worst = star_quality(t.node, kInvertedQuality);
        points_[t.node] = t.at;
        // On its surface an element may be a little worse, at a corner much worse for now; but never flat.
        const bool is_corner = tip_[t.node] != 0 || strata_[t.node].size() > 2;
        const double enough = std::min(0.5 * worst, is_corner ? kFlatAtCorner : 1);
        if (!(star_quality(t.node, kLowestQuality) > std::max(enough, kLowestQuality)) ||
            facets_cross(t.node)) {
            points_[t.node] = before;
            all = false;
            continue;
        }
        ++clock_;
        ++version_;
        divide_shares(t.node);
        touch(t.node);
        for (const std::uint32_t i : star_[t.node]) list_facets(i);
        for (const std::uint32_t i : star_[t.node]) tetrahedra_[i].quality = quality(tetrahedra_[i].node);
    }
    return all;
}

/// The node's elements for a search of its place.
Block::CachedViews& Block::views(Local node) {
    for (CachedViews& cached : views_) {
        if (cached.node == node && cached.version == version_) return cached;
    }
    CachedViews& cached = views_[next_views_];
    next_views_ = (next_views_ + 1) % views_.size();
    cached.node = node;
    cached.version = version_;
    cached.worst = StarViews::kNoElement;
    cached.squared_reach = 0;
    cached.views.clear();
    for (const std::uint32_t i : star_[node]) {
        const auto& n = tetrahedra_[i].node;
        cached.worst = std::min(cached.worst, tetrahedra_[i].quality);
        for (const Local other : n) {
            cached.squared_reach =
                std::max(cached.squared_reach, squared_length(points_[other] - points_[node]));
        }
        const auto k = static_cast<std::size_t>(std::find(n.begin(), n.end(), node) - n.begin());
        const auto& o = kOpposite[k];
        // (node, x, y, z) is positive if the tetrahedron is.
        cached.views.add({n[o[0]], n[o[1]], n[o[2]]}, points_[n[o[0]]], points_[n[o[1]]], points_[n[o[2]]]);
    }
    cached.views.finish();
    return cached;
}

/// Worst quality around the node of these views if it were at p, or one not above `enough`.
double Block::quality_at(StarViews& views, const Point& p, double enough, Local except) {
    const std::uint64_t before = views.cost();
    const double worst = views.worst_at(p, enough, rounding_, except);
    evaluated_ += views.cost() - before;
    return worst;
}

/// Places of the nodes next to one on a crease.
std::vector<Point> Block::crease_neighbours(Local node) const {
    std::vector<Point> found;
    for (const std::uint32_t i : star_[node]) {
        for (const Local n : tetrahedra_[i].node) {
            if (n != node && strata_[n].size() > 1 && edge_is_on_stratum(node, n))
                found.push_back(points_[n]);
        }
    }
    return found;
}

/// Ways in which a node may move along its stratum. `away`: from the face opposite it in its worst element.
/// False if its surfaces do not tell.
bool Block::find_directions(Local node, const Point& away, Directions& found) const {
    const std::vector<std::uint32_t>& on = strata_[node];
    const auto add = [&](const Point& d) { found.at[found.count++] = d; };
    const auto add_pair = [&](const Point& d) {
        add(d);
        add(-1.0 * d);
    };
    if (on.empty() || is_loose_) {
        add(away);
        add_pair({1, 0, 0});
        add_pair({0, 1, 0});
        add_pair({0, 0, 1});
        return true;
    }
    Point normal[2];
    for (std::size_t k = 0; k < on.size(); ++k) {
        const Surfaces::Sample s = surfaces_->sample(on[k], points_[node]);
        if (!s.valid) return false;
        normal[k] = (1 / length(s.gradient)) * s.gradient;
    }
    if (on.size() == 2) {
        const Point along = cross(normal[0], normal[1]);
        const double sine = length(along);
        if (sine < 0.05) return false;
        add_pair((1 / sine) * along);
        return true;
    }
    const Point& n = normal[0];
    const Point axis = std::fabs(n[0]) < 0.6 ? Point{1, 0, 0} : Point{0, 1, 0};
    Point u = cross(n, axis);
    u = (1 / length(u)) * u;
    add_pair(u);
    add_pair(cross(n, u));
    const Point flat = away - dot(away, n) * n;
    const double flat_length = length(flat);
    if (flat_length > 1e-3) add((1 / flat_length) * flat);
    return true;
}

/// How far the elements of a star, as last evaluated, are below the target together.
double Block::shortfall(const StarViews& seen) const {
    double sum = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const double lack = std::max(0.0, options_.target - seen.quality(i));
        sum += lack * lack;
    }
    return sum;
}

bool Block::smooth(Local node, Wish wish) {
    const bool relaxes = wish == Wish::kAllBetter;
    const std::vector<std::uint32_t>& on = strata_[node];
    if (free_[node] == 0 || tip_[node] != 0 || star_[node].empty()) return false;
    if (!on.empty() && !options_.move_boundary) return false;
    if (relaxes ? !pyramid_star_[node].empty() : rested_[node] > changed_[node]) return false;
    const bool is_corner = on.size() > 2 || (on.size() == 2 && count_feature_edges(node) != 2);
    if (is_corner && (relaxes || !is_loose_)) return false;
    if (!relaxes) rested_[node] = clock_ + 1;
    const double worst_now = known_star_quality(node);
    if (worst_now >= options_.target) return false;
    StarViews& seen = views(node).views;
    const double lowest = options_.raised_from > 0 ? std::min(worst_now, options_.raised_from) : worst_now;
    Goal goal{relaxes, worst_now, lowest, 0};
    if (relaxes) {
        quality_at(seen, points_[node], kInvertedQuality);
        goal.shortfall = shortfall(seen);
    }

    Point mean = {0, 0, 0};
    double size = 0;
    double shortest = kLongest;
    double count = 0;
    const Point start = points_[node];
    Point away = {0, 0, 0};  // from the face opposite the node in its worst element
    double worst = 2;
    for (const std::uint32_t i : star_[node]) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t k = 0; k < 4; ++k) {
            if (t.node[k] == node) {
                if (t.quality >= worst) continue;
                worst = t.quality;
                const auto& o = kOpposite[k];
                away = cross(points_[t.node[o[2]]] - points_[t.node[o[0]]],
                             points_[t.node[o[1]]] - points_[t.node[o[0]]]);
                continue;
            }
            mean = mean + points_[t.node[k]];
            const double edge = length(points_[t.node[k]] - start);
            size += edge;
            shortest = std::min(shortest, edge);
            count += 1;
        }
    }
    mean = (1 / count) * mean;
    size /= count;
    const double norm = length(away);
    if (norm > 0) away = (1 / norm) * away;

    Directions direction;
    if (!find_directions(node, away, direction)) return false;
    const std::vector<Point> beside =
        on.size() == 2 && !is_loose_ ? crease_neighbours(node) : std::vector<Point>{};
    const auto longest_to = [&](const Point& p) {
        double longest = 0;
        for (const Point& q : beside) longest = std::max(longest, length(q - p));
        return longest;
    };
    // A crease that loses node after node to the improvement of what lies beside it must not be stretched for
    // that: elements on its long edges would be as flat as its surfaces are curved, and nothing could help.
    const double most_stretched = std::max(kLongestCreaseEdge * size_[node], longest_to(start));
    const Fit before = on.empty() ? Fit{} : worst_fit(node);
    const double least_alignment = std::min(kLeastAlignment, before.alignment);
    const double most_sag = std::max(most_sag_ * size_[node], before.sag);
    start_room_.clear();
    const bool may_swell = is_curved(on) || (is_loose_ && !on.empty());
    const auto fits = [&] {
        if (on.empty()) return true;
        if (may_swell && star_swells(node)) return false;
        const Fit now = worst_fit(node);
        return now.alignment >= least_alignment && now.sag <= most_sag && !facets_cross(node);
    };
    const auto attempt = [&](const Point& from, const Point& candidate) {
        Point p = candidate;
        const bool reaches =
            on.empty() || (is_loose_ ? is_within_reach(node, p)
                                     : surfaces_->project(on.data(), on.size(), size_[node], &p));
        if (!reaches || longest_to(p) > most_stretched) return false;
        const double needed = goal.needed();
        double value = quality_at(seen, p, needed);
        if (!(value > needed)) return false;
        const double left = relaxes ? shortfall(seen) : 0;
        if (!goal.is_nearer(left)) return false;
        if (may_swell && start_room_.empty()) gather_room(node, start_room_);
        points_[node] = p;
        if (!pyramid_star_[node].empty()) value = star_quality(node, needed);
        if (value > needed && fits()) {
            goal.worst = value;
            goal.shortfall = left;
            return true;
        }
        points_[node] = from;
        return false;
    };

    bool moved = on.size() < 2 && attempt(start, 0.5 * (start + mean));
    const auto search = [&](double step, int halvings) {
        for (int h = 0; h < halvings && !goal.is_met(options_.target); ++h, step *= 0.5) {
            for (std::size_t d = 0; d < direction.count; ++d) {
                const Point from = points_[node];
                if (!attempt(from, from + step * direction.at[d])) continue;
                moved = true;
                // Once more the same way, while it helps.
                const Point next = points_[node];
                attempt(next, next + step * direction.at[d]);
            }
        }
    };
    const double most = is_loose_ && !on.empty() ? loose_start_->reach * size_[node] : kLongest;
    search(std::min(kFirstStep * size, most), kHalvings);
    // In a cluster of nodes the scale is that of the cluster.
    if (!moved && shortest < kCluster * size) search(0.5 * shortest, kHalvings);
    if (!moved) return false;
    if (running_.on) {
        const Point end = points_[node];
        points_[node] = start;
        note_move(node);
        points_[node] = end;
    }
    ++counters.moved;
    ++clock_;
    ++version_;
    divide_shares(node);
    touch(node);
    if (!on.empty()) {
        for (const std::uint32_t i : star_[node]) list_facets(i);
    }
    for (const std::uint32_t i : star_[node]) tetrahedra_[i].quality = quality(tetrahedra_[i].node);
    return true;
}

}  // namespace mortise::improve
