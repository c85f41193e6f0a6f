// Polygons: formulas, normal form and the operations on outlines.
#include "host/model/outlines/polygons.hpp"
#include "host/common/constants.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "host/common/random.hpp"
#include "host/model/outlines/polygon_formula.hpp"
#include "tests/model/even_odd.hpp"

using namespace mortise;
using namespace mortise::model_reader;
using test::even_odd;

namespace {

using Loop = std::vector<Vec2>;

bool formula_holds(const PolygonFormula& formula, const Loop& loop, const Vec2& p) {
    std::vector<char> value(formula.nodes.size());
    for (std::size_t i = 0; i < formula.nodes.size(); ++i) {
        const auto& node = formula.nodes[i];
        const auto is_true = [&](std::uint32_t child) { return value[child] != 0; };
        if (node.type == PolygonFormula::Node::Type::kEdge) {
            const Vec2& a = loop[node.edge];
            const Vec2& b = loop[(node.edge + 1) % loop.size()];
            value[i] = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0;
        } else if (node.type == PolygonFormula::Node::Type::kAnd) {
            value[i] = std::all_of(node.children.begin(), node.children.end(), is_true);
        } else {
            value[i] = std::any_of(node.children.begin(), node.children.end(), is_true);
        }
    }
    return value.back() != 0;
}

struct Numbers {
    explicit Numbers(std::uint64_t seed) : random(seed) {}
    double operator()(double low, double high) { return low + (high - low) * random.uniform(); }
    Random random;
};

Loop star(Numbers& random, int count) {
    Loop loop;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * kPi * (i + random(0, 0.9)) / count;
        const double r = random(0.2, 1);
        loop.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    return loop;
}

/// Teeth with flat tops of height `height(i)` on a base.
template <typename Height>
Loop comb(int teeth, Height height) {
    Loop loop = {{-1, -1}, {1, -1}};
    for (int i = teeth; i-- > 0;) {
        const double left = -1 + 2.0 * i / teeth;
        const double right = -1 + 2.0 * (i + 0.5) / teeth;
        if (i != teeth - 1 || right < 1) loop.push_back({right + 0.5 / teeth, 0});
        loop.push_back({right, 0});
        loop.push_back({right, height(i)});
        loop.push_back({left, height(i)});
        if (i > 0) loop.push_back({left, 0});
    }
    loop[2] = {1, 0};
    return normalised({loop}).at(0);
}

Loop spiral(int turns, int per_turn) {
    Loop loop;
    const int count = turns * per_turn;
    const auto at = [&](int i, double shift) {
        const double angle = 2 * kPi * i / per_turn;
        const double r = (i + shift * per_turn) / (count + per_turn);
        return Vec2{r * std::cos(angle), r * std::sin(angle)};
    };
    for (int i = 0; i <= count; ++i) loop.push_back(at(i, 0.9));
    for (int i = count; i >= 0; --i) loop.push_back(at(i, 0.4));
    return loop;
}

/// A square spiral: many edges parallel and in line with each other.
Loop square_spiral(int turns) {
    Loop out;
    Loop back;
    for (int i = 0; i < 4 * turns; ++i) {
        static const Vec2 kCorner[] = {{1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
        const double r = (i / 4) + 1;
        const Vec2& c = kCorner[i % 4];
        const double shift = i % 4 == 3 ? 1 : 0;
        out.push_back({c[0] * r / (turns + 1), c[1] * (r + shift) / (turns + 1)});
        back.push_back({c[0] * (r - 0.4) / (turns + 1), c[1] * (r + shift - 0.4) / (turns + 1)});
    }
    std::reverse(back.begin(), back.end());
    out.insert(out.end(), back.begin(), back.end());
    return out;
}

void check_formula(const std::string& name, Loop loop, int points, Numbers& random) {
    CAPTURE(name);
    if (signed_area(loop) < 0) std::reverse(loop.begin(), loop.end());
    const PolygonFormula formula = polygon_formula(loop);
    std::vector<int> uses(loop.size(), 0);
    for (const auto& node : formula.nodes) {
        if (node.type == PolygonFormula::Node::Type::kEdge) ++uses[node.edge];
    }
    CHECK(std::all_of(uses.begin(), uses.end(), [](int n) { return n == 1; }));
    int wrong = 0;
    for (int i = 0; i < points; ++i) {
        const Vec2 p = {random(-1.1, 1.1), random(-1.1, 1.1)};
        wrong += formula_holds(formula, loop, p) != even_odd({loop}, p) ? 1 : 0;
    }
    CHECK(wrong == 0);
}

double area(const Contours& contours) {
    double sum = 0;
    for (const Loop& loop : contours) sum += signed_area(loop);
    return sum;
}

Loop rectangle(double x0, double y0, double x1, double y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

}  // namespace

TEST_CASE("the formula of a simple polygon has each edge once and the polygon's points") {
    Numbers random(11);
    check_formula("triangle", {{-1, -1}, {1, -0.9}, {0, 1}}, 500, random);
    check_formula("L", {{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}}, 2000, random);
    check_formula("U", {{-1, -1}, {1, -1}, {1, 1}, {0.5, 1}, {0.5, 0}, {-0.5, 0}, {-0.5, 1}, {-1, 1}}, 2000,
                  random);
    check_formula("S",
                  {{-1, -1},
                   {1, -1},
                   {1, 0.2},
                   {-0.5, 0.2},
                   {-0.5, 0.6},
                   {1, 0.6},
                   {1, 1},
                   {-1, 1},
                   {-1, -0.2},
                   {0.5, -0.2},
                   {0.5, -0.6},
                   {-1, -0.6}},
                  2000, random);
    for (int round = 0; round < 100; ++round) {
        check_formula("small star", star(random, 4 + round % 12), 300, random);
        check_formula("random comb", comb(3 + round % 9, [&](int) { return random(0.1, 1); }), 300, random);
    }
    check_formula("flush comb", comb(12, [](int) { return 1.0; }), 2000, random);
    check_formula("spiral", spiral(3, 20), 2000, random);
    check_formula("square spiral", square_spiral(5), 5000, random);
}

TEST_CASE("formulas of 5,000 edges") {
    Numbers random(12);
    check_formula("star", star(random, 5000), 300, random);
    check_formula("flush comb", comb(1250, [](int) { return 1.0; }), 300, random);
    check_formula("rising comb", comb(1250, [](int i) { return 0.1 + i / 1300.0; }), 300, random);
    check_formula("spiral", spiral(25, 100), 300, random);
    check_formula("square spiral", square_spiral(600), 300, random);
}

TEST_CASE("simple loops keep their coordinates; collinear points go") {
    const Loop l = {{0, 0}, {0.1, 0}, {0.3, 0}, {0.3, 0.7}, {0, 0.7}, {0, 0.1}};
    const Contours result = normalised({l});
    REQUIRE(result.size() == 1);
    CHECK(result[0].size() == 4);
    for (const Vec2& point : result[0]) CHECK(std::find(l.begin(), l.end(), point) != l.end());
    // A clockwise one is turned; a hole is clockwise and follows its outer loop.
    Loop outer = rectangle(0, 0, 1, 1);
    std::reverse(outer.begin(), outer.end());
    const Contours nested = normalised(
        {rectangle(0.4, 0.4, 0.6, 0.6), rectangle(0.3, 0.3, 0.7, 0.7), outer, rectangle(2, 0, 3, 1)});
    REQUIRE(nested.size() == 4);
    CHECK(area(nested) == doctest::Approx(1 - 0.16 + 0.04 + 1));
    std::size_t holes = 0;
    for (std::size_t i = 0; i < nested.size(); ++i) {
        if (signed_area(nested[i]) > 0) continue;
        ++holes;
        REQUIRE(i > 0);
        CHECK(signed_area(nested[i - 1]) == doctest::Approx(1));
    }
    CHECK(holes == 1);
    CHECK(normalised({{{0, 0}, {1, 1}, {2, 2}}}).empty());
    CHECK(normalised({{{0, 0}, {1, 1}}}).empty());
    CHECK(normalised({}).empty());
}

TEST_CASE("crossing loops are resolved by the even-odd rule") {
    Numbers random(13);
    for (int round = 0; round < 30; ++round) {
        Contours loops(1 + static_cast<std::size_t>(round) % 3);
        for (Loop& loop : loops) {
            for (int i = 0; i < 9; ++i) loop.push_back({random(-1, 1), random(-1, 1)});
        }
        const Contours result = normalised(loops);
        int wrong = 0;
        for (int i = 0; i < 1000; ++i) {
            const Vec2 p = {random(-1, 1), random(-1, 1)};
            wrong += even_odd(loops, p) != even_odd(result, p) ? 1 : 0;
        }
        CHECK(wrong == 0);
        for (const Loop& loop : result) {
            Loop left = loop;
            if (signed_area(left) < 0) std::reverse(left.begin(), left.end());
            const PolygonFormula formula = polygon_formula(left);
            for (int i = 0; i < 100; ++i) {
                const Vec2 p = {random(-1, 1), random(-1, 1)};
                CHECK(formula_holds(formula, left, p) == even_odd({left}, p));
            }
        }
    }
    // Two that touch along an edge, and two that share a corner.
    CHECK(area(normalised({rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)})) == doctest::Approx(2));
    CHECK(area(normalised({rectangle(0, 0, 1, 1), rectangle(1, 1, 2, 2)})) == doctest::Approx(2));
    CHECK(normalised({rectangle(0, 0, 1, 1), rectangle(0, 0, 1, 1)}).empty());
}

TEST_CASE("offsets, hulls, sums and filled outlines have the areas of the formulas") {
    const Contours square = {rectangle(0, 0, 2, 2)};
    const int sides = 360;
    CHECK(area(offset(square, 0.5, OffsetCorner::kMiter, sides)) == doctest::Approx(9));
    CHECK(area(offset(square, -0.5, OffsetCorner::kMiter, sides)) == doctest::Approx(1));
    CHECK(offset(square, -1.5, OffsetCorner::kMiter, sides).empty());
    CHECK(area(offset(square, 0.5, OffsetCorner::kRound, sides)) ==
          doctest::Approx(4 + 4 + kPi / 4).epsilon(1e-4));
    // A square corner at distance d loses a triangle of height d (sqrt(2) - 1).
    const double cut = 0.5 * (std::sqrt(2.0) - 1);
    CHECK(area(offset(square, 0.5, OffsetCorner::kChamfer, sides)) == doctest::Approx(9 - 4 * cut * cut));
    const Contours frame = normalised({rectangle(0, 0, 4, 4), rectangle(1, 1, 3, 3)});
    CHECK(area(offset(frame, 0.25, OffsetCorner::kMiter, sides)) == doctest::Approx(4.5 * 4.5 - 1.5 * 1.5));
    CHECK(area(filled(frame)) == doctest::Approx(16));
    CHECK(area(convex_hull({rectangle(0, 0, 1, 1), rectangle(2, 2, 3, 3)})) == doctest::Approx(5));
    CHECK(area(minkowski_sum(square, {rectangle(0, 0, 1, 3)})) == doctest::Approx(3 * 5));
    // A frame and a square: both outlines move.
    const Contours sum = minkowski_sum(frame, {rectangle(-0.25, -0.25, 0.25, 0.25)});
    CHECK(area(sum) == doctest::Approx(4.5 * 4.5 - 1.5 * 1.5));
    CHECK(area(minkowski_sum(frame, {rectangle(-3, -3, 3, 3)})) == doctest::Approx(100));
}

TEST_CASE("offsets of offsets do not double their points each time") {
    for (const OffsetCorner corner : {OffsetCorner::kRound, OffsetCorner::kChamfer}) {
        Contours shape = {rectangle(0, 0, 10, 5)};
        for (int level = 0; level < 24; ++level) shape = offset(shape, 0.1, corner, 32);
        REQUIRE(shape.size() == 1);
        CHECK(shape[0].size() < 1000);
        const double rounded = 50 + 30 * 2.4 + 3.14159265 * 2.4 * 2.4;
        CHECK(signed_area(shape[0]) == doctest::Approx(rounded).epsilon(3e-3));
    }
}

TEST_CASE("the offset of a long row of shapes takes no time of its square") {
    // A row of 4000 regular 60-gons, as a line of text: Clipper's sweep must not cross all of them at each
    // step.
    constexpr int kCount = 4000;
    Contours row;
    for (int k = 0; k < kCount; ++k) {
        std::vector<Vec2> loop = regular_polygon(1, 60);
        for (Vec2& p : loop) p = {p[0] + 3.0 * k, p[1] + 1e-3 * (k % 97)};
        row.push_back(std::move(loop));
    }
    const auto start = std::chrono::steady_clock::now();
    const Contours wide = offset(row, 0.25, OffsetCorner::kRound, 60);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    CHECK(seconds.count() < 10);
    REQUIRE(wide.size() == kCount);
    double area = 0;
    for (const auto& loop : wide) area += signed_area(loop);
    CHECK(area == doctest::Approx(kCount * 3.14159265 * 1.25 * 1.25).epsilon(3e-3));
}
