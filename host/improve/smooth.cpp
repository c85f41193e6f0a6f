#include <algorithm>
#include <utility>

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

}  // namespace

/// What the elements around a node have with its best place so far, and what they need at a better one.
struct Block::Goal {
    bool is_sum;       ///< Wish::kAllBetter
    double worst;      ///< quality of the worst element
    double lowest;     ///< of a sum: no element may be worse
    double shortfall;  ///< of a sum

    double needed() const { return is_sum ? lowest * kSame : std::max(worst * kLeastGain, kLowestQuality); }
    bool is_nearer(double left) const { return !is_sum || left < shortfall * kLeastRelief; }
    bool is_met(double target) const { return is_sum ? !(shortfall > 0) : worst >= target; }
};

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

/// The search for a better place of one node, which moves as it goes on.
class Block::PlaceSearch {
  public:
    /// `around`: of the star where the node starts.
    PlaceSearch(Block& block, Local node, Goal goal, const StarSize& around)
        : block_(block), node_(node), on_(block.strata_[node]), goal_(goal), views_(block.views(node).views) {
        const double size = block.size_[node];
        if (on_.size() == 2 && !block.is_loose_) beside_ = block.crease_neighbours(node);
        // A crease that loses node after node to the improvement of what lies beside it must not be stretched
        // for that: elements on its long edges would be as flat as its surfaces are curved, and nothing could
        // help.
        most_stretched_ = std::max(kLongestCreaseEdge * size, longest_to(place()));
        const Fit before = on_.empty() ? Fit{} : block.worst_fit(node);
        least_alignment_ = std::min(kLeastAlignment, before.alignment);
        most_sag_ = std::max(block.most_sag_ * size, before.sag);
        block.start_room_.clear();
        may_swell_ = block.is_curved(on_) || (block.is_loose_ && !on_.empty());
        moved_ = on_.size() < 2 && attempt(0.5 * (place() + around.mean));
    }

    /// Steps in these directions, of this length and of halves of it.
    void run(const Directions& directions, double step) {
        for (int h = 0; h < kHalvings && !goal_.is_met(block_.options_.target); ++h, step *= 0.5) {
            for (std::size_t d = 0; d < directions.count; ++d) {
                if (!attempt(place() + step * directions.at[d])) continue;
                moved_ = true;
                attempt(place() + step * directions.at[d]);  // once more the same way, while it helps
            }
        }
    }

    bool has_moved() const { return moved_; }

  private:
    const Point& place() const { return block_.points_[node_]; }

    double longest_to(const Point& p) const {
        double longest = 0;
        for (const Point& q : beside_) longest = std::max(longest, length(q - p));
        return longest;
    }

    /// Puts the node at its place on its stratum nearest to `candidate`, if that is nearer to the goal.
    bool attempt(const Point& candidate) {
        Point p = candidate;
        const bool reaches =
            on_.empty() ||
            (block_.is_loose_ ? block_.is_within_reach(node_, p)
                              : block_.surfaces_->project(on_.data(), on_.size(), block_.size_[node_], &p));
        if (!reaches || longest_to(p) > most_stretched_) return false;
        const double needed = goal_.needed();
        double value = block_.quality_at(views_, p, needed);
        if (!(value > needed)) return false;
        const double left = goal_.is_sum ? block_.shortfall(views_) : 0;
        if (!goal_.is_nearer(left)) return false;
        if (may_swell_ && block_.start_room_.empty()) block_.gather_room(node_, block_.start_room_);
        const Point from = std::exchange(block_.points_[node_], p);
        if (!block_.pyramid_star_[node_].empty()) value = block_.star_quality(node_, needed);
        if (value > needed && fits()) {
            goal_.worst = value;
            goal_.shortfall = left;
            return true;
        }
        block_.points_[node_] = from;
        return false;
    }

    /// Whether the facets around the node, where it is now, are as they should be.
    bool fits() {
        if (on_.empty()) return true;
        if (may_swell_ && block_.star_swells(node_)) return false;
        const Fit now = block_.worst_fit(node_);
        return now.alignment >= least_alignment_ && now.sag <= most_sag_ && !block_.facets_cross(node_);
    }

