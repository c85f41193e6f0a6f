// Solids that are functions, meshed: volumes against closed forms and sums over the function itself.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "host/common/constants.hpp"
#include "tests/corpora.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

double asset_volume(const char* name, int level, int euler_characteristic) {
    const Model model = read_model(std::string(MORTISE_SOURCE_DIR "/assets/models/") + name);
    const Meshed meshed = mesh_and_check(model, level);
    INFO(name);
    CHECK(meshed.defects == "");
    if (euler_characteristic != 0) CHECK(meshed.check.euler_characteristic == euler_characteristic);
    return enclosed_volume(meshed.mesh, 1);
}

double formula_volume(const std::string& text, int level) {
    const Meshed meshed = mesh_and_check(parse_model(text, "formula", "m.formula"), level);
    CAPTURE(text);
    CHECK(meshed.defects == "");
    return enclosed_volume(meshed.mesh, 1);
}

}  // namespace

TEST_CASE("assets: a formula and a periodic sheet") {
    // Sum over a grid of 200³ points.
    double tangle = 0;
    const int count = 200;
    const double step = 2.6 / count;
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j < count; ++j) {
            for (int k = 0; k < count; ++k) {
                double f = 10;
                for (const int n : {i, j, k}) {
                    const double square = std::pow((n + 0.5) * step, 2);
                    f += square * (square - 5);
                }
                if (f <= 0) tangle += 8 * step * step * step;
            }
        }
    }
    // Twelve edges that join eight corners: genus 5.
    CHECK(asset_volume("tangle.formula", 6, 2 - 2 * 5) == doctest::Approx(tangle).epsilon(0.005));
    const double box = kPi * (100 - 9) * 12;
    const double sheet = asset_volume("gyroid.csg", 6, 0);
    CHECK(sheet > 0.4 * box);  // 3.09 of area per cube of the period, times the thickness
    CHECK(sheet < 0.6 * box);
}

TEST_CASE("formulas without a value on a plane, a line or a point are as solid there as beside it") {
    // The same functions with what they lack; vertices of the grid lie where they lack it.
    const std::pair<const char*, const char*> pairs[] = {
        {"hypot(x,hypot(y,z))-1-0.2*sin(x)/x\nbounds -2 -2 -2 2 2 2\n",
         "hypot(x,hypot(y,z))-1-0.2*sin(x+1e-9)/(x+1e-9)\nbounds -2 -2 -2 2 2 2\n"},
        {"r=hypot(x,hypot(y,z)); r-1-0.3*(z/r)^2\nbounds -2 -2 -2 2 2 2\n",
         "r=hypot(x+1e-9,hypot(y,z)); r-1-0.3*(z/r)^2\nbounds -2 -2 -2 2 2 2\n"},
        {"q=5*hypot(x,y); max(z-sin(q)/q, max(hypot(x,y)-1.7, -z-1))\nbounds -2 -2 -2 2 2 2\n",
         "q=1e-9+5*hypot(x,y); max(z-sin(q)/q, max(hypot(x,y)-1.7, -z-1))\nbounds -2 -2 -2 2 2 2\n"}};
    for (const auto& [lacking, whole] : pairs) {
        CAPTURE(lacking);
        const Meshed m = mesh_and_check(parse_model(lacking, "formula", "m.formula"), 5);
        const Meshed expected = mesh_and_check(parse_model(whole, "formula", "m.formula"), 5);
        CHECK(m.defects == "");
        CHECK(m.check.euler_characteristic == 2);
        CHECK(m.check.components == 1);
        CHECK(m.check.volume == doctest::Approx(expected.check.volume).epsilon(1e-4));
        CHECK(*std::min_element(m.report.scaled_jacobians.begin(), m.report.scaled_jacobians.end()) > 0.19F);
        CHECK(m.report.warnings.empty());
    }
}

TEST_CASE("a twisted bar, whose formula tells nothing of it far away, is found around the origin") {
    const std::string text =
        "t=z*pi/2; u=x*cos(t)+y*sin(t); v=y*cos(t)-x*sin(t); max(max(abs(u)-0.5,abs(v)-0.2),abs(z)-1)";
    const Meshed bar = mesh_and_check(parse_model(text, "formula", "m.formula"), 5);
    CHECK(bar.defects == "");
    CHECK(bar.check.euler_characteristic == 2);
    CHECK(bar.check.volume == doctest::Approx(0.8).epsilon(2e-3));
    REQUIRE(bar.report.warnings.size() == 1);
    CHECK(bar.report.warnings[0].find("could not be shown to end") != std::string::npos);
    // Nothing around it is needed for that: a lattice without end is still refused.
    CHECK_THROWS_AS(mesh_and_check(parse_model("sin(x)+sin(y)+sin(z)", "formula", "m.formula"), 5), Error);
}

