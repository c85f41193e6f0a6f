// 2D shapes and extrusions of .csg files, against point tests written for each case.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "host/common/random.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;
using test::refusal;
using test::region_at;

namespace {

using Oracle = std::function<bool(double, double, double)>;

/// The model and the oracle agree at random points of the box, and the model's bounds hold all points.
void compare(const std::string& text, const Vec3& min, const Vec3& max, const Oracle& oracle,
             Facets facets = Facets::kSmooth) {
    CAPTURE(text);
    const Model model = read_csg(text, facets);
    Random random(7);
    int inside = 0;
    int wrong = 0;
    int out_of_bounds = 0;
    const auto& bounds = model.nodes[model.regions[0].root].bounds;
    for (int i = 0; i < 4000; ++i) {
        Vec3 p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = min[k] + (max[k] - min[k]) * random.uniform();
        const bool expected = oracle(p[0], p[1], p[2]);
        wrong += (region_at(model, p) == 1) != expected ? 1 : 0;
        inside += expected ? 1 : 0;
        for (std::size_t k = 0; k < 3 && bounds && expected; ++k) {
            out_of_bounds += p[k] < bounds->min[k] || p[k] > bounds->max[k] ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(inside > 50);
    CHECK(inside < 3950);
    CHECK(out_of_bounds == 0);
}

bool between(double low, double x, double high) { return low <= x && x <= high; }

const std::string kL =
    "polygon(points = [[0,0],[4,0],[4,1],[1,1],[1,3],[0,3]], paths = undef, convexity = 1);";
bool in_l(double x, double y) { return between(0, x, 4) && between(0, y, 3) && (x <= 1 || y <= 1); }

const std::string kFrame =
    "polygon(points = [[0,0],[4,0],[4,4],[0,4],[1,1],[3,1],[3,3],[1,3]], paths = [[0,1,2,3],[4,5,6,7]]);";
bool in_frame(double x, double y) {
    return between(0, x, 4) && between(0, y, 4) && !(between(1, x, 3) && between(1, y, 3));
}

}  // namespace

TEST_CASE("straight extrusions in both writer styles") {
    compare(
        "linear_extrude(height = 2, center = false, convexity = 1, scale = [1, 1], $fn = 0, $fa = 12, $fs "
        "= 2) { " +
            kL + " }",
        {-1, -1, -1}, {5, 4, 3}, [](double x, double y, double z) { return in_l(x, y) && between(0, z, 2); });
    compare("linear_extrude(height = 2, center = true, $fn = 0, $fa = 12, $fs = 2) { " + kFrame + " }",
            {-1, -1, -2}, {5, 5, 2},
            [](double x, double y, double z) { return in_frame(x, y) && between(-1, z, 1); });
    compare("linear_extrude(height = 3) { square(size = [2, 4], center = true); circle(r = 1.5); }",
            {-3, -3, -1}, {3, 3, 4}, [](double x, double y, double z) {
                return between(0, z, 3) &&
                       ((between(-1, x, 1) && between(-2, y, 2)) || std::hypot(x, y) <= 1.5);
            });
    compare(
        "linear_extrude(height = 3) { difference() { square(size = 4); multmatrix([[0.5,0,0,2],[0,1.5,0,2],"
        "[0,0,0,7],[0,0,0,1]]) { circle(r = 1); } } }",
        {-1, -1, -1}, {5, 5, 4}, [](double x, double y, double z) {
            return between(0, z, 3) && between(0, x, 4) && between(0, y, 4) &&
                   std::hypot((x - 2) / 0.5, (y - 2) / 1.5) > 1;
        });
    compare(
        "linear_extrude(height = 3) { intersection() { circle(d = 4); multmatrix([[1,0,0,1],[0,1,0,0],"
        "[0,0,1,0],[0,0,0,1]]) { circle(r = 2); } } }",
        {-3, -3, -1}, {4, 3, 4}, [](double x, double y, double z) {
            return between(0, z, 3) && std::hypot(x, y) <= 2 && std::hypot(x - 1, y) <= 2;
        });
    // Along v, at the height's full length.
    compare("linear_extrude(height = 5, v = [0.6, 0, 0.8]) { square(size = 1); }", {-1, -1, -1}, {5, 2, 5},
            [](double x, double y, double z) {
                return between(0, z, 4) && between(0, x - 0.75 * z, 1) && between(0, y, 1);
            });
    compare("linear_extrude(height = 2, v = [0, 0, -1]) { square(size = 1); }", {-1, -1, -3}, {2, 2, 1},
            [](double x, double y, double z) {
                return between(-2, z, 0) && between(0, x, 1) && between(0, y, 1);
            });
}

TEST_CASE("circles are curved unless $fn asks for a prism, or facets are wanted") {
    const auto polygon = [](int n) {
        return [n](double x, double y, double z) {
            if (!between(0, z, 1)) return false;
            for (int j = 0; j < n; ++j) {
                const double angle = 2 * 3.14159265358979323846 * (j + 0.5) / n;
                if (x * std::cos(angle) + y * std::sin(angle) > 2 * std::cos(3.14159265358979323846 / n))
                    return false;
            }
            return true;
        };
    };
    const auto text = [](const std::string& arguments) {
        return "linear_extrude(height = 1) { circle(" + arguments + "r = 2); }";
    };
    const Vec3 min = {-2.2, -2.2, -0.5};
    const Vec3 max = {2.2, 2.2, 1.5};
    compare(text("$fn = 6, $fa = 12, $fs = 2, "), min, max, polygon(6));
    compare(text("$fn = 40, $fa = 12, $fs = 2, "), min, max,
            [](double x, double y, double z) { return between(0, z, 1) && std::hypot(x, y) <= 2; });
    compare(text("$fn = 40, $fa = 12, $fs = 2, "), min, max, polygon(40), Facets::kExact);
    // 2 π r / $fs = 6.3, rounded up; then at least five.
    compare(text("$fn = 0, $fa = 12, $fs = 2, "), min, max, polygon(7), Facets::kExact);
    compare(text("$fn = 0, $fa = 12, $fs = 9, "), min, max, polygon(5), Facets::kExact);
    CHECK(read_csg("sphere($fn = 20);", Facets::kExact).nodes[0].primitive.kind == Primitive::Kind::kConvex);
    CHECK(read_csg("cylinder($fn = 20);", Facets::kExact).nodes[0].primitive.planes.size() == 22);
    CHECK(read_csg("cylinder($fn = 20);").nodes[0].primitive.kind == Primitive::Kind::kCylinder);
}

TEST_CASE("tapered extrusions") {
    for (const double scale : {0.5, 2.0, 0.0}) {
        const std::string head = "linear_extrude(height = 2, scale = " + std::to_string(scale) + ") { ";
        const auto level = [scale](double z) { return 1 + (scale - 1) * z / 2; };
        compare(head + kL + "}", {-1, -1, -1}, {9, 7, 3}, [=](double x, double y, double z) {
            return between(0, z, 2) && in_l(x / level(z), y / level(z));
        });
        compare(head + "multmatrix([[1,0,0,3],[0,1,0,1],[0,0,1,0],[0,0,0,1]]) { circle(r = 2); } }",
                {-1, -3, -1}, {10, 6, 3}, [=](double x, double y, double z) {
                    return between(0, z, 2) && std::hypot(x / level(z) - 3, y / level(z) - 1) <= 2;
                });
    }
    // A different scale for x and y keeps edges along the axes plane.
    compare("linear_extrude(height = 2, center = true, scale = [0.5, 3]) { square(size = [2, 1]); }",
            {-1, -1, -2}, {3, 4, 2}, [](double x, double y, double z) {
                const double t = (z + 1) / 2;
                return between(-1, z, 1) && between(0, x, 2 * (1 - 0.5 * t)) && between(0, y, 1 + 2 * t);
            });
    // A pyramid has no top; a ridge has one.
    const Model pyramid =
        read_csg("linear_extrude(height = 1, scale = 0) { square(size = 2, center = true); }");
    CHECK(pyramid.nodes[pyramid.regions[0].root].primitive.planes.size() == 5);
}

TEST_CASE("full revolutions: tori, spheres, lathe work") {
    const std::string head = "rotate_extrude(angle = 360, start = 180, convexity = 2, $fn = 0) { ";
    const auto moved = [](double x, double y, const std::string& shape) {
        return "multmatrix([[1,0,0," + std::to_string(x) + "],[0,1,0," + std::to_string(y) +
               "],[0,0,1,0],[0,0,0,1]]) { " + shape + " }";
    };
    const Vec3 min = {-5, -5, -3};
    const Vec3 max = {5, 5, 4};
    compare(head + moved(3, 1, "circle(r = 1);") + "}", min, max,
            [](double x, double y, double z) { return std::hypot(std::hypot(x, y) - 3, z - 1) <= 1; });
    const std::string half =
        "multmatrix([[1,0,0,0],[0,1,0,-9],[0,0,1,0],[0,0,0,1]]) { square(size = [9, 18]); }";
    compare(head + "intersection() { circle(r = 2.5); " + half + "} }", min, max,
            [](double x, double y, double z) { return std::hypot(x, y, z) <= 2.5; });
    compare(head + "intersection() { " + moved(1, 0, "circle(r = 2);") + half + "} }", min, max,
            [](double x, double y, double z) { return std::hypot(std::hypot(x, y) - 1, z) <= 2; });
    compare(head +
                "intersection() { multmatrix([[2,0,0,0],[0,1,0,1],[0,0,1,0],[0,0,0,1]]) { circle(r = 2); }" +
                half + "} }",
            min, max, [](double x, double y, double z) { return std::hypot(x / 2, y / 2, z - 1) <= 2; });
    compare(head + kL + "}", min, max,
            [](double x, double y, double z) { return in_l(std::hypot(x, y), z); });
    compare(head + moved(0.5, -1, kFrame) + "}", min, max,
            [](double x, double y, double z) { return in_frame(std::hypot(x, y) - 0.5, z + 1); });
    // Slanted edges: cones and their complements, one nappe each.
    compare(head + "polygon(points = [[1,-2],[4,0],[1,2],[2,0]]); }", min, max,
            [](double x, double y, double z) {
                const double r = std::hypot(x, y);
                return r <= 4 - 1.5 * std::fabs(z) && r >= 2 - 0.5 * std::fabs(z);
            });
    compare(head + "polygon(points = [[0,-2],[3,0],[0,2]]); }", min, max,
            [](double x, double y, double z) { return std::hypot(x, y) <= 3 - 1.5 * std::fabs(z); });
    // The other side of the axis serves as well.
    compare(head + moved(-3, 0, "circle(r = 1);") + "}", min, max,
            [](double x, double y, double z) { return std::hypot(std::hypot(x, y) - 3, z) <= 1; });
    const Model ring = read_csg(head + moved(3, 0, "circle(r = 1);") + "}");
    CHECK(ring.nodes[0].primitive.kind == Primitive::Kind::kTorus);
}

TEST_CASE("partial revolutions and revolutions with flat steps") {
    const auto degrees = [](double x, double y) {
        const double angle = std::atan2(y, x) * 180 / 3.14159265358979323846;
        return angle < 0 ? angle + 360 : angle;
    };
    struct Case {
        const char* arguments;
        double from, to;
    };
    for (const Case& c :
         {Case{"angle = 90, start = 0", 0, 90}, Case{"angle = 180, convexity = 2", 0, 180},
          Case{"angle = 45, start = 100", 100, 145}, Case{"angle = 270", 0, 270},
          Case{"angle = -60, start = 100", 40, 100}, Case{"angle = -300, start = 330", 30, 330}}) {
        compare(std::string("rotate_extrude(") + c.arguments +
                    ") { multmatrix([[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { square(size = [2, 1]); } }",
                {-4, -4, -0.5}, {4, 4, 1.5}, [&](double x, double y, double z) {
                    return between(1, std::hypot(x, y), 3) && between(0, z, 1) &&
                           between(c.from, degrees(x, y), c.to);
                });
    }
    // Six sides, vertices at multiples of 60°: the distance from the axis is that along the apothem.
    const auto hexagonal = [&](double x, double y, double from) {
        const double angle = std::fmod(degrees(x, y) - from + 360, 60) - 30;
        return std::hypot(x, y) * std::cos(angle * 3.14159265358979323846 / 180) /
               std::cos(3.14159265358979323846 / 6);
    };
    compare("rotate_extrude(angle = 360, $fn = 6) { " + kFrame + " }", {-5, -5, -1}, {5, 5, 5},
            [&](double x, double y, double z) { return in_frame(hexagonal(x, y, 0), z); });
    compare(
        "rotate_extrude(angle = 360, $fn = 6) { multmatrix([[1,0,0,3],[0,1,0,1],[0,0,1,0],[0,0,0,1]]) { "
        "circle(r = 1); } }",
        {-5, -5, -1}, {5, 5, 3},
        [&](double x, double y, double z) { return std::hypot(hexagonal(x, y, 0) - 3, z - 1) <= 1; });
    compare(
        "rotate_extrude(angle = 120, start = 15, $fn = 6) { multmatrix([[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,"
        "0,1]]) { " +
            kL + " } }",
        {-6, -6, -1}, {6, 6, 4}, [&](double x, double y, double z) {
            return between(15, degrees(x, y), 135) && in_l(hexagonal(x, y, 15) - 1, z);
        });
    compare("rotate_extrude(angle = 120, start = 15, $fn = 6) { " + kL + " }", {-5, -5, -1}, {5, 5, 4},
            [&](double x, double y, double z) {
                return between(15, degrees(x, y), 135) && in_l(hexagonal(x, y, 15), z);
            });
}

TEST_CASE("outlines: offset, hull, minkowski, fill, resize") {
    const auto extruded = [](const std::string& shape) {
        return "linear_extrude(height = 1) { " + shape + " }";
    };
    const Vec3 min = {-3, -3, -0.5};
    const Vec3 max = {7, 7, 1.5};
    compare(extruded("offset(delta = 0.5, chamfer = false, $fn = 0) { " + kFrame + " }"), min, max,
            [](double x, double y, double z) {
                return between(0, z, 1) && between(-0.5, x, 4.5) && between(-0.5, y, 4.5) &&
                       !(between(1.5, x, 2.5) && between(1.5, y, 2.5));
            });
    compare(extruded("fill() { " + kFrame + " }"), min, max, [](double x, double y, double z) {
        return between(0, z, 1) && between(0, x, 4) && between(0, y, 4);
    });
    compare(extruded("hull() { square(size = 1); polygon(points = [[4,0],[4,4],[0,4]]); }"), min, max,
            [](double x, double y, double z) {
                return between(0, z, 1) && between(0, x, 4) && between(0, y, 4);
            });
    compare(extruded("minkowski(convexity = 0) { square(size = 2); square(size = [1, 3]); }"), min, max,
            [](double x, double y, double z) {
                return between(0, z, 1) && between(0, x, 3) && between(0, y, 5);
            });
    compare(extruded("resize(newsize = [4,0,0], auto = [0,1,0]) { circle(r = 1); }"), min, max,
            [](double x, double y, double z) { return between(0, z, 1) && std::hypot(x, y) <= 2; });
    compare(
        extruded("resize(newsize = [2,6,0], auto = [0,0,0]) { difference() { square(size = 4); square(size "
                 "= [4, 1]); } }"),
        min, max, [](double x, double y, double z) {
            return between(0, z, 1) && between(0, x, 2) && between(2, y, 8);
        });
}

TEST_CASE("plane shapes among solids are left out, solids among plane shapes too") {
    const Model model = read_csg("cube(); square(); circle();");
    CHECK(model.warnings.size() == 1);
    CHECK(model.warnings[0].find("part.csg:1:9: a 2D shape among solids") == 0);
    CHECK(region_at(model, {0.5, 0.5, 0.5}) == 1);
    CHECK(region_at(read_csg("difference() { square(); cube(); }"), {0.5, 0.5, 0.5}) == 0);
    const Model mixed = read_csg("linear_extrude(height = 1) { square(size = 2); cube(size = 5); }");
    CHECK(mixed.warnings.size() == 1);
    CHECK(region_at(mixed, {1.5, 1.5, 0.5}) == 1);
    CHECK(region_at(mixed, {3, 3, 0.5}) == 0);
    // Nothing is neither plane nor solid.
    CHECK(region_at(read_csg("cube(); linear_extrude(height = 1) { group(); }"), {0.5, 0.5, 0.5}) == 1);
    CHECK(region_at(read_csg("cube(); linear_extrude(height = 1);"), {0.5, 0.5, 0.5}) == 1);
}

TEST_CASE("names of extruded surfaces") {
    const Model model = read_csg("cube(); linear_extrude(height = 1) { " + kL +
                                 "} linear_extrude(height = 2) { "
                                 "square(); circle(r = 3); }");
    std::vector<std::string> names;
    for (const CsgNode& node : model.nodes) {
        names.push_back(node.name);
        for (const Plane& plane : node.primitive.planes) names.push_back(plane.name);
    }
    for (const char* name :
         {"linear_extrude1", "linear_extrude2", "top", "bottom", "side1", "side6", "linear_extrude2_side5"}) {
        CAPTURE(name);
        CHECK(std::count(names.begin(), names.end(), name) > 0);
    }
    CHECK(std::count(names.begin(), names.end(), "side7") == 0);
}

TEST_CASE("errors of plane shapes and extrusions") {
    struct Case {
        const char* text;
        const char* place;
        const char* mention;
    };
    const Case cases[] = {
        {"square();", "1:1", "2D shapes only"},
        {"square(size = 0);", "1:15", "size 0"},
        {"square(size = [1, 2, 3]);", "1:15", "two numbers"},
        {"circle(r = -1);", "1:12", "radius -1"},
        {"polygon();", "1:1", "pairs of numbers"},
        {"polygon(points = [[1,2,3]]);", "1:18", "pairs of numbers"},
        {"polygon(points = [[0,0],[1,0],[0,inf]]);", "1:34", "nan or inf"},
        {"polygon(points = [[0,0],[1,0],[0,1]], paths = [[0,1,3]]);", "1:47", "point 3"},
        {"polygon(points = [[0,0],[1,0],[0,1]], paths = [[0,1,0.5]]);", "1:47", "point 0.5"},
        {"polygon(points = [[0,0],[1,0],[0,1]], paths = true);", "1:47", "neither undef nor lists"},
        {"linear_extrude(height = 0) { square(); }", "1:25", "height 0"},
        {"linear_extrude(height = 1, scale = [1, -1]) { square(); }", "1:36", "scale is -1"},
        {"linear_extrude(height = 1, v = [1, 0, 0]) { square(); }", "1:32", "flatten"},
        {"linear_extrude(height = 1, file = \"a.dxf\");", "1:35", "import()"},
        {"linear_extrude(height = 1, twist = nan) { square(); }", "1:36", "twist is nan"},
        {"\n linear_extrude(height = 1) { cube(); }", "2:2", "wants 2D shapes"},
        {"rotate_extrude(angle = 0) { square(); }", "1:24", "angle 0"},
        {"rotate_extrude(angle = 360) { square(center = true); }", "1:1", "both sides of the axis"},
        {"linear_extrude(height = 1) { multmatrix([[1,1,0,0],[1,1,0,0],[0,0,1,0],[0,0,0,1]]) { square(); } }",
         "1:41", "singular"},
        {"offset(r = true) { square(); }", "1:12", "not a number"},
        {"projection(cut = true) { cube(); }", "1:1", "2D shapes only"},
        {"group(); projection(); square(1);", "1:24", "2D shapes only"},
        {"projection(cut = false) { difference() { sphere(2); sphere(1); } }", "1:1", "2D shapes only"},
        {"resize(newsize = [1,2,-3]) { cube(); }", "1:18", "newsize is -3"},
        {"resize(newsize = 1) { cube(); }", "1:18", "three numbers"},
        {"circle($fn = 1e9);", "1:1", "fragments"},
    };
    for (const Case& c : cases) {
        const std::string message = refusal(c.text, "csg");
        CAPTURE(c.text);
        CAPTURE(message);
        CHECK(message.compare(0, 9 + std::string(c.place).size(), std::string("2 m.csg:") + c.place + ":") ==
              0);
        CHECK(message.find(c.mention) != std::string::npos);
        CHECK(message.find('\n') == std::string::npos);
    }
}

namespace {

/// A random plane shape of straight edges, as text.
std::string random_shape(Random& random, int depth) {
    const auto number = [&](double low, double high) {
        return std::to_string(low + (high - low) * random.uniform());
    };
    const int pick = static_cast<int>(random.uniform() * (depth > 0 ? 7 : 3));
    if (pick == 0) return "square(size = [" + number(0.5, 2) + "," + number(0.5, 2) + "], center = true);";
    if (pick == 1)
        return "circle($fn = " + std::to_string(3 + static_cast<int>(9 * random.uniform())) +
               ", r = " + number(0.5, 1.5) + ");";
    if (pick == 2) {
        std::string points;
        for (int i = 0; i < 6; ++i)
            points += (i > 0 ? ",[" : "[") + number(-2, 2) + "," + number(-2, 2) + "]";
        return "polygon(points = [" + points + "]);";
    }
    const char* const names[] = {"union", "difference", "intersection"};
    const std::string inner = random_shape(random, depth - 1) + random_shape(random, depth - 1);
    if (pick < 6) return std::string(names[pick - 3]) + "() { " + inner + "}";
    return "multmatrix([[" + number(-1, 1) + "," + number(-1, 1) + ",0," + number(-1, 1) + "],[" +
           number(-1, 1) + "," + number(-1, 1) + ",0," + number(-1, 1) + "],[0,0,1,0],[0,0,0,1]]) { " +
           inner + "}";
}

}  // namespace

TEST_CASE("the tree of extruded shapes is the extrusion of their outline") {
    Random random(9);
    int inside = 0;
    for (int round = 0; round < 200; ++round) {
        const std::string shape = random_shape(random, 3);
        CAPTURE(shape);
        const Model tree = read_csg("linear_extrude(height = 1) { " + shape + " }");
        const Model outline = read_csg("linear_extrude(height = 1) { offset(delta = 0) { " + shape + " } }");
        int wrong = 0;
        for (int i = 0; i < 300; ++i) {
            const Vec3 p = {-3 + 6 * random.uniform(), -3 + 6 * random.uniform(), 0.5};
            const bool expected = region_at(tree, p) == 1;
            wrong += (region_at(outline, p) == 1) != expected ? 1 : 0;
            inside += expected ? 1 : 0;
        }
        CHECK(wrong == 0);
    }
    CHECK(inside > 3000);
}

TEST_CASE("extreme sizes neither crash nor hang") {
    CHECK(refusal("linear_extrude(height = 1) { polygon(points = [[0,0],[1e200,0],[0,1e200]]); }", "csg")
              .find("larger than 1e100") != std::string::npos);
    CHECK(refusal(
              "linear_extrude(height = 1) { offset(delta = 1) { multmatrix([[1e99,0,0,0],[0,1e99,0,0],[0,0,1,"
              "0],[0,0,0,1]]) { square(size = 100); } } }",
              "csg")
              .find("larger than 1e100") != std::string::npos);
    CHECK(
        region_at(read_csg("linear_extrude(height = 1) { polygon(points = [[0,0],[1e-200,0],[0,1e-200]]); }"),
                  {0, 0, 0.5}) == 0);
    CHECK(refusal("linear_extrude(height = 1) { minkowski() { circle($fn = 5000); circle($fn = 5000); } }",
                  "csg")
              .find("too fine") != std::string::npos);
    CHECK(region_at(read_csg("cube(); multmatrix([[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]) { group(); }"),
                    {0.5, 0.5, 0.5}) == 1);
}

TEST_CASE("plane trees nest to any depth") {
    constexpr int kDepth = 10000;
    std::string text = "linear_extrude(height = 1) { ";
    for (int k = 0; k < kDepth; ++k) {
        text += "multmatrix([[1,0,0,0.001],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) { ";
    }
    text += "square();" + std::string(kDepth, '}') + "}";
    CHECK(region_at(read_csg(text), {10.5, 0.5, 0.5}) == 1);
    std::string unions = "linear_extrude(height = 1) { offset(delta = 1) { ";
    for (int k = 0; k < kDepth; ++k) unions += "union() { square(size = 2); group() { ";
    unions += std::string(2 * kDepth, '}') + "} }";
    CHECK(region_at(read_csg(unions), {2.5, 2.5, 0.5}) == 1);
}
