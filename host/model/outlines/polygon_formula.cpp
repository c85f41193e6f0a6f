// The recursion of the paper: a chain of edges whose first and last one are prolonged to infinity is split at
// a vertex of its convex hull, where prolonging both edges again crosses nothing. The plane left of the
// chain is then the intersection of what is left of both parts if the chain turns left there, else the
// union.
//
// A vertex of the hull is found in one pass: the rays at both ends span a cone, and a vertex that is
// farthest in the direction opposite to the cone's bisector lies on the hull. Cost: edges times depth of the
// recursion, which is logarithmic but for made-up polygons.
#include "host/model/outlines/polygon_formula.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mortise::model_reader {
namespace {

using Node = PolygonFormula::Node;

Vec2 direction(const Vec2& from, const Vec2& to) {
    const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
    return {(to[0] - from[0]) / length, (to[1] - from[1]) / length};
}

class Splitter {
  public:
    explicit Splitter(const std::vector<Vec2>& loop) : loop_(loop) {}

    PolygonFormula run() {
        // Both extreme vertices along x are on the hull, and convex: the two chains between them intersect.
        const auto by_x = std::minmax_element(loop_.begin(), loop_.end());
        const std::size_t low = static_cast<std::size_t>(by_x.first - loop_.begin());
        const std::size_t high = static_cast<std::size_t>(by_x.second - loop_.begin());
        const std::size_t across = (high + loop_.size() - low) % loop_.size();
        std::vector<Task> tasks;
        tasks.push_back({Task::kAnd, 0, 0});
        tasks.push_back({Task::kChain, low, across});
        tasks.push_back({Task::kChain, high, loop_.size() - across});
        std::vector<std::uint32_t> results;
        while (!tasks.empty()) {
            const Task task = tasks.back();
            tasks.pop_back();
            if (task.kind != Task::kChain) {
                const std::uint32_t second = results.back();
                results.pop_back();
                results.back() = join(task.kind == Task::kAnd ? Node::Type::kAnd : Node::Type::kOr,
                                      results.back(), second);
            } else if (task.count == 1) {
                Node edge;
                edge.edge = static_cast<std::uint32_t>(task.first % loop_.size());
                results.push_back(add(std::move(edge)));
            } else {
                const std::size_t before = hull_vertex(task.first, task.count);
                const std::size_t at = task.first + before;
                const Vec2& p = point(at - 1);
                const Vec2& q = point(at);
                const Vec2& r = point(at + 1);
                const double turn = (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
                tasks.push_back({turn > 0 ? Task::kAnd : Task::kOr, 0, 0});
                tasks.push_back({Task::kChain, task.first, before});
                tasks.push_back({Task::kChain, at, task.count - before});
            }
        }
        return compacted(results[0]);
    }

  private:
    /// A chain of `count` edges from vertex `first`, or what joins the last two results.
    struct Task {
        enum Kind { kChain, kAnd, kOr } kind;
        std::size_t first;
        std::size_t count;
    };

    const Vec2& point(std::size_t i) const { return loop_[i % loop_.size()]; }

    std::uint32_t add(Node node) {
        nodes_.push_back(std::move(node));
        return static_cast<std::uint32_t>(nodes_.size() - 1);
    }

    /// Merges operations of one type; the longer list of children takes the other's.
    std::uint32_t join(Node::Type type, std::uint32_t a, std::uint32_t b) {
        if (nodes_[a].type != type ||
            (nodes_[b].type == type && nodes_[b].children.size() > nodes_[a].children.size())) {
            std::swap(a, b);
        }
        if (nodes_[a].type != type) {
            Node node;
            node.type = type;
            node.children = {a, b};
            return add(std::move(node));
        }
        std::vector<std::uint32_t>& into = nodes_[a].children;
        if (nodes_[b].type == type) {
            into.insert(into.end(), nodes_[b].children.begin(), nodes_[b].children.end());
            nodes_[b].children.clear();
        } else {
            into.push_back(b);
        }
        return a;
    }

    /// How many edges of the chain come before the vertex to split at.
    std::size_t hull_vertex(std::size_t first, std::size_t count) const {
        // From each end into infinity.
        const Vec2 back = direction(point(first + 1), point(first));
        const Vec2 forth = direction(point(first + count - 1), point(first + count));
        Vec2 away = {-(back[0] + forth[0]), -(back[1] + forth[1])};
        if (std::hypot(away[0], away[1]) < 1e-9) {
            // Opposite rays: the hull is a strip, and both its sides will do. Take the one farther from the
            // rays.
            away = {-forth[1], forth[0]};
            double left = 0;
            double right = 0;
            for (std::size_t i = 1; i < count; ++i) {
                const double height = distance_along(away, point(first), point(first + i));
                left = std::max(left, height);
                right = std::max(right, -height);
            }
            if (right > left) away = {-away[0], -away[1]};
        }
        double farthest = 0;
        for (std::size_t i = 1; i < count; ++i) {
            const double distance = distance_along(away, point(first), point(first + i));
            if (i == 1 || distance > farthest) farthest = distance;
        }
        // Among vertices equally far the middle one keeps the recursion shallow.
        std::size_t best = 0;
        for (std::size_t i = 1; i < count; ++i) {
            if (distance_along(away, point(first), point(first + i)) < farthest) continue;
            if (best == 0 || std::max(i, count - i) < std::max(best, count - best)) best = i;
        }
        return best;
    }

    static double distance_along(const Vec2& direction, const Vec2& from, const Vec2& to) {
        return direction[0] * (to[0] - from[0]) + direction[1] * (to[1] - from[1]);
    }

    /// Children first, nothing unused.
    PolygonFormula compacted(std::uint32_t root) {
        std::vector<std::uint32_t> order;  // parents first
        std::vector<std::uint32_t> open = {root};
        while (!open.empty()) {
            const std::uint32_t node = open.back();
            open.pop_back();
            order.push_back(node);
            open.insert(open.end(), nodes_[node].children.begin(), nodes_[node].children.end());
        }
        PolygonFormula formula;
        std::vector<std::uint32_t> place(nodes_.size());
        for (std::size_t i = order.size(); i-- > 0;) {
            Node node = std::move(nodes_[order[i]]);
            for (std::uint32_t& child : node.children) child = place[child];
            place[order[i]] = static_cast<std::uint32_t>(formula.nodes.size());
            formula.nodes.push_back(std::move(node));
        }
        return formula;
    }

    const std::vector<Vec2>& loop_;
    std::vector<Node> nodes_;
};

}  // namespace

PolygonFormula polygon_formula(const std::vector<Vec2>& loop) { return Splitter(loop).run(); }

}  // namespace mortise::model_reader
