// Models that are functions: .vm, .frep, .formula, and the nodes of .csg.
#include <doctest/doctest.h>

#include <cstring>

#include "tests/model/contains.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;
using mortise::test::contains;
using mortise::test::refusal;

namespace {

std::string expression_of(const Model& model) {
    for (const CsgNode& node : model.nodes) {
        if (node.primitive.kind == Primitive::Kind::kExpression) return node.primitive.expression;
    }
    return {};
}

ReadOptions extruded(double height) {
    ReadOptions options;
    options.extrude = height;
    return options;
}

/// A libfive archive, byte by byte.
struct Archive {
    std::string bytes;

    Archive& shape(const std::string& name) {
        bytes += "T\"" + name + "\"\"\"";
        return *this;
    }
    Archive& op(int code, std::initializer_list<std::uint32_t> arguments = {}) {
        bytes += static_cast<char>(code);
        for (const std::uint32_t a : arguments) {
            for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(a >> shift);
        }
        return *this;
    }
    Archive& constant(float value) {
        std::uint32_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        return op(1, {bits});
    }
    Archive& end() {
        bytes += "\xff\xff";
        return *this;
    }
};

}  // namespace

TEST_CASE(".vm: operations become definitions, the last one is the function") {
    const Model model = parse_model(
        "# a comment\n\nx var-x\r\n  0x1f var-z\nc const -2.5e-1\nr atan2 x 0x1f\nd sub r c\nr neg d\n", "vm",
        "m.vm");
    CHECK(expression_of(model) ==
          "_0 = x;\n_1 = z;\n_2 = (-0.25);\n_3 = atan2(_0, _1);\n_4 = _3 - _2;\n_5 = neg(_4);\n_5");
    REQUIRE(model.regions.size() == 1);
    CHECK(model.regions[0].name == "m");
}

TEST_CASE(".vm: each mistake has its place") {
    const std::pair<const char*, const char*> cases[] = {
        {"", "m.vm:1:1: the file holds no operation"},
        {"# only this\n", "the file holds no operation"},
        {"x\n", "m.vm:1:2: expected an operation after 'x'"},
        {"x var-w\n", "m.vm:1:3: unknown operation 'var-w'"},
        {"x var-x\ny add x\n", "m.vm:2:8: expected an argument of 'add'"},
        {"x var-x\ny add x q\n", "m.vm:2:9: 'q' is not defined"},
        {"x var-x\ny squaer x\n", "m.vm:2:3: unknown operation 'squaer'; expected one of const"},
        {"x var-x\ny squaer x\n", "did you mean 'square'?"},
        {"x var-x x\n", "m.vm:1:9: expected the end of the line"},
        {"x const\n", "m.vm:1:8: expected a number"},
        {"x const 1e999\n", "too large"},
        {"x const 1x\n", "malformed number"},
        {"z var-z\nr rand z\n", "m.vm:2:3: 'rand' makes random numbers"},
        {"z var-z\nr mix z z\n", "m.vm:2:3: 'mix' makes random numbers"},
        {"\xc3\xa9 var-x\n", "byte 0xc3"},
        {"x var-x\na const -4\n# root\nb sqrt a\nc add x b\n",
         "m.vm:4:3: 'sqrt' of these constants, sqrt((-4)), has no finite value"},
        {"a const 2\nb sub a a\nc div a b\nx var-x\n", "m.vm:3:3: 'div' of these constants, 2 / 0, has no"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal(text, "vm");
        CAPTURE(message);
        CHECK(contains(message, expected));
        CHECK(message[0] == '2');
    }
}

TEST_CASE("functions of x and y alone need --extrude, others refuse it") {
    const std::string flat = "x var-x\ny var-y\nr max x y\n";
    CHECK(contains(refusal(flat, "vm"), "--extrude H"));
    const Model solid = parse_model(flat, "vm", "m.vm", extruded(2.5));
    const CsgNode& root = solid.nodes[solid.regions[0].root];
    REQUIRE(root.op == CsgNode::Op::kIntersection);
    CHECK(solid.nodes[root.children[1]].primitive.planes[1].offset == 2.5);
    const std::pair<const char*, const char*> cases[] = {{"vm", "z var-z\n"}, {"csg", "cube(1);"}};
    for (const auto& [format, text] : cases) {
        try {
            parse_model(text, format, "m", extruded(1));
            FAIL("accepted");
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kUsage);
        }
    }
    CHECK(contains(refusal("x^2 + y^2 - 1", "formula"), "--extrude"));
    CHECK(refusal("x^2 + y^2 - 1\nbounds -2 -2 0 2 2 1", "formula").empty());
}