TEST_CASE("a triangle wave of mod and abs is whole where mod jumps") {
    // Three ridges and two halves, 0.15 high, on a slab.
    const std::string text = "max(z - 0.3*abs(mod(x,1)-0.5), abs(y)-0.3)\nbounds -1 -1 -1 1 1 1";
    const Meshed wave = mesh_and_check(parse_model(text, "formula", "m.formula"), 5);
    CHECK(wave.defects == "");
    CHECK(wave.check.euler_characteristic == 2);
    CHECK(wave.check.components == 1);
    CHECK(wave.report.hinge_edges + wave.report.hinge_nodes == 0);
    CHECK(wave.check.volume == doctest::Approx(2 * 0.6 * (1 + 0.075)).epsilon(1e-3));
}

TEST_CASE("creases below a sum leave no single elements hanging on the rest") {
    const char* const models[] = {
        "t=asin(sin(4*(0.8*x+0.6*y))); max(z*0.96+0.28*x-0.25*t,-z-1,abs(x)-2,abs(y)-2)\n"
        "bounds -5 -5 -5 5 5 5\n",
        "r=hypot(x,y); t=asin(sin(2*pi*z/0.8+atan2(y,x))); max(r-2.3-0.13*t,abs(z)-3)\n"
        "bounds -5 -5 -5 5 5 5\n"};
    for (const char* const text : models) {
        const Meshed meshed = mesh_and_check(parse_model(text, "formula", "m.formula"), 6);
        CAPTURE(text);
        CHECK(meshed.defects == "");
        CHECK(meshed.check.components == 1);
        CHECK(meshed.report.crumbs > 0);
    }
}

TEST_CASE("a lattice of rods that mod repeats is whole, and no tip of a groove is called a hole") {
    // In eight cells 35 nodes (corners and centres) and 64 rods: 35 - 64 = -29 is that of the solid, its skin
    // has twice as much.
    const std::string cell = "X=mod(x,6)-3; Y=mod(y,6)-3; Z=mod(z,6)-3;";
    const std::string box = ",-x,-y,-z,x-12,y-12,z-12)";
    const std::string rods = cell +
                             "q=X^2+Y^2+Z^2; a=q-(X+Y+Z)^2/3; b=q-(X+Y-Z)^2/3; c=q-(X-Y+Z)^2/3;"
                             "d=q-(Y+Z-X)^2/3; max(min(a,b,c,d)-0.64" +
                             box;
    const std::string mirrored = cell +
                                 "a=abs(X); b=abs(Y); c=abs(Z); d=(a+b+c)/3;"
                                 "max(sqrt((a-d)^2+(b-d)^2+(c-d)^2)-0.8" +
                                 box;
    for (const std::string& text : {rods, mirrored}) {
        CAPTURE(text);
        const Meshed meshed = mesh_and_check(parse_model(text, "formula", "m.formula"), 5);
        CHECK(meshed.defects == "");
        CHECK(meshed.check.euler_characteristic == -58);
        CHECK(meshed.check.components == 1);
        CHECK(meshed.report.missed.empty());
        CHECK(meshed.report.hinge_edges == 0);
    }
}

