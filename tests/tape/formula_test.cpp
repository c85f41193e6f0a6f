// Formulas: what is accepted, what is refused and where, and how min and max become set operations.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "host/formula/expression_parser.hpp"
#include "host/formula/formula_set.hpp"
#include "host/tape/reference.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

std::string refusal_of(const std::string& text) {
    try {
        std::vector<ExpressionOp> ops;
        const formula::Formula formula = formula::parse_formula(text);
        formula::emit_formula(formula, formula.root, ops);
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kInput);
        return error.what();
    }
    return {};
}

double value_of(const std::string& text, double x, double y, double z) {
    const formula::Formula formula = formula::parse_formula(text);
    std::vector<ExpressionOp> ops;
    const std::uint32_t count = formula::emit_formula(formula, formula.root, ops);
    REQUIRE(count == ops.size());
    const double u[3] = {x, y, z};
    return expression_value(ops.data(), count, u);
}

/// Of a formula's set, without those of the box.
std::size_t surfaces(const std::string& formula) {
    return bind_model(formula_model(formula, 1), 4).surfaces.size() - 6;
}

/// The set of a formula holds where its value is not positive.
void check_set(const std::string& formula, int count, RandomSource& random) {
    CAPTURE(formula);
    const tape::BoundModel model = bind_model(formula_model(formula, 1), 4);
    for (int i = 0; i < count; ++i) {
        const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const Vec3 at = to_model(model, local);
        bool inside = value_of(formula, at[0], at[1], at[2]) <= 0;
        for (const double x : at) inside = inside && std::fabs(x) <= 1;
        CHECK(tape::region_at(model, local[0], local[1], local[2]) == (inside ? 1 : 0));
    }
}

}  // namespace