    Block& block_;
    const Local node_;
    const std::vector<std::uint32_t>& on_;  ///< stratum
    Goal goal_;
    StarViews& views_;
    std::vector<Point> beside_;  ///< neighbours on a crease
    double most_stretched_ = 0;
    double least_alignment_ = 0;
    double most_sag_ = 0;
    bool may_swell_ = false;
    bool moved_ = false;
};

/// Sizes of the star of a node, and where its worst element wants it.
Block::StarSize Block::measure_star(Local node) const {
    StarSize star;
    star.shortest = kLongest;
    double count = 0;
    double worst = 2;
    for (const std::uint32_t i : star_[node]) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t k = 0; k < 4; ++k) {
            if (t.node[k] == node) {
                if (t.quality >= worst) continue;
                worst = t.quality;
                const auto& o = kOpposite[k];
                star.away = cross(points_[t.node[o[2]]] - points_[t.node[o[0]]],
                                  points_[t.node[o[1]]] - points_[t.node[o[0]]]);
                continue;
            }
            star.mean = star.mean + points_[t.node[k]];
            const double edge = length(points_[t.node[k]] - points_[node]);
            star.edge += edge;
            star.shortest = std::min(star.shortest, edge);
            count += 1;
        }
    }
    star.mean = (1 / count) * star.mean;
    star.edge /= count;
    const double norm = length(star.away);
    if (norm > 0) star.away = (1 / norm) * star.away;
    return star;
}

/// Whether smooth() is to look for another place of a node.
bool Block::may_smooth(Local node, Wish wish) {
    const bool relaxes = wish == Wish::kAllBetter;
    const std::vector<std::uint32_t>& on = strata_[node];
    if (free_[node] == 0 || tip_[node] != 0 || star_[node].empty()) return false;
    if (!on.empty() && !options_.move_boundary) return false;
    if (relaxes ? !pyramid_star_[node].empty() : rested_[node] > changed_[node]) return false;
    const bool is_corner = on.size() > 2 || (on.size() == 2 && count_feature_edges(node) != 2);
    return !is_corner || (!relaxes && is_loose_);
}

bool Block::smooth(Local node, Wish wish) {
    if (!may_smooth(node, wish)) return false;
    const bool relaxes = wish == Wish::kAllBetter;
    if (!relaxes) rested_[node] = clock_ + 1;
    const double worst = known_star_quality(node);
    if (worst >= options_.target) return false;
    const double lowest = options_.raised_from > 0 ? std::min(worst, options_.raised_from) : worst;
    Goal goal{relaxes, worst, lowest, 0};
    if (relaxes) {
        StarViews& seen = views(node).views;
        quality_at(seen, points_[node], kInvertedQuality);
        goal.shortfall = shortfall(seen);
    }
    const StarSize star = measure_star(node);
    Directions directions;
    if (!find_directions(node, star.away, directions)) return false;
    const Point start = points_[node];
    PlaceSearch search(*this, node, goal, star);
    const bool is_on_leash = is_loose_ && !strata_[node].empty();
    const double most = is_on_leash ? loose_start_->reach * size_[node] : kLongest;
    search.run(directions, std::min(kFirstStep * star.edge, most));
    // In a cluster of nodes the scale is that of the cluster.
    if (!search.has_moved() && star.shortest < kCluster * star.edge)
        search.run(directions, 0.5 * star.shortest);
    if (!search.has_moved()) return false;
    if (running_.on) {
        const Point end = std::exchange(points_[node], start);
        note_move(node);
        points_[node] = end;
    }
    ++counters.moved;
    ++clock_;
    ++version_;
    divide_shares(node);
    touch(node);
    if (!strata_[node].empty()) {
        for (const std::uint32_t i : star_[node]) list_facets(i);
    }
    for (const std::uint32_t i : star_[node]) tetrahedra_[i].quality = quality(tetrahedra_[i].node);
    return true;
}

}  // namespace mortise::improve
