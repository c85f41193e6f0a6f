// --quality, --quality-floor and --features.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/cli/program.hpp"

namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("--min-angle: every element has it") {
    const ScratchFolder scratch;
    const std::string vtu = scratch.file("a.vtu");
    const Outcome outcome =
        run({asset("cyl_cyl_int.csg"), "-o", vtu, "--level", "4", "--min-angle", "26", "--json"});
    REQUIRE(outcome.code == 0);
    CHECK(Json::parse(outcome.out)["below_min_angle"] == 0);
    const Json check = Json::parse(run({"check", vtu, "--quality", "--json"}).out);
    CHECK(check["quality"]["dihedral_angles"]["min"].get<double>() >= 25.99);
}

TEST_CASE("--quality: a report for people, and the same figures as JSON") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string vtu = scratch.file("out/a.vtu"), vtp = scratch.file("out/a.vtp");
    const Outcome people =
        run({asset("block.csg"), "-o", vtu, "--level", "4", "--quality", "--features", vtp});
    REQUIRE(people.code == 0);
    for (const char* part : {"scaled Jacobian", "angles", "worst elements", "mesh to model", "model to mesh",
                             "corners       8 expected, 8 found", "creases       12", "a.vtp"}) {
        CAPTURE(part);
        CHECK(contains(people.out, part));
    }
    CHECK(std::count(people.out.begin(), people.out.end(), '\n') <= 46);
    CHECK(scratch.names("out") == Names{"a.vtp", "a.vtu"});
    CHECK(contains(read_file(vtp), "PolyData"));

    const Outcome json = run({asset("block.csg"), "-o", vtu, "--level", "4", "--quality", "--json"});
    REQUIRE(json.code == 0);
    const Json document = Json::parse(json.out);
    const Json& quality = document["quality"];
    CHECK(quality["corners"]["expected"] == 8);
    CHECK(quality["corners"]["found"] == 8);
    CHECK(quality["corners"]["missing"].empty());
    CHECK(quality["creases"].size() == 12);
    CHECK(quality["surfaces"].size() == 6);
    CHECK(quality["worst"].size() == 10);
    for (const auto& [type, count] : document["elements"].items()) {
        const Json& shape = quality["scaled_jacobian"][type];
        if (count == 0) {
            CHECK(shape.is_null());
            continue;
        }
        CHECK(shape["count"] == count);
        CHECK(shape["min"].get<double>() ==
              doctest::Approx(document["min_scaled_jacobian"][type].get<double>()).epsilon(1e-6));
    }
    CHECK(document["features"]["corners"] == 8);

    // The part that needs no model, from the file.
    const Json check = Json::parse(run({"check", vtu, "--quality", "--json"}).out);
    CHECK(check["quality"]["dihedral_angles"] == quality["dihedral_angles"]);
    CHECK(check["quality"]["scaled_jacobian"] == quality["scaled_jacobian"]);
    CHECK_FALSE(check["quality"].contains("corners"));
    CHECK(contains(run({"check", vtu, "--quality"}).out, "worst elements"));
}

TEST_CASE("--quality-floor: exit code 4 and one line, with the mesh written") {
    const ScratchFolder scratch;
    scratch.names("out");
    const std::string vtu = scratch.file("out/a.vtu");
    const Names common = {asset("block.csg"), "-o", vtu, "--level", "3", "--json"};
    const auto with_floor = [&](const std::string& floor) {
        Names arguments = common;
        arguments.insert(arguments.end(), {"--quality-floor", floor});
        return run(arguments);
    };
    const Outcome met = with_floor("0");
    REQUIRE(met.code == 0);
    double worst = 1;
    const Json document = Json::parse(met.out);
    for (const Json& value : document["min_scaled_jacobian"]) {
        if (!value.is_null()) worst = std::min(worst, value.get<double>());
    }
    CHECK(with_floor(std::to_string(0.99 * worst)).code == 0);
    std::filesystem::remove(vtu);
    const Outcome below = with_floor(std::to_string(std::min(1.0, 1.01 * worst)));
    CHECK(below.code == 4);
    CHECK(is_one_line(below.err, "mortise: quality floor "));
    for (const char* part : {" not met: ", " of ", "the worst is ", " at (", "scaled Jacobian"}) {
        CHECK(contains(below.err, part));
    }
    CHECK(scratch.names("out") == Names{"a.vtu"});
    CHECK(run({"check", vtu}).code == 0);
    CHECK(contains(run({"--help"}).out, "4 quality floor"));
    for (const char* wrong : {"-0.1", "1.5", "good", ""}) {
        CAPTURE(wrong);
        const Outcome outcome = with_floor(wrong);
        CHECK(outcome.code == 1);
        CHECK(is_one_line(outcome.err, "mortise: --quality-floor"));
    }
    CHECK(run({asset("block.csg"), "-o", vtu, "--features", scratch.file("out/a.txt")}).code == 1);
    CHECK(run({asset("block.csg"), "-o", vtu, "--features", scratch.file("none/a.vtp")}).code == 6);
}
