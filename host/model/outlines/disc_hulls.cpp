#include "host/model/outlines/disc_hulls.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/model/agreement.hpp"

namespace mortise::model_reader {
namespace {

bool same_disc(const Disc& a, const Disc& b) { return a.center == b.center && a.radius == b.radius; }

/// Nothing in a shape of a kind that is not a hull of discs.
std::optional<std::vector<Disc>> leaf_discs(const FlatNode& node, const FlatMap& map) {
    if (node.op == FlatNode::Op::kCircle) return mapped({{{0, 0}, node.radius}}, map);
    if (!node.discs.empty()) {
        if (auto discs = mapped(node.discs, map)) return discs;
    }
    std::vector<Disc> points;
    for (const auto& loop : node.contours) {
        for (const Vec2& point : loop) points.push_back({image_of(map, point), 0});
    }
    return points;
}

bool is_convex(const std::vector<Vec2>& loop) {
    const std::size_t n = loop.size();
    double turned = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2& a = loop[i];
        const Vec2& b = loop[(i + 1) % n];
        const Vec2& c = loop[(i + 2) % n];
        const Vec2 u = {b[0] - a[0], b[1] - a[1]};
        const Vec2 v = {c[0] - b[0], c[1] - b[1]};
        const double turn = std::atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
        if (turn < -1e-9) return false;
        turned += turn;
    }
    return n > 2 && std::fabs(turned - kTurn) < 1e-3;  // once round
}

}  // namespace

std::vector<Disc> hull_of_discs(const std::vector<Disc>& given) {
    double extent = 0;
    for (const Disc& disc : given) {
        extent = std::max({extent, std::fabs(disc.center[0] - given[0].center[0]),
                           std::fabs(disc.center[1] - given[0].center[1]), disc.radius});
    }
    const double tolerance = kSame * extent;
    const auto distance = [](const Disc& a, const Disc& b) {
        return std::hypot(b.center[0] - a.center[0], b.center[1] - a.center[1]);
    };
    // Discs inside others do not count; of equal ones the first.
    std::vector<Disc> discs;
    std::vector<Disc> by_size = given;
    std::stable_sort(by_size.begin(), by_size.end(),
                     [](const Disc& a, const Disc& b) { return a.radius > b.radius; });
    for (const Disc& disc : by_size) {
        const bool inside = std::any_of(discs.begin(), discs.end(), [&](const Disc& larger) {
            return distance(disc, larger) + disc.radius <= larger.radius + tolerance;
        });
        if (!inside) discs.push_back(disc);
    }
    if (discs.size() < 2) return discs;
    // Gift wrapping: from the lowest disc on, the tangent that turns least; of equal ones the longest.
    const auto bottom = [](const Disc& d) { return d.center[1] - d.radius; };
    std::size_t first = 0;
    for (std::size_t i = 1; i < discs.size(); ++i) {
        const double rise = bottom(discs[i]) - bottom(discs[first]);
        // The rightmost of those that are equally low: the first arc starts at its lowest point.
        if (rise < -tolerance || (rise <= tolerance && discs[i].center[0] > discs[first].center[0]))
            first = i;
    }
    std::vector<Disc> hull;
    std::size_t at = first;
    double normal = -kTurn / 4;  // of the tangent line, turning counter-clockwise
    constexpr double kAngle = 1e-9;
    for (std::size_t step = 0; step < 2 * discs.size(); ++step) {
        hull.push_back(discs[at]);
        std::size_t next = at;
        double least = HUGE_VAL;
        for (std::size_t i = 0; i < discs.size(); ++i) {
            if (i == at) continue;
            const double apart = distance(discs[at], discs[i]);
            const double toward = std::atan2(discs[i].center[1] - discs[at].center[1],
                                             discs[i].center[0] - discs[at].center[0]);
            const double cosine = (discs[at].radius - discs[i].radius) / apart;
            // The common tangent with both discs on its left.
            double turn = toward - std::acos(std::clamp(cosine, -1.0, 1.0)) - normal;
            turn -= kTurn * std::floor(turn / kTurn);
            if (turn > kTurn - kAngle) turn = 0;
            const bool longer = apart > distance(discs[at], discs[next]);
            if (turn < least - kAngle || (turn <= least + kAngle && longer)) {
                least = std::min(turn, least);
                next = i;
            }
        }
        // Round once: the first disc's lowest point is passed again.
        if (normal + least >= kTurn * 3 / 4 - kAngle) break;
        normal += least;
        at = next;
    }
    if (hull.size() > 1 && at == first) hull.pop_back();
    return hull;
}

std::optional<std::vector<Disc>> mapped(const std::vector<Disc>& discs, const FlatMap& map) {
    const double scale = std::hypot(map[0], map[3]);
    const bool keeps = std::fabs(std::hypot(map[1], map[4]) - scale) <= kSame * scale &&
                       std::fabs(map[0] * map[1] + map[3] * map[4]) <= kSame * scale * scale;
    if (!keeps) return std::nullopt;
    std::vector<Disc> result;
    for (const Disc& disc : discs) result.push_back({image_of(map, disc.center), scale * disc.radius});
    return result;
}

std::optional<std::vector<Disc>> discs_of(const FlatTree& tree, std::uint32_t root) {
    using Discs = std::optional<std::vector<Disc>>;
    return fold<Discs>(tree, root, leaf_discs, [](FlatNode::Op op, std::vector<Discs> values) -> Discs {
        if (op != FlatNode::Op::kUnion) return std::nullopt;
        std::vector<Disc> all;
        for (const Discs& discs : values) {
            if (!discs) return std::nullopt;
            all.insert(all.end(), discs->begin(), discs->end());
        }
        return all;
    });
}

std::optional<std::vector<Disc>> convex_discs_of(const FlatTree& tree, std::uint32_t root) {
    FlatMap map = kFlatIdentity;
    const FlatNode* node = &tree.nodes[root];
    while (node->children.size() == 1) {
        if (node->op == FlatNode::Op::kTransform) map = compose(map, node->map);
        node = &tree.nodes[node->children[0]];
    }
    const bool circle = node->op == FlatNode::Op::kCircle;
    if (!circle && node->op != FlatNode::Op::kContours) return std::nullopt;
    if (circle || !node->discs.empty()) return leaf_discs(*node, map);
    if (node->contours.size() != 1 || !is_convex(node->contours[0])) return std::nullopt;
    return leaf_discs(*node, map);
}

std::vector<Disc> round_hull(const std::vector<Disc>& discs) {
    constexpr std::size_t kMostGiven = 2000;
    if (discs.empty() || discs.size() > kMostGiven) return {};
    std::vector<Disc> hull;
    for (const Disc& disc : hull_of_discs(discs)) {
        if (!(disc.radius > 0)) return {};
        if (std::none_of(hull.begin(), hull.end(), [&](const Disc& other) { return same_disc(disc, other); }))
            hull.push_back(disc);
    }
    if (hull.size() < 2 || hull.size() > kMostDiscs) return {};
    return hull;
}

std::vector<Disc> sum_of_discs(const std::vector<Disc>& a, const std::vector<Disc>& b) {
    constexpr std::size_t kMostSums = 10000;
    std::vector<Disc> sums;
    if (a.size() * b.size() > kMostSums) return sums;
    for (const Disc& p : a) {
        for (const Disc& q : b) {
            sums.push_back({{p.center[0] + q.center[0], p.center[1] + q.center[1]}, p.radius + q.radius});
        }
    }
    return sums;
}

}  // namespace mortise::model_reader
