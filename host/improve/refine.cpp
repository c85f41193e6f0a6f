// Smaller elements where the model has features finer than elements bear.
//
// A step of a tenth of a cell between two creases forces elements as flat as the step is low for their
// length, and no change of connectivity helps: the elements must become shorter. So around elements that
// nothing else has helped, edges are split until they are about as long as the height that the elements
// there have, growing with distance, and improvement goes on; it stays so only if that is a relief.
#include <algorithm>
#include <cmath>
#include <queue>

#include "host/common/disjoint_sets.hpp"
#include "host/common/sort_unique.hpp"
#include "host/improve/block.hpp"

namespace mortise::improve {
namespace {

/// Length asked for where a poor element is, in its heights: the second only if the first is no relief.
constexpr double kEdgesPerHeight[] = {3, 1.3};
constexpr double kShortestAsked = 0.07;  ///< edges of the smallest leaf: what is lower stays poor
constexpr double kLongestAsked = 0.5;
constexpr double kGrowth = 0.7;   ///< of the length, with distance from the poor element
constexpr double kTooLong = 1.5;  ///< edges are split that are longer than this times what is asked
constexpr std::uint64_t kRefineEvaluations = 100;          ///< of qualities, per tetrahedron of the block,
constexpr std::uint64_t kLeastRefineEvaluations = 300000;  ///< and besides, since few may become many
/// Tetrahedra around a split edge, more or less, that improvement then works on.
constexpr std::uint64_t kTetrahedraPerSplit = 24;
constexpr std::size_t kMostPoor = 1000;    ///< and one in 16: of more, smaller elements leave too many
constexpr std::size_t kMostMembers = 256;  ///< of a cluster: where all is poor, the model has no room
/// Edges split around a cluster, at most: more make too many elements, and as a rule in vain.
constexpr std::size_t kMostSplits = 64;
constexpr std::size_t kMostSplitsPerMember = 40;
/// Part of what was wrong with a cluster that smaller elements must mend.
constexpr double kLeastMended = 0.2;
/// What single changes may leave for those of several steps to mend: so much more wrong, or a worst element
/// so much worse. Of 847 attempts that left more, 41 became a relief; of 590 that left but a facet too far
/// from its surface, 15.
constexpr double kMostRegress = 0.2;
constexpr double kWorstRegress = 0.7;
/// Of elements worse than this it does not count how much worse they are.
constexpr double kLeastWeighed = 0.003;
constexpr double kMostRefinedSag = 0.1;   ///< of a facet, in cells, unless it was larger
constexpr std::size_t kMostAround = 100;  ///< elements around a node; 24 are usual
constexpr std::size_t kMostRing = 16;

struct LongEdge {
    double excess;  ///< length per length asked for
    std::uint32_t a, b;

    bool operator<(const LongEdge& other) const {
        if (excess != other.excess) return excess < other.excess;
        return a != other.a ? a > other.a : b > other.b;
    }
};

/// What is wrong with an element of this quality.
double burden(double quality) {
    const double lack = std::max(0.0, kGoodQuality / std::max(quality, kLeastWeighed) - 1);
    return lack * lack;
}

}  // namespace

struct Block::Seed {
    Point at;
    double length;  ///< of edges there
};

struct Block::Cluster {
    std::vector<std::uint32_t> members;
    double worst = 2;  ///< quality
    double burden = 0;
};

/// Appends a node that belongs to this block alone.
Block::Local Block::add_node(const Point& at, double size, std::vector<std::uint32_t> stratum) {
    const auto node = static_cast<Local>(points_.size());
    zone_node_.push_back(kNewNode + (node - loaded_));
    points_.push_back(at);
    size_.push_back(size);
    free_.push_back(1);
    shared_.push_back(0);
    joined_.push_back(0);
    tip_.push_back(0);
    strata_.push_back(std::move(stratum));
    changed_.push_back(0);
    rested_.push_back(0);
    seen_at_.push_back(0);
    if (star_.size() < points_.size()) star_.resize(points_.size());
    if (pyramid_star_.size() < points_.size()) pyramid_star_.resize(points_.size());
    return node;
}

/// Puts a node in the middle of an edge all of whose tetrahedra are in the block; kNone if they are not, if
/// facets at the edge are held, or if a node beside it would get too many elements.
Block::Local Block::split_edge(Local a, Local b) {
    if (!gather_ring(a, b, kMostRing, ring_)) return kNone;
    const auto is_crowded = [this](Local n) { return star_[n].size() >= kMostAround; };
    if (std::any_of(ring_.nodes.begin(), ring_.nodes.end(), is_crowded)) return kNone;
    if (!ring_.closed) {
        const auto is_outside = [](FaceTag tag) { return tag != 0 && (tag & kTagInterface) == 0; };
        if (!is_outside(tag_of(ring_.tetrahedra.front(), a, b, ring_.nodes.front())) ||
            !is_outside(tag_of(ring_.tetrahedra.back(), a, b, ring_.nodes.back())))
            return kNone;
    }
    std::vector<std::uint32_t> stratum;
    for (const std::uint32_t i : ring_.tetrahedra) {
        const Tetrahedron& t = tetrahedra_[i];
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || t.node[f] == a || t.node[f] == b) continue;
            if ((t.tag[f] & kTagBorder) != 0) return kNone;
            stratum.push_back(tag_surface(t.tag[f]));
        }
    }
    sort_unique(stratum);
    trial_.clear();
    const Local middle = add_node(0.5 * (points_[a] + points_[b]), std::min(size_[a], size_[b]), stratum);
    for (const std::uint32_t i : ring_.tetrahedra) {
        trial_.removed.push_back(i);
        for (const Local gone : {a, b}) {
            Tetrahedron t = tetrahedra_[i];
            for (std::size_t k = 0; k < 4; ++k) {
                if (t.node[k] == gone)
                    t.node[k] = middle;
                else if (t.node[k] == a || t.node[k] == b)
                    t.tag[k] = 0;
            }
            t.quality = quality(t.node);
            t.stuck = false;
            trial_.added.push_back(t);
        }
    }
    apply(trial_);
    ++counters.split;
    return middle;
}

