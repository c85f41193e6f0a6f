// The .geo reader: semantics.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/model/membership.hpp"

using namespace mortise;
using test::region_at;

namespace {

Model read_geo(const std::string& statements) {
    return parse_model("algebraic3d\n" + statements, "geo", "m.geo");
}
Model read_solid(const std::string& expression) { return read_geo("solid s = " + expression + "; tlo s;"); }
bool inside_geo(const std::string& expression, const Vec3& point) {
    return region_at(read_solid(expression), point) == 1;
}

/// Names of all primitives below a region, in the order of the arena, each once.
std::vector<std::string> surface_names(const Model& model, std::size_t region = 0) {
    std::vector<char> reached(model.nodes.size(), 0);
    reached[model.regions.at(region).root] = 1;
    for (std::size_t node = model.nodes.size(); node-- > 0;) {
        if (reached[node] == 0) continue;
        for (const std::uint32_t child : model.nodes[node].children) reached[child] = 1;
    }
    std::vector<std::string> names;
    for (std::size_t node = 0; node < model.nodes.size(); ++node) {
        if (reached[node] != 0 && model.nodes[node].op == CsgNode::Op::kPrimitive)
            names.push_back(model.nodes[node].name);
    }
    return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("primitives of .geo files") {
    CHECK(inside_geo("plane (1, 2, 3; 0, -1, 0)", {9, 2.1, 9}));
    CHECK_FALSE(inside_geo("plane (1, 2, 3; 0, -1, 0)", {9, 1.9, 9}));
    CHECK(inside_geo("sphere (1, 2, 3; 2)", {2.9, 2, 3}));
    CHECK_FALSE(inside_geo("sphere (1, 2, 3; 2)", {-1.1, 2, 3}));

    // Infinite, along any axis.
    CHECK(inside_geo("cylinder (0, 1, 2; 5, 1, 2; 0.5)", {-100, 1.3, 2.3}));
    CHECK_FALSE(inside_geo("cylinder (0, 1, 2; 5, 1, 2; 0.5)", {0, 1.4, 2.4}));
    CHECK(inside_geo("cylinder (0, 0, 0; 1, 1, 1; 1)", {50.5, 50, 49.5}));
    CHECK_FALSE(inside_geo("cylinder (0, 0, 0; 1, 1, 1; 1)", {51, 50, 49}));
    CHECK(inside_geo("cylinder (0, 0, 7; 0, 0, -1; 1)", {0.6, 0.7, 0}));

    // Both nappes; apex of the second at x = 4.
    for (const char* cone : {"cone (0, 0, 0; 2; 2, 0, 0; 1)", "cone (4, 0, 0; 0; 0, 0, 0; 2)",
                             "cone (2, 0, 0; 1; 0, 0, 0; 2)"}) {
        CAPTURE(cone);
        CHECK(inside_geo(cone, {1, 1.4, 0}));
        CHECK_FALSE(inside_geo(cone, {1, 1.6, 0}));
        CHECK(inside_geo(cone, {7, 0, 1.4}));
        CHECK_FALSE(inside_geo(cone, {7, 0, 1.6}));
    }
    CHECK(inside_geo("cone (0, 0, 0; 1; 0, 0, 5; 1)", {0.9, 0, 77}));

    CHECK(inside_geo("ellipticcylinder (1, 0, 0; 3, 0, 0; 0, 0, 0.5)", {3.9, 55, 0}));
    CHECK(inside_geo("ellipticcylinder (1, 0, 0; 3, 0, 0; 0, 0, 0.5)", {1, -55, 0.45}));
    CHECK_FALSE(inside_geo("ellipticcylinder (1, 0, 0; 3, 0, 0; 0, 0, 0.5)", {3, 0, 0.45}));
    CHECK(inside_geo("ellipsoid (0, 0, 1; 2, 0, 0; 0, 1, 0; 0, 0, 0.5)", {1.9, 0, 1}));
    CHECK(inside_geo("ellipsoid (0, 0, 1; 2, 0, 0; 0, 1, 0; 0, 0, 0.5)", {0, 0, 0.55}));
    CHECK_FALSE(inside_geo("ellipsoid (0, 0, 1; 2, 0, 0; 0, 1, 0; 0, 0, 0.5)", {0, 0, 0.45}));

    CHECK(inside_geo("torus (0, 0, 1; 1, 0, 0; 3; 1)", {0.9, 3, 1}));
    CHECK(inside_geo("torus (0, 0, 1; 1, 0, 0; 3; 1)", {0, 0, 4.9}));
    CHECK_FALSE(inside_geo("torus (0, 0, 1; 1, 0, 0; 3; 1)", {3, 0, 1}));
    CHECK(inside_geo("orthobrick (-1, -2, -3; 1, 2, 3)", {0.9, -1.9, 2.9}));
    CHECK_FALSE(inside_geo("orthobrick (-1, -2, -3; 1, 2, 3)", {0, 0, 3.1}));
}

TEST_CASE("an elliptic cone shrinks by its ratio over its height, along long x short") {
    const std::string cone = "ellipticcone (1, 0, 0; 4, 0, 0; 0, 2, 0; 5; 0.5)";
    CHECK(inside_geo(cone, {4.9, 0, 0}));
    CHECK(inside_geo(cone, {1, 1.9, 0}));
    CHECK_FALSE(inside_geo(cone, {1, 2.1, 0}));
    CHECK(inside_geo(cone, {2.9, 0, 5}));
    CHECK_FALSE(inside_geo(cone, {3.1, 0, 5}));
    CHECK(inside_geo(cone, {1, 2.9, -5}));
    // The order of the axes does not matter, as in Netgen; their senses do.
    const std::string swapped = "ellipticcone (1, 0, 0; 0, 2, 0; 4, 0, 0; 5; 0.5)";
    CHECK(inside_geo(swapped, {2.9, 0, 5}));
    CHECK_FALSE(inside_geo(swapped, {3.1, 0, 5}));
    CHECK_FALSE(inside_geo("ellipticcone (1, 0, 0; 4, 0, 0; 0, -2, 0; 5; 0.5)", {3.1, 0, -5}));
    CHECK(inside_geo("ellipticcone (0, 0, 0; 4, 0, 0; 0, 2, 0; 5; 1)", {3.9, 0, 99}));
    // Ratio 0: the apex at the height.
    CHECK_FALSE(inside_geo("ellipticcone (0, 0, 0; 4, 0, 0; 0, 2, 0; 5; 0)", {0.1, 0, 5}));
}

TEST_CASE("skew semi-axes measure coordinates as Netgen does") {
    // ((p·v1)/|v1|²)² + ((p·v2)/|v2|²)² <= 1 with v1 = (2,0,0), v2 = (1,1,0).
    const std::string skew = "ellipticcylinder (0, 0, 0; 2, 0, 0; 1, 1, 0)";
    for (const Vec3& p : {Vec3{1.2, -0.9, 3},
                          {-1.2, 0.9, 0},
                          {0.9, 0.7, 0},
                          {1, 0.8, 1},
                          {1.3, 0.1, 2},
                          {0, 1.9, 0},
                          {0, 2.1, 0}}) {
        const double a = p[0] / 2;
        const double b = (p[0] + p[1]) / 2;
        CAPTURE(p[0]);
        CAPTURE(p[1]);
        CHECK(inside_geo(skew, p) == (a * a + b * b <= 1));
    }
}

TEST_CASE("and binds stronger than or; not, parentheses and chains") {
    const std::string a = "sphere(0,0,0;1)";
    const std::string b = "sphere(1,0,0;1)";
    const std::string c = "sphere(5,0,0;1)";
    CHECK(inside_geo(a + " and " + b + " or " + c, {5, 0, 0}));
    CHECK(inside_geo(a + " and " + b + " or " + c, {0.5, 0, 0}));
    CHECK_FALSE(inside_geo(a + " and " + b + " or " + c, {-0.5, 0, 0}));
    CHECK_FALSE(inside_geo(a + " and (" + b + " or " + c + ")", {5, 0, 0}));
    CHECK(inside_geo(a + " and not " + b, {-0.5, 0, 0}));
    CHECK_FALSE(inside_geo(a + " and not " + b, {0.5, 0, 0}));
    CHECK(inside_geo("not not " + a, {0.5, 0, 0}));
    CHECK(inside_geo("not not not (" + c + ")", {0.5, 0, 0}));
    CHECK(inside_geo(a + " and not (" + b + " or " + c + ")", {-0.5, 0, 0}));

    std::string chain = a;
    for (int k = 1; k < 1000; ++k) chain += " or sphere(" + std::to_string(3 * k) + ",0,0;1)";
    const Model model = read_solid(chain);
    CHECK(model.nodes[model.regions[0].root].children.size() == 1000);
    CHECK(region_at(model, {2997.5, 0, 0}) == 1);

    constexpr int kDepth = 100000;
    CHECK(inside_geo(std::string(kDepth, '(') + a + std::string(kDepth, ')'), {0.5, 0, 0}));
    std::string shifts;
    for (int k = 0; k < kDepth; ++k) shifts += "not translate(1,0,0; ";
    CHECK(read_solid(shifts + a + std::string(kDepth, ')')).nodes.size() > 2 * kDepth);
}

TEST_CASE("chains of copies of copies grow by a few nodes with each link") {
    constexpr int kLinks = 10000;
    std::string text =
        "algebraic3d\nsolid s0 = sphere(0, 0, 0; 1) and orthobrick(-1, -1, -1; 1, 1, 0.5) -bc=1;\n";
    text += "solid t0 = sphere(0, 5, 0; 1);\n";
    for (int k = 1; k < kLinks; ++k) {
        const std::string before = std::to_string(k - 1);
        text += "solid s" + std::to_string(k) + " = translate(0.5, 0, 0; s" + before + ");\n";
        text += "solid t" + std::to_string(k) + " = translate(0.5, 0, 0; t" + before +
                ") -bc=" + std::to_string(k) + ";\n";
    }
    const std::string last = std::to_string(kLinks - 1);
    const Model model = read_geo(text + "tlo s" + last + "; tlo t" + last + ";\n");
    CHECK(model.nodes.size() < 6 * kLinks);
    const double x = 0.5 * (kLinks - 1);
    CHECK(region_at(model, {x, 0, 0}) == 1);
    CHECK(region_at(model, {x + 0.9, 0, 0}) == 1);
    CHECK(region_at(model, {x + 1.1, 0, 0}) == 0);
    CHECK(region_at(model, {x, 0, 0.6}) == 0);
    CHECK(region_at(model, {x, 5.9, 0}) == 2);
    CHECK(region_at(model, {0, 5, 0}) == 0);
}

TEST_CASE("translate, rotate and their repetitions") {
    CHECK(inside_geo("translate (3, 0, 0; sphere (0, 0, 0; 1))", {3.9, 0, 0}));
    CHECK_FALSE(inside_geo("translate (3, 0, 0; sphere (0, 0, 0; 1))", {0, 0, 0}));

    // Clockwise: +90° about z takes +x to -y, about x takes +y to -z; first az, then ax, then az.
    const std::string quarter = "1.5707963267948966";
    const std::string bar = "orthobrick (1, -0.1, -0.1; 2, 0.1, 0.1)";
    CHECK(inside_geo("rotate (0, 0, 0; " + quarter + ", 0, 0; " + bar + ")", {0, -1.5, 0}));
    CHECK(inside_geo("rotate (0, 0, 0; 0, 0, " + quarter + "; " + bar + ")", {0, -1.5, 0}));
    const std::string y_bar = "orthobrick (-0.1, 1, -0.1; 0.1, 2, 0.1)";
    CHECK(inside_geo("rotate (0, 0, 0; 0, " + quarter + ", 0; " + y_bar + ")", {0, 0, -1.5}));
    // +x to -y by the first angle, -y to +z by the second, +z stays.
    CHECK(inside_geo("rotate (0, 0, 0; " + quarter + ", " + quarter + ", " + quarter + "; " + bar + ")",
                     {0, 0, 1.5}));
    CHECK(inside_geo("rotate (1, 1, 0; " + quarter + ", 0, 0; translate (1, 1, 0; " + bar + "))",
                     {1, -0.5, 0}));

    const Model row = read_solid("multitranslate (3, 0, 0; 2; sphere (0, 0, 0; 1))");
    for (const double x : {0.0, 3.0, 6.0}) CHECK(region_at(row, {x, 0, 0}) == 1);
    for (const double x : {-3.0, 1.5, 9.0}) CHECK(region_at(row, {x, 0, 0}) == 0);
    CHECK(region_at(read_solid("multitranslate (3, 0, 0; 0; sphere (0, 0, 0; 1))"), {3, 0, 0}) == 0);

    // n distinct solids: at 0°, 90° and 180°.
    const Model fan = read_solid("multirotate (0, 0, 0; " + quarter + ", 0, 0; 3; " + bar + ")");
    CHECK(region_at(fan, {1.5, 0, 0}) == 1);
    CHECK(region_at(fan, {0, -1.5, 0}) == 1);
    CHECK(region_at(fan, {-1.5, 0, 0}) == 1);
    CHECK(region_at(fan, {0, 1.5, 0}) == 0);
}

TEST_CASE("regions in order, with names, sizes and metadata") {
    const Model model = read_geo(
        "solid a = sphere(0,0,0;1) -maxh=0.5; solid b = sphere(0,0,0;2); solid c = a -maxh = 0.25; solid d = "
        "a;\n"
        "tlo a -col=[1,0,0] -material=iron;# coil -mur=1  -sig=5.96E7 \r\n"
        "tlo b -transparent -maxh=0.75; #air\n"
        "tlo d;\n"
        "# not metadata\n"
        "tlo c -material = copper;\n");
    REQUIRE(model.regions.size() == 4);
    CHECK(region_at(model, {0.5, 0, 0}) == 1);
    CHECK(region_at(model, {1.5, 0, 0}) == 2);
    CHECK(model.regions[0].name == "a");
    CHECK(model.regions[2].name == "d");
    CHECK(model.regions[0].metadata == "material=iron coil -mur=1  -sig=5.96E7");
    CHECK(model.regions[1].metadata == "air");
    CHECK(model.regions[2].metadata.empty());
    CHECK(model.regions[3].metadata == "material=copper");
    CHECK(model.regions[1].max_size == 0.75);
    CHECK(model.nodes[model.regions[0].root].max_size == 0.5);
    CHECK(model.nodes[model.regions[3].root].max_size == 0.25);
    CHECK(model.warnings.empty());
    CHECK_FALSE(model.clip);
}

TEST_CASE("tlo with a surface: sizes on the faces of a region, no region of its own") {
    const Model model = read_geo(
        "solid top = plane(0,0,1;0,0,1); solid ball = sphere(0,0,0;2); solid a = ball and top;\n"
        "solid b = ball and not top; solid far = plane(0,0,9;0,0,1);\n"
        "tlo a; tlo b; tlo a top -maxh=0.25; tlo a top -maxh=0.5; tlo b ball -maxh=0.75 -col=[1,0,0];\n"
        "tlo a far -maxh=1; tlo b top;\n");
    CHECK(model.regions.size() == 2);
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0] == "m.geo:5:1: 'a' has no surface of that solid; its -maxh has no effect");
    double plane = 0;
    double sphere = 0;
    for (const CsgNode& node : model.nodes) {
        CHECK(node.max_size == 0);
        if (node.op != CsgNode::Op::kPrimitive || node.surface_size == 0) continue;
        (node.primitive.kind == Primitive::Kind::kConvex ? plane : sphere) += node.surface_size;
    }
    CHECK(plane == 0.25);
    CHECK(sphere == 0.75);
    CHECK(test::refusal("algebraic3d solid a = sphere(0,0,0;1); tlo a; tlo a a -maxh=0;", "geo")
              .find("-maxh is 0") != std::string::npos);
    CHECK(test::refusal("algebraic3d solid a = sphere(0,0,0;1); tlo a; tlo a b;", "geo").find("'b'") !=
          std::string::npos);
}

