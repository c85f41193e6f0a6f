// Formulas: what is accepted, what is refused and where, and how min and max become set operations.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "host/tape/expression_parser.hpp"
#include "host/tape/reference.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

std::string refusal_of(const std::string& text) {
    try {
        std::vector<ExpressionOp> ops;
        const tape::Formula formula = tape::parse_formula(text);
        tape::emit_formula(formula, formula.root, ops);
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kInput);
        return error.what();
    }
    return {};
}

double value_of(const std::string& text, double x, double y, double z) {
    const tape::Formula formula = tape::parse_formula(text);
    std::vector<ExpressionOp> ops;
    const std::uint32_t count = tape::emit_formula(formula, formula.root, ops);
    REQUIRE(count == ops.size());
    const double u[3] = {x, y, z};
    return expression_value(ops.data(), count, u);
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
                                                         {"tan(x)", "column 1:"},
                                                         {"x^y", "column 3:"},
                                                         {"x^0", "column 4:"},
                                                         {"x^-1", "column 3:"},
                                                         {"x^2^3", "column 4:"},
                                                         {"x^99999999999999999999", "column "},
                                                         {"1e999", "column 1:"},
                                                         {"sin(x,y)", "column 6:"},
                                                         {"min()", "column 5:"},
                                                         {"x)", "column 2:"},
                                                         {"x*/y", "column 3:"},
                                                         {"\xc3\xa9", "column 1:"}};
    for (const auto& [text, column] : cases) {
        const std::string message = refusal_of(text);
        CAPTURE(text);
        CAPTURE(message);
        CHECK(message.find(column) != std::string::npos);
        CHECK(message.find("expected") != std::string::npos);
    }
    CHECK(refusal_of(std::string(5000, '(')).find("nested") != std::string::npos);
    CHECK(refusal_of(std::string(100000, '-') + "x").empty());
}

TEST_CASE("formulas that need too many registers are refused, long ones that do not are fine") {
    std::string nested;
    std::string closing;
    for (int i = 0; i < 80; ++i) {
        nested += "sin(x+" + std::to_string(i) + ")+(";
        closing += ")";
    }
    CHECK(refusal_of(nested + "y" + closing).find("intermediate values") != std::string::npos);
    std::string sum = "x";
    for (int i = 0; i < 3000; ++i) sum += "+sin(x+" + std::to_string(i) + ")";
    CHECK(refusal_of(sum).empty());
}

TEST_CASE("min, max and neg above the other operations become set operations") {
    const auto surfaces = [](const std::string& formula) {
        return bind_model(formula_model(formula, 1), 4).surfaces.size() - 6;  // without those of the box
    };
    CHECK(surfaces("x^2+y^2-0.3") == 1);
    CHECK(surfaces("min(x^2+y^2-0.3, z)") == 2);
    CHECK(surfaces("max(x-0.1, neg(min(y, z)), x*y)") == 4);
    CHECK(surfaces("max(x-0.1, x-0.1)") == 1);
    CHECK(surfaces("min(x,y)+z") == 1);
    RandomSource random(62);
    for (const char* formula : {"min(x^2+y^2-0.3, z)", "max(x-0.1, neg(min(y, z)), x*y)",
                                "neg(max(x, neg(y)))", "min(x, max(y, z-0.2))", "-max(x,y)"}) {
        const tape::BoundModel model = bind_model(formula_model(formula, 1), 4);
        for (int i = 0; i < 500; ++i) {
            const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
            const Vec3 at = to_model(model, local);
            bool inside = value_of(formula, at[0], at[1], at[2]) <= 0;
            for (const double x : at) inside = inside && std::fabs(x) <= 1;
            CAPTURE(formula);
            CHECK(tape::region_at(model, local[0], local[1], local[2]) == (inside ? 1 : 0));
        }
    }
}
