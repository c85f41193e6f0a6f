// A tree of plane shapes: what the 2D nodes of a .csg file are until an extrusion makes solids of them.
//
// Boolean operations commute with extrusion, so the tree is kept as it is: circles stay circles. Only nodes
// that need the outline itself (offset, hull, ...) turn a subtree into polygons (polygons.hpp).
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// Affine map of the plane, row-major 2×3, column vectors.
using FlatMap = std::array<double, 6>;

inline constexpr FlatMap kFlatIdentity = {1, 0, 0, 0, 1, 0};

/// first, then second.
FlatMap compose(const FlatMap& second, const FlatMap& first);
Vec2 image_of(const FlatMap& map, const Vec2& point);
double determinant(const FlatMap& map);

struct Box2 {
    Vec2 min{};
    Vec2 max{};
    bool is_empty() const { return !(min[0] < max[0] && min[1] < max[1]); }
};

struct FlatNode {
    enum class Op : std::uint8_t {
        kCircle,    ///< true circle about the origin
        kContours,  ///< polygons
        kUnion,
        kIntersection,
        kDifference,  ///< the first child minus all others
        kTransform,   ///< exactly one child, mapped by `map` (regular)
    };
    Op op = Op::kUnion;
    std::vector<std::uint32_t> children;
    double radius = 0;  ///< kCircle
    int fragments = 0;  ///< kCircle: sides of the polygon that stands for it where one is needed
    /// kContours: simple loops that do not cross, each outer one counter-clockwise and followed by its holes,
    /// which are clockwise.
    Contours contours{};
    /// kContours: not empty if the shape is the hull of these, and `contours` only stands for it where a
    /// polygon is needed.
    std::vector<Disc> discs{};
    FlatMap map = kFlatIdentity;  ///< kTransform
};

struct FlatTree {
    std::vector<FlatNode> nodes;

    std::uint32_t add(FlatNode node);
    std::uint32_t add_circle(double radius, int fragments);
    /// Any loops, even-odd; an empty area makes a node without loops.
    std::uint32_t add_contours(const Contours& loops);
    std::uint32_t add_operation(FlatNode::Op op, std::vector<std::uint32_t> children);
    std::uint32_t add_transform(const FlatMap& map, std::uint32_t child);
};

/// Folds a subtree from its leaves: leaf(node, map to the root's frame) and combine(operation, values) make
/// values. The stack is explicit: any depth.
template <typename Value, typename Leaf, typename Combine>
Value fold(const FlatTree& tree, std::uint32_t root, Leaf&& leaf, Combine&& combine) {
    struct Frame {
        std::uint32_t node;
        FlatMap map;
        std::size_t next = 0;
        std::vector<Value> values;
    };
    std::vector<Frame> stack;
    stack.push_back({root, kFlatIdentity, 0, {}});
    while (true) {
        Frame& frame = stack.back();
        const FlatNode& node = tree.nodes[frame.node];
        if (frame.next < node.children.size()) {
            const std::uint32_t child = node.children[frame.next++];
            const bool maps = node.op == FlatNode::Op::kTransform;
            const FlatMap map = maps ? compose(frame.map, node.map) : frame.map;
            stack.push_back({child, map, 0, {}});
            continue;
        }
        const bool is_leaf = node.op == FlatNode::Op::kCircle || node.op == FlatNode::Op::kContours;
        Value value = is_leaf                               ? leaf(node, frame.map)
                      : node.op == FlatNode::Op::kTransform ? std::move(frame.values.at(0))
                                                            : combine(node.op, std::move(frame.values));
        stack.pop_back();
        if (stack.empty()) return value;
        stack.back().values.push_back(std::move(value));
    }
}

/// A box that holds the shape: exact for unions of leaves, else possibly larger.
Box2 flat_bounds(const FlatTree& tree, std::uint32_t root);

/// Whether flat_bounds is exact: the tree has unions, maps and leaves only.
bool has_exact_bounds(const FlatTree& tree, std::uint32_t root);

/// The shape as polygons, ordered and oriented as FlatNode::contours; circles become regular polygons with a
/// vertex on their +x axis.
Contours to_contours(const FlatTree& tree, std::uint32_t root);

/// The loops of a kContours leaf under a map, orientation kept.
Contours mapped(const Contours& contours, const FlatMap& map);

/// Regular polygon with vertex 0 on +x, exact at multiples of 30°.
std::vector<Vec2> regular_polygon(double radius, int sides);

/// Cosine and sine of degrees, exact where they are rational.
double cosine_of_degrees(double degrees);
double sine_of_degrees(double degrees);

}  // namespace mortise::model_reader
