// See polygon_unions.hpp.
#include "host/model/outlines/polygon_unions.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kFewest = 3;  ///< polygons; formulas of fewer are as good

struct Operand {
    std::uint32_t node;
    FlatMap map;
};

/// What the union `root` unites, through unions and maps below it.
std::vector<Operand> operands_of(const FlatTree& tree, std::uint32_t root) {
    std::vector<Operand> found;
    std::vector<Operand> open = {{root, kFlatIdentity}};
    while (!open.empty()) {
        const Operand operand = open.back();
        open.pop_back();
        const FlatNode& node = tree.nodes[operand.node];
        const bool maps = node.op == FlatNode::Op::kTransform;
        if (!maps && node.op != FlatNode::Op::kUnion) {
            found.push_back(operand);
            continue;
        }
        const FlatMap map = maps ? compose(operand.map, node.map) : operand.map;
        for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
            open.push_back({*child, map});
        }
    }
    return found;
}

bool is_polygon(const FlatNode& node) {
    return node.op == FlatNode::Op::kContours && node.discs.empty() && !node.contours.empty();
}

/// Polygons whose corners agree where they round to the same place of the lattice, in groups with common
/// corners.
class Groups {
  public:
    explicit Groups(std::vector<Contours> polygons) : lattice_(reach_of(polygons)) {
        std::vector<std::size_t> leader(polygons.size());
        std::iota(leader.begin(), leader.end(), std::size_t{0});
        const auto find = [&](std::size_t i) {
            while (leader[i] != i) i = leader[i] = leader[leader[i]];
            return i;
        };
        for (std::size_t i = 0; i < polygons.size(); ++i) {
            for (auto& loop : polygons[i]) {
                for (Vec2& point : loop) {
                    const auto& [corner, owner] =
                        corners_.emplace(place(point), std::pair(point, i)).first->second;
                    point = corner;
                    leader[find(i)] = find(owner);
                }
            }
        }
        for (std::size_t i = 0; i < polygons.size(); ++i) {
            Contours& loops = loops_[find(i)];
            std::move(polygons[i].begin(), polygons[i].end(), std::back_inserter(loops));
        }
    }

    std::size_t count() const { return loops_.size(); }
    /// What the polygons of each group cover.
    std::vector<Contours> united() const;

  private:
    using Place = std::pair<long long, long long>;

    static double reach_of(const std::vector<Contours>& polygons) {
        double reach = 0;
        for (const Contours& loops : polygons) {
            for (const auto& loop : loops) {
                for (const Vec2& p : loop) reach = std::max({reach, std::fabs(p[0]), std::fabs(p[1])});
            }
        }
        return reach;
    }
    Place place(const Vec2& point) const {
        return {std::llround(point[0] / lattice_.step()), std::llround(point[1] / lattice_.step())};
    }

    PolygonLattice lattice_;
    std::map<Place, std::pair<Vec2, std::size_t>> corners_;  ///< and the first polygon that has it
    std::map<std::size_t, Contours> loops_;                  ///< of each group
};

/// Loops with the same winding numbers, without the edges that two of them share in opposite directions:
/// Clipper may leave such neighbours apart. Returns whether there were any.
bool drop_shared_edges(Contours& loops) {
    std::map<Vec2, std::vector<Vec2>> next;  // ends of the edges from a corner
    std::size_t edges = 0;
    std::size_t dropped = 0;
    for (const auto& loop : loops) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2& a = loop[i];
            const Vec2& b = loop[(i + 1) % loop.size()];
            std::vector<Vec2>& back = next[b];
            const auto opposite = std::find(back.begin(), back.end(), a);
            if (opposite != back.end()) {
                back.erase(opposite);
                ++dropped;
            } else {
                next[a].push_back(b);
                ++edges;
            }
        }
    }
    if (dropped == 0) return false;
    edges -= dropped;
    loops.clear();
    for (auto start = next.begin(); edges > 0;) {
        if (start->second.empty()) {
            ++start;
            continue;
        }
        // As many edges end at a corner as begin there, so the walk ends where it began.
        std::vector<Vec2> loop;
        for (Vec2 at = start->first; loop.empty() || at != start->first; --edges) {
            loop.push_back(at);
            std::vector<Vec2>& ends = next[at];
            at = ends.back();
            ends.pop_back();
        }
        loops.push_back(std::move(loop));
    }
    return true;
}

std::vector<Contours> Groups::united() const {
    std::vector<Contours> result;
    for (const auto& [leader, polygons] : loops_) {
        Contours loops = polygons;
        // Parts of the loops may wind backwards once edges are gone, so they are united at once.
        LatticePaths paths = drop_shared_edges(loops) ? lattice_.rounded(loops) : lattice_.wound_paths(loops);
        for (std::size_t before = paths.size() + 1; paths.size() < before;) {
            before = paths.size();
            paths = lattice_.combined(FlatNode::Op::kUnion, {std::move(paths)});
        }
        result.push_back(lattice_.contours(paths));
        for (auto& loop : result.back()) {
            for (Vec2& point : loop) {
                const auto corner = corners_.find(place(point));
                if (corner != corners_.end()) point = corner->second.first;
            }
        }
    }
    return result;
}

/// Unites polygons of the union `root` that have common corners.
void unite(FlatTree& tree, std::uint32_t root) {
    std::vector<Contours> polygons;
    std::vector<std::uint32_t> children;
    for (const Operand& operand : operands_of(tree, root)) {
        const FlatNode& node = tree.nodes[operand.node];
        if (is_polygon(node)) {
            polygons.push_back(mapped(node.contours, operand.map));
        } else {
            children.push_back(tree.add_transform(operand.map, operand.node));
        }
    }
    const std::size_t count = polygons.size();
    if (count < kFewest) return;
    const Groups groups(std::move(polygons));
    if (groups.count() == count) return;
    for (Contours& outline : groups.united()) {
        FlatNode node;
        node.op = FlatNode::Op::kContours;
        node.contours = std::move(outline);
        children.push_back(tree.add(std::move(node)));
    }
    tree.nodes[root].children = std::move(children);
}

}  // namespace

void unite_polygons(FlatTree& tree, std::uint32_t root) {
    std::vector<std::uint32_t> open = {root};
    while (!open.empty()) {
        const std::uint32_t node = open.back();
        open.pop_back();
        if (tree.nodes[node].op == FlatNode::Op::kDifference && tree.nodes[node].children.size() > kFewest) {
            const std::vector<std::uint32_t> children = tree.nodes[node].children;
            const std::uint32_t others =
                tree.add_operation(FlatNode::Op::kUnion, {children.begin() + 1, children.end()});
            tree.nodes[node].children = {children[0], others};
        }
        if (tree.nodes[node].op == FlatNode::Op::kUnion) unite(tree, node);
        const std::vector<std::uint32_t>& children = tree.nodes[node].children;
        open.insert(open.end(), children.begin(), children.end());
    }
}

}  // namespace mortise::model_reader
