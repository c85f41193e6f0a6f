// Elements each of whose nodes has another worst element: none of them can move to improve its own worst, but
// all come nearer to the target together (Block::relax).
#include <doctest/doctest.h>

#include "mortise/model.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {

TEST_CASE("a stuck element gets the smallest angle that all others have") {
    // Of 18 million elements of random smooth solids the only one that was left with 17.985 degrees.
    const char* text =
        "u = -0.57380969656181557 * (x + 0.11148856472050972) + 0.56610382324249486 * (y + "
        "0.14348261934151441) + "
        "0.59183519111477967 * (z + 0.677878474098218);\n"
        "v = 0.27391813325952891 * (x + 0.11148856472050972) - 0.54836815274356709 * (y + "
        "0.14348261934151441) + "
        "0.79010203475767826 * (z + 0.677878474098218);\n"
        "w = 0.77182335310824368 * (x + 0.11148856472050972) + 0.61548259956463325 * (y + "
        "0.14348261934151441) + "
        "0.15959286083628266 * (z + 0.677878474098218);\n"
        "u^2 + v^2 + w^2 - 1 + 0.25 * sin(3 * u + 5.6639850080399983) + 0.25 * sin(3 * v + "
        "4.9904574083061286) + "
        "0.25 * sin(3 * w + 4.9023882866145581)\n";
    MeshOptions options;
    options.size = 0.0288713;
    const Meshed m = mesh_and_check(parse_model(text, "formula", "m.formula"), options);
    CHECK(m.defects == "");
    CHECK(m.check.min_dihedral > 17.995);
}

TEST_CASE("elements that the border of a small zone holds are mended by a wider one") {
    // Without it 16.54 degrees.
    const Meshed shaft = mesh_and_check(read_model(MORTISE_SOURCE_DIR "/bench/models/shaft.geo"), 6);
    CHECK(shaft.defects == "");
    CHECK(shaft.check.min_dihedral > 17.95);
}

}  // namespace mortise::test