TEST_CASE("boundingbox clips only if the file has one") {
    const Model model = read_geo("solid a = plane(0,0,0;0,0,1); tlo a; boundingbox (-1, -2, -3; 4, 5, 6);");
    REQUIRE(model.clip);
    CHECK(model.clip->min == Vec3{-1, -2, -3});
    CHECK(model.clip->max == Vec3{4, 5, 6});
}

TEST_CASE("surfaces take the first boundary condition, else the name of their solid") {
    CHECK(surface_names(read_geo("solid a = sphere(0,0,0;1) and plane(0,0,0;0,0,1); tlo a;")) ==
          Names{"a", "a"});
    CHECK(surface_names(read_geo("solid a = sphere(0,0,0;1) -bc=3; tlo a;")) == Names{"bc_3"});
    CHECK(surface_names(read_geo("solid a = sphere(0,0,0;1) -bc=3 -bcname=wall; tlo a;")) == Names{"wall"});
    const char* used_twice =
        "solid p = plane(0,0,0;0,0,1); solid q = plane(0,0,-1;0,0,-1) -bc=1;"
        "solid a = p and q and sphere(0,0,0;5) -bc=2; solid b = p and q and sphere(9,0,0;5) -bc=3; tlo a; "
        "tlo b;";
    CHECK(surface_names(read_geo(used_twice), 0) == Names{"bc_2", "bc_1", "bc_2"});
    CHECK(surface_names(read_geo(used_twice), 1) == Names{"bc_2", "bc_1", "bc_3"});
    // A brick keeps its six faces apart unless a condition joins them.
    const Model plain = read_geo("solid a = orthobrick(0,0,0;1,1,1); tlo a;");
    CHECK(plain.nodes[0].primitive.planes[1].name == "xmax");
    CHECK(read_geo("solid a = orthobrick(0,0,0;1,1,1) -bc=1; tlo a;")
              .nodes[0]
              .primitive.planes[1]
              .name.empty());
    // A copy has surfaces of its own.
    const char* copied = "solid a = sphere(0,0,0;1); solid b = translate(5,0,0; a) -bc=7; tlo a; tlo b;";
    CHECK(surface_names(read_geo(copied), 0) == Names{"a"});
    CHECK(surface_names(read_geo(copied), 1) == Names{"bc_7"});
    CHECK(surface_names(read_geo("solid a = sphere(0,0,0;1); solid b = translate(5,0,0; a); tlo b;")) ==
          Names{"a"});
}

