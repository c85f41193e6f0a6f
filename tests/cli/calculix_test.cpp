// Decks in the hands of a solver: CalculiX, if it is installed.
//
// The patch test: a linear displacement of the boundary is one of the inside, whatever the elements, if the
// solver sees them as they are meant, and elements of all types fit together. And what presses on a surface
// is what the supports bear, if its faces are the model's.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/cli/program.hpp"
#include "tests/io/deck.hpp"

namespace {

constexpr const char* kHoledBar =
    "difference() { cube([6, 2, 2]); translate([3, 1, -1]) cylinder(r = 0.5, h = 4); }";
constexpr const char* kMaterial =
    "*MATERIAL, NAME=STEEL\n*ELASTIC\n1000., 0.3\n*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL\n";

using Triple = std::array<double, 3>;

/// Where it must be there (.ci/run sets the variable) its absence is a failure.
bool has_calculix() {
    if (std::system("command -v ccx > /dev/null 2>&1") == 0) return true;
    CHECK_MESSAGE(std::getenv("MORTISE_NEEDS_CALCULIX") == nullptr, "CalculiX (ccx) is not installed");
    std::printf("skipped: CalculiX (ccx) is not installed\n");
    return false;
}

/// Solves mesh.inp with these lines behind it; what it prints about nodes.
std::map<int, Triple> solve(const ScratchFolder& folder, const std::string& lines) {
    folder.write("job.inp", "*INCLUDE, INPUT=mesh.inp\n" + lines);
    const std::string command = "cd '" + folder.file("") + "' && ccx job > job.log 2>&1";
    const int status = std::system(command.c_str());
    INFO(read_file(folder.file("job.log")));
    CHECK(status == 0);
    std::map<int, Triple> values;
    std::ifstream file(folder.file("job.dat"));
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        int node = 0;
        Triple value{};
        if (words >> node >> value[0] >> value[1] >> value[2]) values[node] = value;
    }
    return values;
}

Triple linear(const Triple& x) {
    return {1e-3 * x[0] + 2e-4 * x[1] - 3e-4 * x[2], 4e-4 * x[0] - 5e-4 * x[1] + 1e-4 * x[2],
            -2e-4 * x[0] + 3e-4 * x[1] + 7e-4 * x[2]};
}

}  // namespace

TEST_CASE("CalculiX: elements of all types pass the patch test") {
    if (!has_calculix()) return;
    using Arguments = std::vector<std::string>;
    for (const Arguments& extra : {Arguments{}, Arguments{"--layers", "2"}, Arguments{"--elements", "tet"},
                                   Arguments{"--elements", "tet", "--order", "2"}}) {
        const ScratchFolder folder;
        Arguments arguments = {
            folder.write("bar.csg", kHoledBar), "--level", "4", "-o", folder.file("mesh.inp"), "--quiet"};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        const Outcome outcome = run(arguments);
        INFO(outcome.err);
        REQUIRE(outcome.code == 0);
        const Deck deck(folder.file("mesh.inp"));
        std::set<int> boundary;
        for (const auto& [name, nodes] : deck.node_sets) boundary.insert(nodes.begin(), nodes.end());
        REQUIRE(boundary.size() < deck.nodes.size());
        std::ostringstream lines;
        lines.precision(12);
        lines << kMaterial << "*STEP\n*STATIC\n*BOUNDARY\n";
        for (const int node : boundary) {
            const Triple u = linear(deck.nodes.at(node));
            for (std::size_t j = 0; j < 3; ++j)
                lines << node << ", " << j + 1 << ", " << j + 1 << ", " << u[j] << "\n";
        }
        lines << "*NODE PRINT, NSET=NALL\nU\n*END STEP\n";
        const std::map<int, Triple> moved = solve(folder, lines.str());
        CHECK(moved.size() == deck.nodes.size());
        double worst = 0;
        for (const auto& [node, u] : moved) {
            const Triple expected = linear(deck.nodes.at(node));
            for (std::size_t j = 0; j < 3; ++j) worst = std::max(worst, std::fabs(u[j] - expected[j]));
        }
        // It prints seven digits; its four points of a curved C3D10 do not integrate exactly.
        const bool is_curved = extra.size() == 4;
        CHECK(worst < (is_curved ? 1e-7 : 1e-9));
    }
}

TEST_CASE("CalculiX: pressure on a surface of the model is what the supports bear") {
    if (!has_calculix()) return;
    const ScratchFolder folder;
    REQUIRE(
        run({folder.write("bar.csg", kHoledBar), "--level", "4", "-o", folder.file("mesh.inp"), "--quiet"})
            .code == 0);
    const std::map<int, Triple> forces =
        solve(folder, std::string(kMaterial) +
                          "*STEP\n*STATIC\n*BOUNDARY\nCUBE1_ZMIN, 1, 3, 0.\n*DSLOAD\nCUBE1_ZMAX, P, 2.5\n"
                          "*NODE PRINT, NSET=CUBE1_ZMIN\nRF\n*END STEP\n");
    REQUIRE(!forces.empty());
    Triple sum{};
    for (const auto& [node, force] : forces) {
        for (std::size_t j = 0; j < 3; ++j) sum[j] += force[j];
    }
    // Chords across a hole leave less of it.
    const double disc = std::acos(-1.0) * 0.25, area = 12 - disc;
    CHECK(sum[2] >= 2.5 * area - 1e-3);
    CHECK(sum[2] < 2.5 * (area + 0.2 * disc));
    CHECK(std::fabs(sum[0]) < 1e-3);
    CHECK(std::fabs(sum[1]) < 1e-3);
}