TEST_CASE(".frep: both numberings of operations, several shapes") {
    // x*z + 2: multiply and add are 18 and 17, or packed 21 and 20; the right argument comes first.
    const char* const expected = "_0 = x;\n_1 = z;\n_2 = 2;\n_3 = _0 * _1;\n_4 = _3 + _2;\n_4";
    for (const bool packed : {false, true}) {
        const Archive one = Archive()
                                .shape("a \\\" b")
                                .op(2)
                                .op(4)
                                .constant(2)
                                .op(packed ? 21 : 18, {1, 0})
                                .op(packed ? 20 : 17, {2, 3})
                                .end();
        const Model model = parse_model(one.bytes, "frep", "m.frep");
        CHECK(expression_of(model) == expected);
        CHECK(model.regions[0].name == "a \" b");
    }
    // abs is 28 or 17: the arity tells.
    const Archive size = Archive().shape("").op(4).op(17, {0}).op(20, {0, 1}).end();
    CHECK(expression_of(parse_model(size.bytes, "frep", "m.frep")) ==
          "_0 = z;\n_1 = abs(_0);\n_2 = _1 + _0;\n_2");
    Archive two = Archive().shape("").op(4).constant(1).op(17, {1, 0}).end().shape("second").op(9, {2}).end();
    two.bytes += std::string("t\"third\"\"\"\0\0\0\0\xff", 15);
    const Model both = parse_model(two.bytes, "frep", "m.frep");
    REQUIRE(both.regions.size() == 3);
    CHECK(both.regions[0].name == "m1");
    CHECK(both.regions[1].name == "second");
    CHECK(both.nodes[both.regions[2].root].primitive.expression.find("_0") != std::string::npos);
}

TEST_CASE(".frep: damaged and foreign files are refused with the byte") {
    const Archive good = Archive().shape("").op(4).constant(1).op(17, {1, 0}).end();
    CHECK(refusal(good.bytes, "frep").empty());
    for (std::size_t length = 0; length + 1 < good.bytes.size(); ++length) {
        const std::string message = refusal(good.bytes.substr(0, length), "frep");
        CAPTURE(length);
        CAPTURE(message);
        CHECK(contains(message, "m.frep: byte "));
    }
    const std::pair<std::string, const char*> cases[] = {
        {"solid ascii", "is this a libfive archive"},
        {Archive().shape("").op(99).end().bytes, "operation 99"},
        {Archive().shape("").op(5).end().bytes, "operation 5"},
        {Archive().shape("").op(4).op(9, {7}).end().bytes, "used before"},
        {Archive().shape("").end().bytes, "no operation"},
        {Archive().shape("").op(4).bytes + "\xff\"v\"", "free variables"},
    };
    for (const auto& [bytes, expected] : cases) {
        const std::string message = refusal(bytes, "frep");
        CAPTURE(message);
        CHECK(contains(message, expected));
    }
}

