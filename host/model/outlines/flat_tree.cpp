#include "host/model/outlines/flat_tree.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

const Box2 kNothing = {{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};

Box2 leaf_bounds(const FlatNode& node, const FlatMap& map) {
    Box2 box = kNothing;
    if (node.op == FlatNode::Op::kCircle) {
        for (std::size_t k = 0; k < 2; ++k) {
            const double extent = node.radius * std::hypot(map[3 * k], map[3 * k + 1]);
            box.min[k] = map[3 * k + 2] - extent;
            box.max[k] = map[3 * k + 2] + extent;
        }
        return box;
    }
    const auto add = [&](const Vec2& point, double radius) {
        const Vec2 image = image_of(map, point);
        for (std::size_t k = 0; k < 2; ++k) {
            const double extent = radius * std::hypot(map[3 * k], map[3 * k + 1]);
            box.min[k] = std::min(box.min[k], image[k] - extent);
            box.max[k] = std::max(box.max[k], image[k] + extent);
        }
    };
    for (const auto& loop : node.contours) {
        for (const Vec2& point : loop) add(point, 0);
    }
    for (const Disc& disc : node.discs) add(disc.center, disc.radius);
    return box;
}

Box2 combined_bounds(FlatNode::Op op, const std::vector<Box2>& boxes) {
    if (boxes.empty()) return kNothing;
    Box2 result = boxes[0];
    if (op == FlatNode::Op::kDifference) return result;
    const bool is_union = op == FlatNode::Op::kUnion;
    for (const Box2& box : boxes) {
        for (std::size_t k = 0; k < 2; ++k) {
            result.min[k] =
                is_union ? std::min(result.min[k], box.min[k]) : std::max(result.min[k], box.min[k]);
            result.max[k] =
                is_union ? std::max(result.max[k], box.max[k]) : std::min(result.max[k], box.max[k]);
        }
    }
    return result.is_empty() ? kNothing : result;
}

}  // namespace

FlatMap compose(const FlatMap& second, const FlatMap& first) {
    FlatMap result{};
    for (std::size_t row = 0; row < 2; ++row) {
        const double* m = &second[3 * row];
        for (std::size_t column = 0; column < 3; ++column) {
            result[3 * row + column] = m[0] * first[column] + m[1] * first[3 + column];
        }
        result[3 * row + 2] += m[2];
    }
    return result;
}

Vec2 image_of(const FlatMap& map, const Vec2& p) {
    return {map[0] * p[0] + map[1] * p[1] + map[2], map[3] * p[0] + map[4] * p[1] + map[5]};
}

double determinant(const FlatMap& map) { return map[0] * map[4] - map[1] * map[3]; }

std::uint32_t FlatTree::add(FlatNode node) {
    nodes.push_back(std::move(node));
    return static_cast<std::uint32_t>(nodes.size() - 1);
}

std::uint32_t FlatTree::add_circle(double radius, int fragments) {
    FlatNode node;
    node.op = FlatNode::Op::kCircle;
    node.radius = radius;
    node.fragments = fragments;
    return add(std::move(node));
}

std::uint32_t FlatTree::add_contours(const Contours& loops) {
    FlatNode node;
    node.op = FlatNode::Op::kContours;
    node.contours = normalised(loops);
    return add(std::move(node));
}

std::uint32_t FlatTree::add_operation(FlatNode::Op op, std::vector<std::uint32_t> children) {
    FlatNode node;
    node.op = op;
    node.children = std::move(children);
    return add(std::move(node));
}

std::uint32_t FlatTree::add_transform(const FlatMap& map, std::uint32_t child) {
    FlatNode node;
    node.op = FlatNode::Op::kTransform;
    node.children = {child};
    node.map = map;
    return add(std::move(node));
}

Box2 flat_bounds(const FlatTree& tree, std::uint32_t root) {
    return fold<Box2>(tree, root, leaf_bounds, combined_bounds);
}

bool has_exact_bounds(const FlatTree& tree, std::uint32_t root) {
    return fold<char>(
               tree, root, [](const FlatNode&, const FlatMap&) { return '\1'; },
               [](FlatNode::Op op, const std::vector<char>& values) {
                   return op == FlatNode::Op::kUnion && std::count(values.begin(), values.end(), '\0') == 0
                              ? '\1'
                              : '\0';
               }) != 0;
}

Contours to_contours(const FlatTree& tree, std::uint32_t root) {
    if (tree.nodes[root].op == FlatNode::Op::kContours) return tree.nodes[root].contours;
    // The largest coordinate of any leaf, so that one lattice serves all of them.
    const double reach = fold<double>(
        tree, root,
        [](const FlatNode& node, const FlatMap& map) {
            const Box2 box = leaf_bounds(node, map);
            double largest = 0;
            for (std::size_t k = 0; k < 2 && !box.is_empty(); ++k) {
                largest = std::max({largest, std::fabs(box.min[k]), std::fabs(box.max[k])});
            }
            return largest;
        },
        [](FlatNode::Op, const std::vector<double>& values) {
            return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
        });
    const PolygonLattice lattice(reach);
    return lattice.contours(fold<LatticePaths>(
        tree, root,
        [&](const FlatNode& node, const FlatMap& map) {
            const bool is_circle = node.op == FlatNode::Op::kCircle;
            return lattice.paths(mapped(
                is_circle ? Contours{regular_polygon(node.radius, node.fragments)} : node.contours, map));
        },
        [&](FlatNode::Op op, std::vector<LatticePaths> values) {
            return lattice.combined(op, std::move(values));
        }));
}

Contours mapped(const Contours& contours, const FlatMap& map) {
    Contours result = contours;
    if (map == kFlatIdentity) return result;
    for (auto& loop : result) {
        for (Vec2& point : loop) point = image_of(map, point);
        if (determinant(map) < 0) std::reverse(loop.begin(), loop.end());
    }
    return result;
}

std::vector<Vec2> regular_polygon(double radius, int sides) {
    std::vector<Vec2> points;
    for (int j = 0; j < sides; ++j) {
        const double degrees = 360.0 * j / sides;
        points.push_back({radius * cosine_of_degrees(degrees), radius * sine_of_degrees(degrees)});
    }
    return points;
}

double cosine_of_degrees(double degrees) {
    degrees = std::fmod(std::fabs(degrees), 360.0);
    if (degrees > 180) degrees = 360 - degrees;
    if (degrees > 90) return -cosine_of_degrees(180 - degrees);
    if (degrees == 90) return 0;
    if (degrees == 60) return 0.5;
    // Sine for the steeper half, so that cos 45° equals sin 45° bit for bit.
    return degrees > 45 ? std::sin((90 - degrees) * kRadians) : std::cos(degrees * kRadians);
}
double sine_of_degrees(double degrees) { return cosine_of_degrees(degrees - 90); }

}  // namespace mortise::model_reader