TEST_CASE("signed distances and rippled solids keep their sharp edges") {
    // A box turned about z, as its distance; a cube with ripples.
    const std::string turned =
        "u = 0.8*x + 0.6*y; v = 0.8*y - 0.6*x; p = abs(u) - 1; q = abs(v) - 0.7; r = abs(z) - 0.5;"
        "length(max(p,0), max(q,0), max(r,0)) + min(max(p, max(q, r)), 0)";
    const std::string rippled = "max(abs(x), abs(y), abs(z)) - 1 + 0.05*sin(6*x)*sin(6*y)*sin(6*z)";
    double rippled_volume = 0;  // a sum over a grid of 128³ points in an eighth, and its mirror images
    const double step = 1.1 / 128;
    for (int n = 0; n < 128 * 128 * 128; ++n) {
        const double x = (n % 128 + 0.5) * step, y = (n / 128 % 128 + 0.5) * step,
                     z = (n / 16384 + 0.5) * step;
        const double ripple = 0.05 * std::sin(6 * x) * std::sin(6 * y) * std::sin(6 * z);
        for (const double sign : {1, -1}) {
            if (std::max({x, y, z}) - 1 + sign * ripple <= 0) rippled_volume += 4 * step * step * step;
        }
    }
    for (const std::string& text : {turned, rippled}) {
        CAPTURE(text);
        const Meshed meshed = mesh_and_check(parse_model(text, "formula", "m.formula"), 5);
        CHECK(meshed.defects == "");
        CHECK(meshed.check.euler_characteristic == 2);
        CHECK(meshed.report.features.curves.size() == 12);
        CHECK(meshed.report.features.corners.size() == 8);
        CHECK(meshed.report.warnings.empty());
        if (text == turned) CHECK(meshed.check.volume == doctest::Approx(2.8).epsilon(1e-9));
        if (text == rippled) CHECK(meshed.check.volume == doctest::Approx(rippled_volume).epsilon(1e-3));
    }
}

TEST_CASE("a sheet |f| < t has both its sides where it is about a cell thick") {
    // Cells are 0.42 wide, the sheet is 0.46 thick where f is steepest.
    const char* const kBox = "bounds -6.28 -6.28 -6.28 6.28 6.28 6.28\n";
    const auto mesh_of = [&](const char* text) {
        const Meshed meshed =
            mesh_and_check(parse_model(std::string("g = cos(x)+cos(y)+cos(z); ") + text + "\n" + kBox,
                                       "formula", "m.formula"),
                           5);
        CAPTURE(text);
        CHECK(meshed.defects == "");
        const auto& jacobians = meshed.report.scaled_jacobians;
        CHECK(*std::min_element(jacobians.begin(), jacobians.end()) > 0.18f);
        return meshed;
    };
    const Meshed sheet = mesh_of("abs(g) - 0.4");
    const Meshed two = mesh_of("max(g - 0.4, -g - 0.4)");
    CHECK(sheet.check.euler_characteristic == -64);
    CHECK(two.check.euler_characteristic == -64);
    CHECK(enclosed_volume(sheet.mesh, 1) == doctest::Approx(enclosed_volume(two.mesh, 1)).epsilon(1e-9));
    // Graded, and as a difference.
    CHECK(mesh_of("0.02*x + 0.4 - abs(g)").check.euler_characteristic ==
          mesh_of("min(0.02*x + 0.4 - g, 0.02*x + 0.4 + g)").check.euler_characteristic);
}

TEST_CASE("operations in formulas: volumes known on paper") {
    CHECK(formula_volume("hypot(hypot(x, y), z) - 1", 5) == doctest::Approx(4 * kPi / 3).epsilon(0.01));
    CHECK(formula_volume("max(hypot(x, y) - 1, abs(z) - 1)", 5) == doctest::Approx(2 * kPi).epsilon(0.01));
    // A quarter of a cylinder between two angles, away from the cut of atan2.
    CHECK(formula_volume("max(max(hypot(x, y) - 1, abs(z) - 1), abs(atan2(y, x)) - pi/4)", 5) ==
          doctest::Approx(kPi / 2).epsilon(0.02));
    // Not a number for x < 0: a paraboloid of revolution about x, cut at x = 1.
    CHECK(formula_volume("max(hypot(y, z) - sqrt(x), x - 1)", 5) == doctest::Approx(kPi / 2).epsilon(0.02));
    CHECK(formula_volume("mod(x, 1)^2 - mod(x, 1) + (y^2 + z^2)*4 \nbounds 0 -1 -1 2 1 1", 6) ==
          doctest::Approx(2 * kPi / 4 / 6).epsilon(0.03));
    // Constants beside max and min leave edges sharp.
    for (const char* cube : {"max(abs(x), max(abs(y), abs(z))) - 1", "2*max(x, -x, y, -y, z, -z) - 2",
                             "1 - min(1 - x, 1 + x, 1 - y, 1 + y, 1 - z, 1 + z) - 1"}) {
        CAPTURE(cube);
        CHECK(formula_volume(cube, 5) == doctest::Approx(8).epsilon(1e-9));
    }
    CHECK(formula_volume("abs(x)^2.5 + abs(y)^2.5 + abs(z)^2.5 - 1", 5) ==
          doctest::Approx(8 * std::pow(std::tgamma(1.4), 3) / std::tgamma(2.2)).epsilon(0.01));
}