TEST_CASE(".formula: comments and bounds") {
    const Model model = parse_model(
        "# ball\nx^2 + y^2 +\n  z^2 - 1 # end\n  bounds -1 -2 -.5 +1 2 1e1 # box\n", "formula", "m.formula");
    REQUIRE(model.clip);
    CHECK(model.clip->min == Vec3{-1, -2, -0.5});
    CHECK(model.clip->max == Vec3{1, 2, 10});
    CHECK(!contains(expression_of(model), "bounds"));
    CHECK(!parse_model("bounds = z; bounds - 1", "formula", "m").clip);
    const std::pair<const char*, const char*> cases[] = {
        {"", "m.formula:1:1: the file holds no formula"},
        {"# z\nbounds 0 0 0 1 1 1\n", "holds no formula"},
        {"<html></html>\n",
         "m.formula:1:1: expected a formula (names, numbers and + - * / ^ ( ) , = ;), found '<'"},
        {"# a\nx + y\x01",
         "m.formula:2:6: expected a formula (names, numbers and + - * / ^ ( ) , = ;), found byte 0x01"},
        {"z\nbounds 0 0 0 1 1\n", "m.formula:2:17: expected a number"},
        {"z\nbounds 0 0 0 1 1 1 1\n", "m.formula:2:20: expected the end of the line"},
        {"z\nbounds 0 0 0 1 0 1\n", "m.formula:2:1: the bounds are empty along y"},
        {"z\nbounds 0 0 0 1 1 1\nbounds 0 0 0 1 1 1\n", "m.formula:3:1: a second line of bounds"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal(text, "formula");
        CAPTURE(message);
        CHECK(contains(message, expected));
    }
}

TEST_CASE(".formula: a mistake is told before the want of a z") {
    const std::pair<const char*, const char*> cases[] = {
        {"x^2 +", "m.formula:1:6: formula: expected a number"},
        {"x +\n y+w", "m.formula:2:4: formula: expected a number"},
        {"x^2 + y^2\n < 1",
         "m.formula:2:2: formula: expected an operator or the end of the formula, found '<'; the"},
        {"X^2+Y^2+Z^2-1", "found 'X'; did you mean 'x'?"},
        {"x - 1/0", "m.formula:1:5: formula: '1/0' has no finite value"},
        {"x*y\nboundz -1 -1 -1 1 1 1", "m.formula:2:1: formula: expected an operator"},
        {"x*y\nboundz -1 -1 -1 1 1 1", "found 'boundz'; bounds need a line of their own: bounds x0 y0"},
        {"x*y - 1 bounds -1 -1 -1 1 1 1", "found 'bounds'; bounds need a line of their own"},
        {"boundz -1 -1 -1 1 1 1\nx*y", "found 'boundz'; bounds need a line of their own"},
        {"a = 1;\nb = 2; a = 2;\na*x", "m.formula:2:8: formula: 'a' is defined twice, first in line 1"},
        {"x*y", "names no z: a flat figure; use --extrude H for the solid above it, 0 <= z <= H, or --box"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal(text, "formula");
        CAPTURE(message);
        CHECK(contains(message, expected));
    }
    CHECK(contains(refusal("z\nbounds 0 0 0 1 1 1e+400", "formula"), "the number '1e+400' is too large"));
}

TEST_CASE(".csg: implicit and periodic surfaces") {
    const Model model = parse_model("implicit(\"x^2+y^2+z^2-1\");", "csg", "m.csg");
    CHECK(expression_of(model) == "x^2+y^2+z^2-1");
    CHECK(model.nodes[0].where.column == 11);
    CHECK(model.nodes[0].name == "implicit1");
    const Model cut = parse_model("implicit(formula = \"z\", bounds = [[0,0,0],[1,2,3]]);", "csg", "m.csg");
    CHECK(cut.nodes[1].primitive.planes.size() == 6);
    const Model sheet =
        parse_model("schwarz_p(size=[4,5,6], period=2, thickness=0.2, center=true);", "csg", "m");
    CHECK(contains(expression_of(sheet), "max(f - "));
    CHECK(contains(expression_of(parse_model("gyroid(3);", "csg", "m")), "; f"));
    const std::pair<const char*, const char*> cases[] = {
        {"implicit();", "m.csg:1:1: 'implicit': expected a formula"},
        {"implicit(3);", "m.csg:1:10: 'implicit': expected a formula"},
        {"implicit(\"x\\n\");", "which has no meaning there"},
        {"implicit(\"z\", 3);", "bounds are not"},
        {"implicit(\"z\", [[0,0,0],[1,0,1]]);", "bounds are not"},
        {"implicit(\"z\", box=1);", "has no argument 'box'"},
        {"implicit(\"z\", [[0,0,0],[1,1,1]], 4);", "too many arguments"},
        {"implicit(\"z\") { cube(1); }", "takes no children"},
        {"gyroid(size=-1);", "size is -1"},
        {"gyroid(size=[1,2]);", "size is not a number"},
        {"gyroid(1, period=0);", "period is not a positive"},
        {"gyroid(1, thickness=-1);", "thickness is not a number from 0 on"},
        {"gyroid(1, center=2);", "center is neither"},
        {"gyroid(1, 1, 0.5);", "fill the box"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal(text, "csg");
        CAPTURE(message);
        CHECK(contains(message, expected));
    }
}