TEST_CASE("a polyhedron is what its faces enclose, whichever way they are turned") {
    const std::string points = "polyhedron(0,0,0; 2,0,0; 2,2,0; 0,2,0; 0,0,1; 2,0,1; 2,2,1; 0,2,1;; ";
    const std::string outward = "4,3,2,1; 5,6,7,8; 1,2,6,5; 2,3,7,6; 3,4,8,7; 4,1,5,8";
    const std::string inward = "1,2,3,4; 8,7,6,5; 5,6,2,1; 6,7,3,2; 7,8,4,3; 8,5,1; 8,1,4;";
    for (const std::string& faces : {outward, inward}) {
        CHECK(inside_geo(points + faces + ")", {1.9, 0.1, 0.9}));
        CHECK_FALSE(inside_geo(points + faces + ")", {1.9, 0.1, 1.1}));
        CHECK_FALSE(inside_geo(points + faces + ")", {2.1, 0.1, 0.5}));
    }
    const std::pair<std::string, const char*> cases[] = {
        {points + "1,2,9)", "names the point 9; expected a number from 1 to 8"},
        {points + "1,2,0.5)", "names the point 0.5"},
        {points + "1,2)", "a face has 2 points"},
        {points + "1,2,3,4,5)", "a face has 5 points"},
        {points + "1,2,3)", "at least four"},
        {"polyhedron(0,0,0 1,2,3)", "expected ';'"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = test::refusal("algebraic3d solid s = " + text + "; tlo s;", "geo");
        CAPTURE(message);
        CHECK(message.find(expected) != std::string::npos);
        CHECK(message.find("m.geo:1:") != std::string::npos);
    }
}

TEST_CASE("a polyhedron takes conditions face by face") {
    const std::string solid =
        "solid s = polyhedron(0,0,0; 2,0,0; 2,2,0; 0,2,0; 0,0,1;; 4,3,2,1; 1,2,5; 2,3,5; 3,4,5; 4,1,5)";
    const Model numbered = read_geo(solid + " -bc=[3,1,2,1,-1]; tlo s;");
    const auto surface_of = [](const Model& model) { return *model.nodes.at(0).primitive.triangles; };
    CHECK(numbered.nodes[0].name == "bc");
    CHECK(surface_of(numbered).group_names == Names{"3", "1", "2", "-1"});
    CHECK(surface_of(numbered).group == std::vector<std::uint32_t>{0, 0, 1, 2, 1, 3});
    const Model named = read_geo(solid + " -bcname=[floor,roof,roof,roof,roof]; tlo s;");
    CHECK(named.nodes[0].name == "s");
    CHECK(surface_of(named).group_names == Names{"floor", "roof"});
    // One condition for all faces, and the first one wins.
    const Model joined = read_geo(solid + " -bc=7; solid t = s and plane(0,0,0.5;0,0,1) -bc=8; tlo t;");
    CHECK(joined.nodes[0].name == "bc_7");
    CHECK(surface_of(joined).group_names == Names{""});
    CHECK(surface_of(read_geo(solid + " -bc=[3,1,2,1,1]; solid t = s and plane(0,0,0.5;0,0,1) -bc=8; tlo t;"))
              .group_names == Names{"3", "1", "2"});
    const std::string few = test::refusal("algebraic3d " + solid + " -bc=[1,2]; tlo s;", "geo");
    CHECK(few.find("-bc=[...] has 2 names; expected one for each of the 5 faces") != std::string::npos);
    const std::string ball = test::refusal("algebraic3d solid s = sphere(0,0,0;1) -bc=[1,2]; tlo s;", "geo");
    CHECK(ball.find("expected a solid that is one polyhedron") != std::string::npos);
}

TEST_CASE("boundarycondition and boundaryconditionname override where a surface bounds one region only") {
    const std::string start = "solid p = plane(0,0,0;0,0,1) -bc=1; solid a = p and sphere(0,0,0;1) -bc=2;";
    const Model named = read_geo(start + "tlo a; boundaryconditionname p a inlet;");
    CHECK(surface_names(named) == Names{"inlet", "bc_2"});
    CHECK(named.warnings.empty());
    CHECK(surface_names(read_geo(start + "tlo a; boundarycondition p a 9;")) == Names{"bc_9", "bc_2"});
    const Model shared =
        read_geo(start + "solid b = not p and sphere(0,0,0;1); tlo a; tlo b; boundarycondition p a 9;");
    CHECK(surface_names(shared) == Names{"bc_1", "bc_2"});
    CHECK(shared.warnings.size() == 1);
}

TEST_CASE("statements that change nothing yet warn once per kind") {
    const Model model = read_geo(
        "solid a = sphere(0,0,0;1) -bco=1; solid p = plane(0,0,0;0,0,1); solid q = plane(0,0,0;0,1,0) "
        "-bco=2; tlo a;"
        "tlo a p -col=[1,0,0] -bc=2;"
        "identify periodic p q; identify periodic q p; identify closesurfaces p q -tlo=a -slices=[0.1,0.2];"
        "singular face a p -factor=2; singular edge p q; singular point a p q; point (0, 0, -1) -factor=3;"
        "define constant identprec = 1e-6\n"
        "point (1, 1, 1); stray");
    const char* expected[] = {"-bco",          "-bc",
                              "-tlo",          "-slices",
                              "-factor",       "define constant",
                              "stray word",    "identify closesurfaces",
                              "singular face", "singular edge",
                              "singular point"};
    REQUIRE(model.warnings.size() == 11);
    for (std::size_t k = 0; k < 11; ++k) {
        CAPTURE(model.warnings[k]);
        CHECK(model.warnings[k].find(expected[k]) != std::string::npos);
        CHECK(model.warnings[k].rfind("m.geo:", 0) == 0);
    }
    CHECK(model.hints.size() == 2);
    CHECK(model.periodic.size() == 2);
    CHECK(model.regions.size() == 1);
}

TEST_CASE("hints name the primitives that bound regions; sizes are optional") {
    const Model model = read_geo(
        "solid p = plane(0,0,0;0,0,-1); solid q = plane(0,0,1;0,0,1); solid s = sphere(0,0,0;2);"
        "solid unused = sphere(9,0,0;1); solid a = p and q and s;"
        "identify closesurfaces p q; singular edge p s -maxh=0.25; singular face a s;"
        "singular point p q s -factor=2; point (1, 2, 3) -maxh=0.5; singular edge p unused; tlo a;");
    REQUIRE(model.hints.size() == 5);
    CHECK(model.hints[0].kind == SizeHint::Kind::kPoint);
    CHECK(model.hints[0].at == Vec3{1, 2, 3});
    CHECK(model.hints[0].max_size == 0.5);
    CHECK(model.hints[1].kind == SizeHint::Kind::kGap);
    CHECK(model.hints[1].groups == std::vector<std::vector<std::uint32_t>>{{0}, {1}});
    CHECK(model.hints[2].kind == SizeHint::Kind::kMeeting);
    CHECK(model.hints[2].groups == std::vector<std::vector<std::uint32_t>>{{0}, {2}});
    CHECK(model.hints[2].max_size == 0.25);
    CHECK(model.hints[3].groups == std::vector<std::vector<std::uint32_t>>{{2}});
    CHECK(model.hints[3].max_size == 0);
    CHECK(model.hints[4].groups.size() == 3);
    REQUIRE(model.warnings.size() == 2);
    CHECK(model.warnings[0].find("-factor") != std::string::npos);
    CHECK(model.warnings[1].find("singular edge") != std::string::npos);
    CHECK(test::refusal("algebraic3d solid a = sphere(0,0,0;1); tlo a; point (0,0,0) -maxh=-1;", "geo")
              .find("positive") != std::string::npos);
    CHECK(test::refusal("algebraic3d solid a = sphere(0,0,0;1); tlo a; singular edge a b;", "geo")
              .find("'b'") != std::string::npos);
}