TEST_CASE("bounds of functions are found; unbounded ones are refused with a way out") {
    const auto refusal_of = [](const std::string& text) {
        try {
            mesh_and_check(parse_model(text, "formula", "m.formula"), 3);
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK(refusal_of("x^2 + y^2 + 0*z - 1").find("--box") != std::string::npos);
    CHECK(refusal_of("z").find("--box") != std::string::npos);
    CHECK(refusal_of("x^2 + y^2 + z^2 + 1").find("empty") != std::string::npos);
    CHECK(refusal_of("x +\n * z").find("m.formula:2:2: formula: expected") != std::string::npos);
    // Far from the origin, small, or of exponentials that overflow on the way.
    CHECK(formula_volume("(x - 3000)^2 + (y + 500)^2 + z^2 - 400", 4) ==
          doctest::Approx(4 * kPi / 3 * 8000).epsilon(0.05));
    CHECK(formula_volume("-log(exp(-40*(hypot(x, y) - 1)) + exp(-40*(hypot(y, z) - 1)))/40 + 100*square("
                         "max(0, hypot(x, hypot(y, z)) - 2))",
                         4) > 5);
    // A shared minimum, used with both signs: empty far away, which only its cases show.
    CHECK(formula_volume("m = min(x, y); max(max(m, neg(m) - 1), max(hypot(x, y) - 3, abs(z) - 1))", 5) > 10);
}

TEST_CASE("functions that are 0 throughout a part of space are refused, with a place") {
    const std::string ball = "r = hypot(hypot(x, y), z); ";
    const std::string box = "\nbounds -2 -2 -2 2 2 2";
    for (const char* f : {"max(r - 1, 0)", "min(r - 1, 0)", "-max(0, 1 - r)"}) {
        CAPTURE(f);
        CHECK_THROWS_WITH_AS(formula_volume(ball + f + box, 4),
                             "m.formula:1:1: formula: an argument of min or max is 0 everywhere, which is "
                             "neither inside nor outside; write a small number instead",
                             Error);
    }
    // Between the radii 0.5 and 1, and beyond 1.
    for (const char* f : {"max(r - 1, 0)^2 - max(0.5 - r, 0)^2", "a = max(0, 1 - r); -a^3"}) {
        CAPTURE(f);
        std::string message;
        try {
            formula_volume(ball + f + box, 4);
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);
            message = error.what();
        }
        CHECK(message.find("a function is 0 throughout a part of space, as around (") != std::string::npos);
    }
    // Zero in a plane, on an axis, at a point.
    CHECK(formula_volume(ball + "max(r - 1, x)" + box, 4) == doctest::Approx(2 * kPi / 3).epsilon(0.05));
    CHECK(formula_volume("max(x^2 + y^2 + z^2 - 1, -x^2)" + box, 4) ==
          doctest::Approx(4 * kPi / 3).epsilon(0.05));
}

TEST_CASE("models of the corpora: functions of Fidget and libfive") {
    const std::string corpora = corpora_folder().string();
    struct File {
        const char* name;
        double volume;  ///< 0: any
    };
    const File files[] = {{"fidget/tanglecube.vm", 46.4},
                          {"fidget/colonnade.vm", 0.6224},
                          {"fidget/bear.vm", 0},
                          {"mpr/hello_world.frep", 0},
                          {"mpr/involute_gear_3d.vm", 0}};
    int skipped = 0;
    for (const File& file : files) {
        const std::string path = corpora + "/" + file.name;
        if (!std::filesystem::exists(path)) {
            ++skipped;
            continue;
        }
        const Meshed meshed = mesh_and_check(read_model(path), 5);
        INFO(file.name);
        CHECK(meshed.defects == "");
        if (file.volume > 0)
            CHECK(enclosed_volume(meshed.mesh, 1) == doctest::Approx(file.volume).epsilon(0.02));
    }
    if (skipped > 0) std::cout << "functions of the corpora: " << skipped << " files are not there\n";
}

}  // namespace mortise::test
