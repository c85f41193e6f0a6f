// Polygons with common corners become one shape, against membership by the definition of the tree.
#include "host/model/outlines/polygon_unions.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "host/common/random.hpp"
#include "mortise/model.hpp"
#include "tests/model/even_odd.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;
using namespace mortise::model_reader;

namespace {

using Op = FlatNode::Op;

bool holds(const FlatTree& tree, std::uint32_t root, const Vec2& p) {
    const FlatNode& node = tree.nodes[root];
    const auto child = [&](std::size_t i) { return holds(tree, node.children[i], p); };
    switch (node.op) {
        case Op::kCircle: return std::hypot(p[0], p[1]) <= node.radius;
        case Op::kContours: return test::even_odd(node.contours, p);
        case Op::kTransform: {
            const double d = determinant(node.map);
            const Vec2 q = {p[0] - node.map[2], p[1] - node.map[5]};
            return holds(tree, node.children[0],
                         {(node.map[4] * q[0] - node.map[1] * q[1]) / d,
                          (node.map[0] * q[1] - node.map[3] * q[0]) / d});
        }
        default: break;
    }
    bool result = node.op == Op::kIntersection;
    for (std::size_t i = 0; i < node.children.size(); ++i) {
        if (node.op == Op::kUnion) result = result || child(i);
        if (node.op == Op::kIntersection) result = result && child(i);
        if (node.op == Op::kDifference) result = i == 0 ? child(i) : result && !child(i);
    }
    return result;
}

std::size_t leaves_of(const FlatTree& tree, std::uint32_t root) {
    return fold<std::size_t>(
        tree, root, [](const FlatNode&, const FlatMap&) { return std::size_t{1}; },
        [](Op, const std::vector<std::size_t>& values) {
            std::size_t sum = 0;
            for (const std::size_t value : values) sum += value;
            return sum;
        });
}

std::uint32_t random_tree(FlatTree& tree, Random& random, int depth) {
    const auto number = [&](double low, double high) { return low + (high - low) * random.uniform(); };
    if (depth == 0) {
        if (number(0, 1) < 0.15) return tree.add_circle(number(0.2, 0.6), 30);
        const int corners = static_cast<int>(number(3, 8));
        std::vector<Vec2> loop;
        for (int i = 0; i < corners; ++i) {
            const double angle = 2 * 3.14159265358979323846 * i / corners;
            const double radius = number(0.2, 0.7);
            loop.push_back({radius * std::cos(angle), radius * std::sin(angle)});
        }
        const bool is_wedge = number(0, 1) < 0.9;
        if (is_wedge) loop[0] = {0, 0};  // as its neighbours about the origin
        Contours loops = {loop};
        if (!is_wedge && number(0, 1) < 0.3) {
            for (Vec2& point : loop) point = {point[0] / 2, point[1] / 2};
            loops.push_back(loop);
        }
        return tree.add_contours(loops);
    }
    static const Op kOps[] = {Op::kUnion, Op::kUnion, Op::kUnion, Op::kDifference, Op::kIntersection};
    const Op op = kOps[static_cast<std::size_t>(number(0, 5))];
    std::vector<std::uint32_t> children;
    const int count = op == Op::kIntersection ? 2 : static_cast<int>(number(2, 7));
    for (int i = 0; i < count; ++i) {
        const std::uint32_t child = random_tree(tree, random, number(0, 1) < 0.6 ? 0 : depth - 1);
        const double angle = number(-3, 3);
        const double mirror = number(0, 1) < 0.3 ? -1 : 1;
        const double shift = number(0, 1) < 0.9 ? 0 : number(-1, 1);
        children.push_back(tree.add_transform({std::cos(angle), -mirror * std::sin(angle), shift,
                                               std::sin(angle), mirror * std::cos(angle), shift / 2},
                                              child));
    }
    return tree.add_operation(op, children);
}

/// A fan of triangles about the origin, turned by `turn`, in tree `tree`; `outline`: its corners.
std::uint32_t fan(FlatTree& tree, std::size_t count, double turn, std::vector<Vec2>& outline) {
    outline.clear();
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = turn + 2 * 3.14159265358979323846 * static_cast<double>(i) / double(count);
        const double radius = 3 + std::sin(3 * angle);
        outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i < count; ++i) {
        triangles.push_back(tree.add_contours({{outline[i], outline[(i + 1) % count], {0, 0}}}));
    }
    return tree.add_operation(Op::kUnion, triangles);
}

}  // namespace