/// Poor elements that share nodes, those with the worst element first.
std::vector<Block::Cluster> Block::find_clusters() const {
    std::vector<std::uint32_t> poor;
    for (std::uint32_t i = 0; i < tetrahedra_.size(); ++i) {
        const Tetrahedron& t = tetrahedra_[i];
        if (alive_[i] != 0 && t.quality < kGoodQuality && !t.refined) poor.push_back(i);
    }
    if (poor.empty()) return {};
    std::vector<std::uint32_t> last(points_.size(), kNone);
    DisjointSets sets(poor.size());
    for (std::uint32_t c = 0; c < poor.size(); ++c) {
        for (const Local n : tetrahedra_[poor[c]].node) {
            if (last[n] != kNone) sets.join(last[n], c);
            last[n] = c;
        }
    }
    std::vector<std::uint32_t> place(poor.size(), kNone);
    std::vector<Cluster> clusters;
    for (std::uint32_t c = 0; c < poor.size(); ++c) {
        std::uint32_t& at = place[sets.find(c)];
        if (at == kNone) {
            at = static_cast<std::uint32_t>(clusters.size());
            clusters.emplace_back();
        }
        const Tetrahedron& t = tetrahedra_[poor[c]];
        clusters[at].members.push_back(poor[c]);
        clusters[at].worst = std::min(clusters[at].worst, t.quality);
        clusters[at].burden += burden(t.quality);
    }
    std::stable_sort(clusters.begin(), clusters.end(),
                     [](const Cluster& x, const Cluster& y) { return x.worst < y.worst; });
    return clusters;
}

/// What length of edges poor elements ask for.
std::vector<Block::Seed> Block::find_seeds(const std::vector<std::uint32_t>& members,
                                           double edge_per_height) const {
    std::vector<Seed> seeds;
    for (const std::uint32_t i : members) {
        const Tetrahedron& t = tetrahedra_[i];
        std::array<Point, 4> p;
        double size = size_[t.node[0]];
        for (std::size_t k = 0; k < 4; ++k) {
            p[k] = points_[t.node[k]];
            size = std::min(size, size_[t.node[k]]);
        }
        const double asked = std::max(edge_per_height * smallest_height(p), kShortestAsked * size);
        seeds.push_back({0.25 * (p[0] + p[1] + p[2] + p[3]), std::min(asked, kLongestAsked * size)});
    }
    return seeds;
}

/// Length that the seeds ask for at a point, or `most` if that is shorter.
double Block::asked_length(const std::vector<Seed>& seeds, const Point& at, double most) {
    double asked = most;
    for (const Seed& seed : seeds) {
        if (seed.length >= asked) continue;
        const double room = (asked - seed.length) / kGrowth;
        const double distance = squared_length(at - seed.at);
        if (distance < room * room) asked = seed.length + kGrowth * std::sqrt(distance);
    }
    return asked;
}