TEST_CASE("formulas have the usual meaning") {
    struct Case {
        const char* text;
        std::function<double(double, double, double)> meaning;
    };
    const Case cases[] = {
        {"x-y-z", [](double x, double y, double z) { return (x - y) - z; }},
        {"x/y/z", [](double x, double y, double z) { return x / y / z; }},
        {"-x^2", [](double x, double, double) { return -(x * x); }},
        {"--x + +y", [](double x, double y, double) { return x + y; }},
        {"2*x^3*y", [](double x, double y, double) { return 2 * x * x * x * y; }},
        {"x^13", [](double x, double, double) { return std::pow(x, 13); }},
        {"(x+y)*(x-z)/1.5e0", [](double x, double y, double z) { return (x + y) * (x - z) / 1.5; }},
        {"min(x,y,z)",
         [](double x, double y, double z) {
             return std::min({x, y, z});
         }},
        {"max(x, min(y, z))", [](double x, double y, double z) { return std::max(x, std::min(y, z)); }},
        {"neg(abs(x)) + square(y)", [](double x, double y, double) { return y * y - std::fabs(x); }},
        {"sin(x)*cos(y)+exp(z)",
         [](double x, double y, double z) { return std::sin(x) * std::cos(y) + std::exp(z); }},
        {"log(x*x+1)/sqrt(y*y+pi)",
         [](double x, double y, double) {
             return std::log(x * x + 1) / std::sqrt(y * y + 3.14159265358979);
         }},
        {"x^-3", [](double x, double, double) { return 1 / (x * x * x); }},
        {"x^2^3 + 2^-1^2", [](double x, double, double) { return std::pow(x, 8) + 0.5; }},
        {"abs(x)^2.5 + pow(abs(y), z)",
         [](double x, double y, double z) {
             return std::pow(std::fabs(x), 2.5) + std::pow(std::fabs(y), z);
         }},
        {"tan(x/2) + asin(x/2) - acos(y/2)*atan(z) + ln(x*x+1)",
         [](double x, double y, double z) {
             return std::tan(x / 2) + std::asin(x / 2) - std::acos(y / 2) * std::atan(z) +
                    std::log(x * x + 1);
         }},
        {"atan2(y, x) + hypot(y, z) + sign(x)*recip(2+y^2) + 0*x^0",
         [](double x, double y, double z) {
             return std::atan2(y, x) + std::hypot(y, z) + (x > 0 ? 1 : -1) / (2 + y * y);
         }},
        {"mod(x, 0.5) + floor(y) + ceil(z) + round(3*x) + compare(x, y) + not(y)",
         [](double x, double y, double z) {
             return x - 0.5 * std::floor(x / 0.5) + std::floor(y) + std::ceil(z) + std::round(3 * x) +
                    (x < y ? -1 : 1);
         }},
        {"or(and(compare(x, y) + 1, x), y)", [](double x, double y, double) { return std::max(x, y); }},
        {"mix(x, y, z) + clamp(x, -0.5, 1)",
         [](double x, double y, double z) { return x + z * (y - x) + std::min(std::max(x, -0.5), 1.0); }},
        {"sinh(x) + cosh(y)*tanh(z) + tanh(500*x)/3 + cbrt(y)",
         [](double x, double y, double z) {
             return std::sinh(x) + std::cosh(y) * std::tanh(z) + (x > 0 ? 1 : -1) / 3.0 + std::cbrt(y);
         }},
        {"length(x, y, z) + length(x, y) - hypot(1, x, y, z) + atan(y, x)",
         [](double x, double y, double z) {
             return std::sqrt(x * x + y * y + z * z) + std::hypot(x, y) -
                    std::sqrt(1 + x * x + y * y + z * z) + std::atan2(y, x);
         }},
        {"log2(x*x + 1) - log10(3 + y) + radians(90*z) + degrees(x) + fract(5*y)",
         [](double x, double y, double z) {
             return std::log2(x * x + 1) - std::log10(3 + y) + 1.5707963267948966 * z +
                    x * 57.295779513082320877 + (5 * y - std::floor(5 * y));
         }},
        {"smoothstep(-0.5, 1, x)",
         [](double x, double, double) {
             const double t = x < -0.5 ? 0 : x > 1 ? 1 : (x + 0.5) / 1.5;
             return t * t * (3 - 2 * t);
         }},
        // The polynomial of degree two that meets min with its slope where the two differ by the width.
        {"smin(x, y, 0.75) + 2*smax(y, z, 1.5) + smin(x, z, 0) + smax(x, z, -1) + smin(x, y, 0*z)",
         [](double x, double y, double z) {
             const auto minimum = [](double a, double b, double width) {
                 if (std::fabs(a - b) >= width) return std::min(a, b);
                 const double t = 0.5 + 0.5 * (b - a) / width;
                 return b + t * (a - b) - width * t * (1 - t);
             };
             return minimum(x, y, 0.75) - 2 * minimum(-y, -z, 1.5) + std::min(x, z) + std::max(x, z) +
                    std::min(x, y);
         }},
        {"x**2 + 2 ** -y**2 - (x)**3",
         [](double x, double y, double) { return x * x + std::pow(2, -y * y) - x * x * x; }},
        {"length = 2; length(x, y) - length (1, z)*length",
         [](double x, double y, double z) { return std::hypot(x, y) - 2 * std::hypot(1, z); }},
        {"r2 = x^2 + y^2; # of the axis\n q = r2*z;\n q - r2;",
         [](double x, double y, double z) { return (x * x + y * y) * (z - 1); }},
        {" 1\t-\n.5 ", [](double, double, double) { return 0.5; }},
    };
    RandomSource random(61);
    for (const Case& one : cases) {
        for (int i = 0; i < 50; ++i) {
            const double x = random.uniform(-2, 2), y = random.uniform(-2, 2), z = random.uniform(-2, 2);
            CAPTURE(one.text);
            CHECK(value_of(one.text, x, y, z) == doctest::Approx(one.meaning(x, y, z)).epsilon(1e-12));
        }
    }
}