TEST_CASE("united polygons: random trees keep their points") {
    Random random(5);
    int wrong = 0;
    std::size_t before = 0;
    std::size_t after = 0;
    for (int model = 0; model < 300; ++model) {
        FlatTree tree;
        const std::uint32_t root = random_tree(tree, random, 3);
        FlatTree united = tree;
        unite_polygons(united, root);
        before += leaves_of(tree, root);
        after += leaves_of(united, root);
        for (int i = 0; i < 300; ++i) {
            const Vec2 p = {4 * random.uniform() - 2, 4 * random.uniform() - 2};
            wrong += holds(tree, root, p) != holds(united, root, p) ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(6 * after < 5 * before);
}

TEST_CASE("united polygons: a fan is its outline, with the corners it had") {
    for (const std::size_t count : {5u, 12u, 24u, 36u, 100u}) {
        for (const double turn : {0.0, 0.3, 1.0}) {
            CAPTURE(count);
            CAPTURE(turn);
            FlatTree tree;
            std::vector<Vec2> outline;
            const std::uint32_t root = fan(tree, count, turn, outline);
            unite_polygons(tree, root);
            REQUIRE(tree.nodes[root].children.size() == 1);
            const FlatNode& all = tree.nodes[tree.nodes[root].children[0]];
            REQUIRE(all.contours.size() == 1);
            std::vector<Vec2> found = all.contours[0];
            std::sort(found.begin(), found.end());
            std::sort(outline.begin(), outline.end());
            CHECK(found == outline);
        }
    }
}

TEST_CASE("united polygons: tiles with common edges, holes, and polygons across them") {
    Random random(11);
    const auto number = [&](double low, double high) { return low + (high - low) * random.uniform(); };
    int wrong = 0;
    for (int model = 0; model < 200; ++model) {
        FlatTree tree;
        constexpr std::size_t kSide = 6;
        std::array<std::array<Vec2, kSide + 1>, kSide + 1> corner;
        for (std::size_t i = 0; i <= kSide; ++i) {
            for (std::size_t j = 0; j <= kSide; ++j) {
                corner[i][j] = {static_cast<double>(i) + number(-0.2, 0.2),
                                static_cast<double>(j) + number(-0.2, 0.2)};
            }
        }
        // Each tile is moved there and back by a map of its own, so that corners agree but for rounding.
        const double angle = number(-3, 3);
        const FlatMap turn = {std::cos(angle), -std::sin(angle), 1, std::sin(angle), std::cos(angle), 2};
        const FlatMap back = {std::cos(angle),  std::sin(angle), -std::cos(angle) - 2 * std::sin(angle),
                              -std::sin(angle), std::cos(angle), std::sin(angle) - 2 * std::cos(angle)};
        std::vector<std::uint32_t> tiles;
        const auto add = [&](std::vector<Vec2> loop) {
            const bool is_turned = number(0, 1) < 0.5;
            for (Vec2& point : loop) point = is_turned ? image_of(turn, point) : point;
            const std::uint32_t tile = tree.add_contours({loop});
            tiles.push_back(is_turned ? tree.add_transform(back, tile) : tile);
        };
        for (std::size_t i = 0; i < kSide; ++i) {
            for (std::size_t j = 0; j < kSide; ++j) {
                if (number(0, 1) < 0.25) continue;
                add({corner[i][j], corner[i + 1][j], corner[i + 1][j + 1]});
                add({corner[i][j], corner[i + 1][j + 1], corner[i][j + 1]});
            }
        }
        for (int i = 0; i < 3; ++i) {
            add({{number(0, 6), number(0, 6)}, {number(0, 6), number(0, 6)}, {number(0, 6), number(0, 6)}});
        }
        const std::uint32_t root = tree.add_operation(Op::kUnion, tiles);
        FlatTree united = tree;
        unite_polygons(united, root);
        for (int i = 0; i < 300; ++i) {
            const Vec2 p = {number(-0.5, 6.5), number(-0.5, 6.5)};
            wrong += holds(tree, root, p) != holds(united, root, p) ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("united polygons: few, or those without common corners, stay what they are") {
    FlatTree tree;
    const auto square = [&](double x, double y) {
        return tree.add_transform({1, 0, x, 0, 1, y}, tree.add_contours({{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}));
    };
    const std::uint32_t two = tree.add_operation(Op::kUnion, {square(0, 0), square(0.5, 0.5)});
    const std::uint32_t apart =
        tree.add_operation(Op::kUnion, {square(0, 0), square(0.5, 0.5), square(2, 0), square(0, 2)});
    const std::uint32_t some =
        tree.add_operation(Op::kUnion, {square(0, 0), square(1, 0), square(3, 0), tree.add_circle(1, 30)});
    for (const std::uint32_t root : {two, apart, some}) unite_polygons(tree, root);
    CHECK(leaves_of(tree, two) == 2);
    CHECK(leaves_of(tree, apart) == 4);
    CHECK(leaves_of(tree, some) == 3);
}

TEST_CASE("united polygons: many of them take no time of their square") {
    FlatTree tree;
    std::vector<std::uint32_t> squares;
    for (int i = 0; i < 40000; ++i) {
        const double x = i % 200;
        const double y = i / 200;
        squares.push_back(tree.add_contours({{{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}}));
    }
    const std::uint32_t root = tree.add_operation(Op::kUnion, squares);
    const auto start = std::chrono::steady_clock::now();
    unite_polygons(tree, root);
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < 20);
    REQUIRE(leaves_of(tree, root) == 1);
    Contours loops = tree.nodes[tree.nodes[root].children[0]].contours;
    for (auto& loop : loops) std::sort(loop.begin(), loop.end());
    CHECK(loops == Contours{{{0, 0}, {0, 200}, {200, 0}, {200, 200}}});
}

TEST_CASE("united polygons: what a difference takes away, and revolved ones") {
    const std::string teeth =
        "polygon(points = [[2,0],[3,0],[3,1]]); polygon(points = [[2,0],[3,1],[2,1]]); "
        "polygon(points = [[2,1],[3,1],[2.5,2]]);";
    const auto in_teeth = [](double x, double y) {
        if (x < 2 || x > 3 || y < 0) return false;
        return y <= 1 || y <= 2 - 2 * std::fabs(x - 2.5);
    };
    const Model turned = parse_model("rotate_extrude() { " + teeth + " }", "csg", "part.csg");
    const Model cut =
        parse_model("linear_extrude(height = 1) { difference() { square(size = [4, 4]); " + teeth + " } }",
                    "csg", "part.csg");
    Random random(9);
    int wrong = 0;
    for (int i = 0; i < 4000; ++i) {
        const Vec3 p = {4 * random.uniform(), 4 * random.uniform(), random.uniform()};
        wrong += (test::region_at(cut, p) == 1) != !in_teeth(p[0], p[1]) ? 1 : 0;
        const Vec3 q = {8 * random.uniform() - 4, 8 * random.uniform() - 4, 3 * random.uniform() - 0.5};
        wrong += (test::region_at(turned, q) == 1) != in_teeth(std::hypot(q[0], q[1]), q[2]) ? 1 : 0;
    }
    CHECK(wrong == 0);
}