/// Splits edges around poor elements that are longer than these ask for. Returns how many were split, 0 if
/// that would be too many.
std::size_t Block::split_long_edges(const std::vector<std::uint32_t>& members, double edge_per_height) {
    const std::vector<Seed> seeds = find_seeds(members, edge_per_height);
    std::priority_queue<LongEdge> queue;
    std::vector<std::uint8_t> seen(points_.size());
    std::vector<Local> next;
    const auto visit = [&](Local n) {
        if (seen[n] != 0) return;
        seen[n] = 1;
        next.push_back(n);
    };
    const auto ask = [&](Local a, Local b) {
        const double edge = length(points_[b] - points_[a]);
        const double asked = asked_length(seeds, 0.5 * (points_[a] + points_[b]), edge);
        if (!(edge > kTooLong * asked)) return;
        queue.push({edge / asked, std::min(a, b), std::max(a, b)});
        visit(a);
        visit(b);
    };
    for (const std::uint32_t i : members) {
        for (const Local n : tetrahedra_[i].node) visit(n);
    }
    const std::size_t most = kMostSplits + kMostSplitsPerMember * members.size();
    std::size_t count = 0;
    while (count <= most) {
        while (!next.empty()) {
            const Local n = next.back();
            next.pop_back();
            for (const Local other : neighbours(n)) ask(n, other);
        }
        if (queue.empty()) break;
        const LongEdge edge = queue.top();
        queue.pop();
        // Edges are entered from both ends, and may be gone.
        if (!share_tetrahedron(edge.a, edge.b)) continue;
        const Local middle = split_edge(edge.a, edge.b);
        if (middle == kNone) continue;
        ++count;
        seen.resize(points_.size());
        visit(middle);
    }
    return count <= most ? count : 0;
}

/// What a cluster has become, compared with what it was in `before`.
Block::Relief Block::find_relief(const Block& before, const Cluster& cluster) const {
    double sum = 0;
    double worst = 2;
    double old_sag = kMostRefinedSag;
    double sag = 0;
    for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
        const bool was = i < before.tetrahedra_.size() && before.alive_[i] != 0;
        const bool is = alive_[i] != 0;
        const double old = was ? before.tetrahedra_[i].quality : 2;
        const double now = is ? tetrahedra_[i].quality : 2;
        if (old == now) continue;
        if (was) old_sag = std::max(old_sag, before.worst_sag(static_cast<std::uint32_t>(i)));
        if (is) sag = std::max(sag, worst_sag(static_cast<std::uint32_t>(i)));
        sum += (is ? burden(now) : 0) - (was ? burden(old) : 0);
        worst = std::min(worst, now);
    }
    Relief relief;
    relief.is_enough = sum < -kLeastMended * cluster.burden && worst >= cluster.worst && sag <= old_sag;
    relief.is_near =
        sum < kMostRegress * cluster.burden && worst >= kWorstRegress * cluster.worst && sag <= old_sag;
    return relief;
}

/// Tries smaller elements around what is left of a cluster. Changes of several steps take more time than all
/// else here: what single ones leave far from a relief is not worth it.
bool Block::relieve(const Cluster& cluster, const std::vector<std::uint32_t>& members) {
    Block before = *this;
    before.looks_since_ = looks_since_ = clock_;
    for (const double edge_per_height : kEdgesPerHeight) {
        most_sag_ = kMostRefinedSag;
        const auto first_added = static_cast<Local>(points_.size());
        const std::size_t splits = split_long_edges(members, edge_per_height);
        if (splits > 0) {
            project_nodes(first_added);
            limit_search(splits * kTetrahedraPerSplit);
            sweep();
            const Relief by_single = find_relief(before, cluster);
            bool is_enough = by_single.is_enough;
            if (is_enough || by_single.is_near) {
                mend_further();
                is_enough = is_enough || find_relief(before, cluster).is_enough;
            }
            if (is_enough) {
                most_sag_ = before.most_sag_;
                looks_since_ = 0;
                return true;
            }
        }
        before.evaluated_ = evaluated_;
        *this = before;
    }
    looks_since_ = 0;
    for (const std::uint32_t i : members) tetrahedra_[i].refined = true;
    return false;
}

bool Block::may_refine() const {
    if (!options_.look_ahead || !options_.change_boundary) return false;
    const std::size_t poor = count_below(kGoodQuality);
    return poor > 0 && poor <= kMostPoor + original_.size() / 16;
}

bool Block::refine() {
    std::vector<Cluster> clusters = find_clusters();
    last_evaluation_ = evaluated_ + kLeastRefineEvaluations + kRefineEvaluations * count_alive();
    bool any = false;
    for (const Cluster& cluster : clusters) {
        std::vector<std::uint32_t> members;
        for (const std::uint32_t i : cluster.members) {
            if (alive_[i] != 0 && tetrahedra_[i].quality < kGoodQuality) members.push_back(i);
        }
        if (members.empty() || members.size() > kMostMembers) continue;
        if (evaluated_ > last_evaluation_) break;
        if (relieve(cluster, members)) any = true;
    }
    return any;
}

}  // namespace mortise::improve