TEST_CASE("what is not a formula is refused with its column") {
    const std::pair<const char*, const char*> cases[] = {{"", "column 1:"},
                                                         {"x +", "column 4:"},
                                                         {"x y", "column 3:"},
                                                         {"2*(x+1", "column 7:"},
                                                         {"sin x", "column 5:"},
                                                         {"arsinh(x)", "column 1:"},
                                                         {"x^", "column 3:"},
                                                         {"atan2(x)", "column 8:"},
                                                         {"mix(x,y)", "column 8:"},
                                                         {"x = 1; y", "column 1:"},
                                                         {"sin = x; sin y", "column 14:"},
                                                         {"a = x y; a", "column 7:"},
                                                         {"a = x", "column 6:"},
                                                         {"a + (a = 1; a)", "column 1:"},
                                                         {"a < b", "column 1:"},
                                                         {"x < y", "column 3:"},
                                                         {"1e999", "column 1:"},
                                                         {"0x10", "column 2:"},
                                                         {"1e", "column 2:"},
                                                         {"sin(x,y)", "column 6:"},
                                                         {"min()", "column 5:"},
                                                         {"x)", "column 2:"},
                                                         {"x*/y", "column 3:"},
                                                         {"\xc3\xa9", "column 1:"},
                                                         {"0x10", "column 2:"},
                                                         {"1e", "column 2:"}};
    for (const auto& [text, column] : cases) {
        const std::string message = refusal_of(text);
        CAPTURE(text);
        CAPTURE(message);
        CHECK(message.find(column) != std::string::npos);
        CHECK(message.find("expected") != std::string::npos);
    }
    CHECK(refusal_of("sqroot(x) - 1").find("found 'sqroot'; did you mean 'sqrt'?") != std::string::npos);
    CHECK(refusal_of("radius = 2; x - radus").find("did you mean 'radius'?") != std::string::npos);
    CHECK(refusal_of(std::string(5000, '(')).find("nested") != std::string::npos);
    CHECK(refusal_of(std::string(100000, '-') + "x").empty());
}

