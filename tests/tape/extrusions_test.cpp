// Extrusions as tapes: twisted solids against the definition, and polygons with many edges.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "host/common/constants.hpp"
#include "host/common/random.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"

namespace mortise::tape {
namespace {

using Pair = std::array<double, 2>;

/// Deepest stack of a postfix tape.
int depth_of(const std::vector<std::uint32_t>& words) {
    int depth = 0;
    int deepest = 0;
    for (const std::uint32_t word : words) {
        const auto operation = tape_operation(word);
        if (operation == kTapeLiteral) ++depth;
        if (operation == kTapeAnd || operation == kTapeOr || operation == kTapeSelect) --depth;
        deepest = std::max(deepest, depth);
    }
    return deepest;
}

void compare(const std::string& text, const Vec3& min, double side,
             const std::function<bool(double, double, double)>& oracle) {
    CAPTURE(text);
    const CompiledModel compiled = compile(parse_model(text, "csg", "part.csg"));
    const BoundModel bound = bind(compiled, min, side);
    Random random(5);
    int wrong = 0;
    int inside = 0;
    int out_of_bounds = 0;
    for (int i = 0; i < 20000; ++i) {
        Vec3 local{};
        Vec3 p{};
        for (std::size_t k = 0; k < 3; ++k) {
            local[k] = random.uniform();
            p[k] = min[k] + side * local[k];
        }
        const bool expected = oracle(p[0], p[1], p[2]);
        wrong += (region_at(bound, local[0], local[1], local[2]) == 1) != expected ? 1 : 0;
        inside += expected ? 1 : 0;
        for (std::size_t k = 0; k < 3 && expected; ++k) {
            out_of_bounds += p[k] < compiled.bounds.min[k] || p[k] > compiled.bounds.max[k] ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(inside > 50);
    CHECK(out_of_bounds == 0);
}

/// The point of the shape that twist and scale send to (x, y) at the height t (0 to 1).
Pair back(double x, double y, double t, double twist, double scale_x, double scale_y) {
    const double angle = twist * t * kPi / 180;
    const double u = x / (1 + (scale_x - 1) * t);
    const double v = y / (1 + (scale_y - 1) * t);
    return {u * std::cos(angle) - v * std::sin(angle), u * std::sin(angle) + v * std::cos(angle)};
}

}  // namespace

TEST_CASE("a positive twist turns clockwise on the way up") {
    // At the top the arm along +x points to -y.
    const auto model = compile(parse_model(
        "linear_extrude(height = 1, twist = 90) { polygon(points = [[0,-0.1],[2,-0.1],[2,0.1],[0,0.1]]); }",
        "csg", "part.csg"));
    const BoundModel bound = bind(model, {-4, -4, -4}, 8);
    const auto at = [&](double x, double y, double z) {
        return region_at(bound, (x + 4) / 8, (y + 4) / 8, (z + 4) / 8);
    };
    CHECK(at(1.5, 0, 0.01) == 1);
    CHECK(at(0, -1.5, 0.99) == 1);
    CHECK(at(0, 1.5, 0.99) == 0);
    CHECK(at(1, -1, 0.5) == 1);
}

TEST_CASE("twisted and scaled solids are those of the definition") {
    const auto in_l = [](const Pair& p) {
        return p[0] >= 0 && p[0] <= 2 && p[1] >= 0 && p[1] <= 2 && (p[0] <= 1 || p[1] <= 1);
    };
    const std::string l = "polygon(points = [[0,0],[2,0],[2,1],[1,1],[1,2],[0,2]]);";
    const std::string ellipse = "multmatrix([[2,0,0,1],[1,1,0,0],[0,0,1,0],[0,0,0,1]]) { circle(r = 0.7); }";
    const auto in_ellipse = [](const Pair& p) {
        const double u = (p[0] - 1) / 2;
        return std::hypot(u, p[1] - u) <= 0.7;
    };
    for (const double twist : {0.0, 75.0, -400.0}) {
        for (const Pair& scale : {Pair{1, 1}, Pair{0.4, 0.4}, Pair{1.5, 0.5}, Pair{0, 1}}) {
            const std::string head =
                "linear_extrude(height = 2, center = true, twist = " + std::to_string(twist) + ", scale = [" +
                std::to_string(scale[0]) + "," + std::to_string(scale[1]) + "]) { ";
            const auto solid = [&](const auto& shape) {
                return [&](double x, double y, double z) {
                    const double t = (z + 1) / 2;
                    return std::fabs(z) <= 1 && shape(back(x, y, t, twist, scale[0], scale[1]));
                };
            };
            compare(head + l + " }", {-4, -4, -4}, 8, solid(in_l));
            compare(head + ellipse + " }", {-4, -4, -4}, 8, solid(in_ellipse));
            compare(head + "circle(r = 2); }", {-4, -4, -4}, 8,
                    solid([](const Pair& p) { return std::hypot(p[0], p[1]) <= 2; }));
        }
    }
    // An ellipse that is off the axis, turned about it.
    compare(
        "rotate_extrude() { multmatrix([[1,0,0,2.5],[0.5,1,0,0],[0,0,1,0],[0,0,0,1]]) { circle(r = 1); } }",
        {-4, -4, -4}, 8, [](double x, double y, double z) {
            const double u = std::hypot(x, y) - 2.5;
            return std::hypot(u, z - 0.5 * u) <= 1;
        });
    // A spindle's core: the part of the circle beyond the axis.
    compare(
        "rotate_extrude() { intersection() { multmatrix([[1,0,0,-1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { "
        "circle(r = 3); } multmatrix([[1,0,0,0],[0,1,0,-5],[0,0,1,0],[0,0,0,1]]) { square(size = 10); } } }",
        {-4, -4, -4}, 8,
        [](double x, double y, double z) { return std::hypot(std::hypot(x, y) + 1, z) <= 3; });
}

TEST_CASE("polygons of 5,000 edges keep tapes shallow") {
    Random random(6);
    std::string star;
    std::string comb = "[-1,-1],[2501,-1],[2501,0]";
    for (int i = 0; i < 5000; ++i) {
        const double angle = 2 * kPi * i / 5000;
        const double r = 1 + random.uniform();
        star += (i == 0 ? "[" : ",[") + std::to_string(r * std::cos(angle)) + "," +
                std::to_string(r * std::sin(angle)) + "]";
    }
    for (int i = 2500; i-- > 0;) {
        comb +=
            ",[" + std::to_string(i + 0.5) + "," + std::to_string(i + 1) + "],[" + std::to_string(i) + ",0]";
    }
    ReadOptions exact;  // else some edges are curves
    exact.facets = Facets::kExact;
    for (const std::string& points : {star, comb}) {
        const CompiledModel model = compile(parse_model(
            "linear_extrude(height = 1, scale = [1, 0.5]) { polygon(points = [" + points + "]); }", "csg",
            "part.csg", exact));
        CHECK(model.surfaces.size() >= 5000);
        CHECK(model.surfaces.size() <= 5006);
        CHECK(depth_of(model.tape) <= kTapeStack);
        CHECK(model.surface_names.size() == 3);
    }
}

}  // namespace mortise::tape