TEST_CASE("messages about formulas name whole words and what to write instead") {
    const std::pair<const char*, const char*> cases[] = {
        {"x + 1e400", "column 5: expected a finite number, found '1e400'"},
        {"x + 2.5e+999*y", "column 5: expected a finite number, found '2.5e+999'"},
        {"z = 3; x", "column 1: 'z' has a meaning already; expected a new name"},
        {"sin = 3; sin = x; x", "column 10: 'sin' is defined twice, first in column 1"},
        {"x radius", "column 3: expected an operator or the end of the formula, found 'radius'"},
        {"sqrt(x,y)", "column 7: sqrt takes one argument; expected ')', found ','"},
        {"atan2(x)", "column 8: atan2 takes 2 arguments; expected ',', found ')'"},
        {"mod(x,y,z)", "column 8: mod takes 2 arguments; expected ')', found ','"},
        {"max(x y z)", "column 7: expected ',' or ')' in the arguments of max, found 'y'"},
        {"atan(x,y,z)", "column 9: atan takes 1 to 2 arguments; expected ')', found ','"},
        {"hypot(x)", "column 8: expected ',' in the arguments of hypot, found ')'"},
        {"x^2 <= 1", "found '<'; the solid is where the formula is at most 0: instead of a < b write a - b"},
        {"x^2 = 1", "found '='; the solid is where"},
        {"x && y", "found '&'; write max(a, b) for what is in both"},
        {"x || y", "found '|'; write min(a, b) for what is in either"},
        {"a = x % 2; a", "found '%'; write mod(a, b)"},
        {"x > 0 ? y : z", "found '>'; the solid is where"},
        {"a = 1; a = 2; a*x", "column 8: 'a' is defined twice, first in column 1; choose another name"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal_of(text);
        CAPTURE(message);
        CHECK(message.find(expected) != std::string::npos);
    }
    CHECK(refusal_of("x " + std::string(10000000, 'a')).size() < 300);
}

TEST_CASE("constants that are no finite numbers are refused at their place") {
    const std::pair<const char*, const char*> cases[] = {
        {"x - 1/0 + y", "column 5: '1/0' has no finite value"},
        {"-1/0", "column 1: '-1/0' has no finite value"},
        {"x*sqrt( -1 ) + y", "column 3: 'sqrt( -1 )' has no finite value"},
        {"x + 10^400 ", "column 5: '10^400' has no finite value"},
        {"a = 0; x + 1 / a", "column 12: '1 / a' has no finite value"},
        {"min(x, log(0))", "column 8: 'log(0)' has no finite value"},
        {"1e308 + 1e308", "column 1: '1e308 + 1e308' has no finite value"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal_of(text);
        CAPTURE(message);
        CHECK(message.find(expected) != std::string::npos);
    }
    // What is not constant may be infinite somewhere.
    CHECK(refusal_of("x/0 + sqrt(y) - 1/3").empty());
}

TEST_CASE("formulas that need too many registers are refused, long ones that do not are fine") {
    // Every product of pairs needs all of its factors, and these all of each other: no order helps.
    std::string mixed;
    std::string total = "0";
    for (int i = 0; i < 80; ++i) mixed += "a" + std::to_string(i) + " = sin(x + " + std::to_string(i) + ");";
    for (int round = 0; round < 2; ++round) {
        for (int i = 0; i < 80; ++i) {
            const std::string name = round == 0 ? "a" : "b";
            const int step = round == 0 ? 37 : 29;
            mixed += (round == 0 ? "b" : "c") + std::to_string(i) + " = " + name + std::to_string(i) + "*" +
                     name + std::to_string((i * step + 11) % 80) + ";";
        }
    }
    for (int i = 0; i < 80; ++i)
        total += "+ c" + std::to_string(i) + "*c" + std::to_string((i * 53 + 7) % 80);
    CHECK(refusal_of(mixed + total).find("intermediate values") != std::string::npos);
    std::string sum = "x";
    for (int i = 0; i < 3000; ++i) sum += "+sin(x+" + std::to_string(i) + ")";
    CHECK(refusal_of(sum).empty());
    // From either side, however deep.
    std::string nested;
    std::string closing;
    for (int i = 0; i < 400; ++i) {
        nested += "sin(x+" + std::to_string(i) + ")+(";
        closing += ")";
    }
    CHECK(refusal_of(nested + "y" + closing).empty());
}

TEST_CASE("equal operations are one node, and those of constants are none") {
    std::vector<ExpressionOp> ops;
    const formula::Formula formula = formula::parse_formula("2*x + 1 - y/3");
    CHECK(formula::emit_formula(formula, formula.root, ops) == 6);  // constants take no operation
    const formula::Formula same = formula::parse_formula("sin(x)*sin(x) + 2*(3-1)");
    CHECK(formula::emit_formula(same, same.root, ops) == 4);  // x, sin, *, +
}

TEST_CASE("shared min and max are expanded only while that stays short") {
    // Each level uses the one before twice: 2^40 leaves if it were expanded.
    std::string chain = "a0 = min(x, y);";
    for (int i = 1; i <= 40; ++i) {
        const std::string before = "a" + std::to_string(i - 1);
        chain += "a" + std::to_string(i) + " = max(min(" + before + ", z + " + std::to_string(0.01 * i) +
                 "), neg(" + before + ") - z);";
    }
    chain += "a40";
    const formula::Formula formula = formula::parse_formula(chain);
    const formula::FormulaSet set = formula::formula_set(formula);
    CHECK(set.nodes.size() < 4 * formula.nodes().size());
    const tape::BoundModel model = bind_model(formula_model(chain, 1), 4);
    CHECK(model.tape.size() < 2000);
    RandomSource random(63);
    for (int i = 0; i < 500; ++i) {
        const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const Vec3 at = to_model(model, local);
        bool inside = value_of(chain, at[0], at[1], at[2]) <= 0;
        for (const double x : at) inside = inside && std::fabs(x) <= 1;
        CHECK(tape::region_at(model, local[0], local[1], local[2]) == (inside ? 1 : 0));
    }
}

TEST_CASE("short formulas that use parts again and again take no long time") {
    std::string chain = "t0 = abs(x)-1;";
    for (int i = 1; i < 60; ++i) {
        const std::string before = "t" + std::to_string(i - 1), n = std::to_string(i);
        chain += "t" + n + " = max(max(" + before + ", y-" + n + "), max(" + before + ", z-" + n + "));";
    }
    std::string wide = "max(0";
    for (int i = 1; i < 300; ++i) wide += ", x-y*" + std::to_string(i);
    wide += ")";
    for (const std::string& text : {chain + "max(t59,0) + min(t59,0)", chain + "max(t59, mod(x,0.5)-0.3)",
                                    chain + "sqrt(square(max(t59,0)) + square(max(t59,0))) + min(t59,0)",
                                    "abs(" + wide + ") + abs(z + " + wide + ") - 1"}) {
        const formula::Formula formula = formula::parse_formula(text);
        const formula::Formula sharp = formula::with_sharp_edges(formula);
        CHECK(sharp.nodes().size() < 20 * formula.nodes().size());
        CHECK(formula::formula_set(sharp).nodes.size() < 20 * formula.nodes().size());
    }
}

TEST_CASE("what is not a number is outside of a set and of its mirror image") {
    // sqrt(x) - 0.5 and its negative: neither holds points with x < 0.
    for (const char* text : {"sqrt(x) - 0.5", "0.5 - sqrt(x)", "-(sqrt(x) - 0.5)", "-max(sqrt(x) - 0.5, -9)",
                             "-min(9, -max(-9, sqrt(x) - 0.5))"}) {
        const tape::BoundModel model = bind_model(formula_model(text, 1), 4);
        CAPTURE(text);
        int inside = 0;
        for (int i = 0; i < 100; ++i) {
            const Vec3 at = to_model(model, {(i + 0.5) / 100, 0.5, 0.5});
            const bool holds = tape::region_at(model, (i + 0.5) / 100, 0.5, 0.5) == 1;
            if (at[0] < 0) CHECK_FALSE(holds);
            inside += holds;
        }
        CHECK(inside > 5);
        tape::Cell cell{{0, 0.5, 0.5}, 0.05};
        cell.centre[0] = (-0.5 - model.origin[0]) / model.side;
        CHECK(tape::classify_cell(model, model.tape, cell, nullptr) == 0);
    }
}

TEST_CASE("absolute values become two surfaces where nothing but sums and multiples is above them") {
    CHECK(surfaces("abs(sin(x)+y*z)-0.4") == 2);
    CHECK(surfaces("0.2-abs(x*y)/-2") == 2);
    CHECK(surfaces("x^2+3*abs(x*y-z)*2-(0.3+z)") == 2);
    CHECK(surfaces("abs(x)+abs(y)+abs(z)-0.7") == 8);
    CHECK(surfaces("abs(abs(x*z)-0.3)-0.1") == 4);
    CHECK(surfaces("max(abs(x*y), abs(z*x))-0.1") == 4);  // constants go into any max and min
    CHECK(surfaces("2*max(x*y, z)/3-0.1") == 2);
    CHECK(surfaces("abs(max(x, y, z, x+y, x+z, y+z, x-y, x-z, y-z)) - 0.3") > 1);
    CHECK(surfaces("0.1-min(x*y, max(z, x-y))*-2") == 3);
    CHECK(surfaces("min(x*y, z)-x^2") == 2);  // so do functions without kinks
    CHECK(surfaces("max(x*y, z) + 0.1*sin(9*x)*length(y, z)") == 2);
    CHECK(surfaces("min(x*y, z) - sqrt((x*y-z)^2)/2") == 1);  // others may make a smooth union
    CHECK(surfaces("smin(x*y, z, 0.3)") == 1);
    // Where a part is no number all is outside, not that part alone.
    CHECK(surfaces("min(sqrt(x)-0.5, y) + 0.1*sin(z)") == 1);
    CHECK(surfaces("min(x*y, z) + log(y)") == 1);
    CHECK(surfaces("a = x*y; b = z; h = max(0.3-abs(a-b), 0); min(a, b)-h*h/1.2") == 1);
    CHECK(surfaces("min(max(abs(x*y), z), x-y)") == 3);  // x*y and its negative are one
    CHECK(surfaces("sqrt(abs(x*y))-0.3") == 1);
    // Each side of a function that jumps would jump where the absolute value does not.
    CHECK(surfaces("abs(mod(x,1)-0.5)-0.3") == 1);
    CHECK(surfaces("z-0.3*abs(2*mod(x+y,1)-1)") == 1);
    CHECK(surfaces("abs(atan2(y,x))-2") == 1);
    CHECK(surfaces("abs(x/y)-2") == 1);
    CHECK(surfaces("abs(x*y/3)-2") == 2);
    CHECK(surfaces("abs(x^3+y)-2") == 2);
    CHECK(surfaces("abs(x)+abs(y)+abs(z)+abs(x-y)+abs(y-z)-0.7") < 20);  // bounded
    RandomSource random(64);
    for (const char* formula :
         {"abs(sin(x)+y*z)-0.4", "0.2-abs(x*y)/-2", "x^2+3*abs(x*y-z)*2-(0.3+z)", "abs(x)+abs(y)+abs(z)-0.7",
          "abs(abs(x*z)-0.3)-0.1", "-2*(0.1-abs(z))*0.7-abs(x)/3", "abs(min(x,y))-0.2",
          "abs(sqrt(x)-0.5)-0.2", "abs(x)+abs(y)+abs(z)+abs(x-y)+abs(y-z)-0.7", "abs(x)*abs(y)-0.1",
          "-abs(x)", "abs(1/x)-3", "max(x,min(y,z))*-2+0.3", "1-min(x,y)/3", "max(abs(x),abs(y),abs(z))-0.7",
          "max(sqrt(x),y)-0.5", "0.2*sin(9*x)-min(x*y,z,x-z)", "x*y+(max(x,z)-z*z)"}) {
        CAPTURE(formula);
        const formula::Formula parsed = formula::parse_formula(formula);
        const formula::Formula split = formula::split_absolutes(parsed);
        std::vector<ExpressionOp> before, after;
        const std::uint32_t count_before = formula::emit_formula(parsed, parsed.root, before);
        const std::uint32_t count_after = formula::emit_formula(split, split.root, after);
        const tape::BoundModel model = bind_model(formula_model(formula, 1), 4);
        for (int i = 0; i < 500; ++i) {
            const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
            const Vec3 at = to_model(model, local);
            const double value = expression_value(before.data(), count_before, at.data());
            const double same = expression_value(after.data(), count_after, at.data());
            CHECK((value == same || (value != value && same != same)));
            bool inside = value <= 0;
            for (const double x : at) inside = inside && std::fabs(x) <= 1;
            CHECK(tape::region_at(model, local[0], local[1], local[2]) == (inside ? 1 : 0));
        }
    }
}

TEST_CASE("signed distances of sharp solids have a surface for each face") {
    const std::string q =
        "p = abs(x)-0.7; q = abs(y-0.1)-0.5; r = abs(z)-0.3;"
        "box = length(max(p,0), max(q,0), max(r,0)) + min(max(p, max(q, r)), 0);"
        "u = length(x, y) - 0.6; v = abs(z) - 0.4;"
        "rod = min(max(u, v), 0) + hypot(max(v, 0), max(0, u));";
    struct Case {
        const char* formula;
        std::size_t surfaces;
    };
    const Case cases[] = {
        {"box", 6},
        {"rod", 3},
        {"box + 0.05", 6},       // all of it a bit smaller
        {"box - 0.05", 1},       // with rounded edges
        {"0.1 - 2*box", 1},      // what lies outside of that
        {"-0.1 - 2*box", 6},     // outside of the smaller one
        {"abs(rod) - 0.03", 4},  // rounded outside, sharp inside
        {"max(rod, -box*0.5)", 9},
        {"min(box, rod, x + 0.9)", 10},
        {"sqrt(max(p,0)^2 + max(q,0)*max(q,0)) + min(max(q,p),0)", 4},
        {"max(p,0) + min(p,0)", 2},
        // A rod of that outline, sharp at its ends.
        {"o = length(max(p,0), max(q,0)) + min(max(p,q),0); length(max(o,0), max(r,0)) + min(max(r,o),0)", 6},
        {"length(max(p,0), max(q,0)) + min(max(p,q,r),0)", 1},  // no distance
        {"length(max(p,0), max(q,0), r) + min(max(p,q,r),0)", 1},
        {"length(max(p,0), max(q,0), max(r,0)) + min(max(p,q),0)", 1},
        {"length(max(p,0), max(q,0)) + min(max(p,q),0) + 0.01*sin(30*x)", 1},
        {"max(x-0.5, -(0*box)-1)", 2},
    };
    RandomSource random(65);
    for (const Case& one : cases) {
        const std::string formula = q + one.formula;
        CAPTURE(one.formula);
        CHECK(surfaces(formula) == one.surfaces);
        check_set(formula, 2000, random);
    }
}

TEST_CASE("functions that jump are one surface together where their min does not jump") {
    // Rods along the diagonals of cells of edge 0.6: where one ends at a face, the mirror image of another
    // goes on.
    const std::string cell =
        "X=mod(x,0.6)-0.3; Y=mod(y,0.6)-0.3; Z=mod(z,0.6)-0.3; q=X^2+Y^2+Z^2;"
        "a=q-(X+Y+Z)^2/3; b=q-(X+Y-Z)^2/3; c=q-(X-Y+Z)^2/3; d=q-(Y+Z-X)^2/3;";
    CHECK(surfaces(cell + "min(a,b,c,d)-0.01") == 1);
    CHECK(surfaces(cell + "max(min(a,b,c,d)-0.01,x+y,z-0.3)") == 3);
    CHECK(surfaces(cell + "max(0.01-a,x,0.01-b,0.01-c,0.01-d)") == 2);
    CHECK(surfaces(cell + "min(-max(0.01-a,0.01-b,0.01-c,0.01-d),x)") == 2);
    CHECK(surfaces(cell + "min(a,b,c)-0.01") == 3);  // without d the others end at faces
    // Square rods have edges of their own, which would be rounded off.
    CHECK(surfaces(
              "a=mod(x,0.6); b=mod(y,0.6); min(max(a,b),max(0.6-a,b),max(a,0.6-b),max(0.6-a,0.6-b))-0.2") ==
          4);
    // Steps are meant; a mod that does not jump joins nothing.
    CHECK(surfaces("min(z-0.3*floor(3*x),z-mod(y,0.5))") == 2);
    CHECK(surfaces("u=abs(mod(x,0.5)-0.25); v=abs(mod(y,0.5)-0.25); min(u+z^2-0.1,v+z^2-0.1)") == 2);
    RandomSource random(66);
    for (const char* end : {"min(a,b,c,d)-0.01", "max(min(a,b,c,d)-0.01,x+y,z-0.3)", "min(a,b,c)-0.01"}) {
        const std::string formula = cell + end;
        CAPTURE(end);
        check_set(formula, 2000, random);
    }
}

TEST_CASE("min, max and neg above the other operations become set operations") {
    CHECK(surfaces("x^2+y^2-0.3") == 1);
    CHECK(surfaces("min(x^2+y^2-0.3, z)") == 2);
    CHECK(surfaces("max(x-0.1, neg(min(y, z)), x*y)") == 4);
    CHECK(surfaces("max(x-0.1, x-0.1)") == 1);
    CHECK(surfaces("min(x,y)+z") == 2);
    RandomSource random(62);
    for (const char* formula : {"min(x^2+y^2-0.3, z)", "max(x-0.1, neg(min(y, z)), x*y)",
                                "neg(max(x, neg(y)))", "min(x, max(y, z-0.2))", "-max(x,y)"}) {
        check_set(formula, 500, random);
    }
}
