// MeshOptions::smooth = 0: elements are improved, though nodes stay where they are.
#include <doctest/doctest.h>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

Meshed mesh_still(const Model& model, int level) {
    MeshOptions options;
    options.level = level;
    options.smooth = 0;
    return mesh_and_check(model, options);
}

void check_good(const Meshed& m) {
    CHECK(m.defects == "");
    CHECK(m.check.min_dihedral > 15);
    CHECK(m.check.max_dihedral < 160);
}

TEST_CASE("without smoothing, vertices of the grid snap onto faces that cross cells' diagonals") {
    const Model bar = parse_model(
        "multmatrix([[0.70710678118654752, -0.70710678118654752, 0, 0], "
        "[0.70710678118654752, 0.70710678118654752, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) "
        "cube([3, 1.5, 1], center = true);",
        "csg", "bar.csg");
    check_good(mesh_still(bar, 4));
}

TEST_CASE("without smoothing, creases in the planes between blocks have good elements") {
    // An edge of the model lies in the middle plane of the root box.
    check_good(mesh_still(read_model(std::string(MORTISE_SOURCE_DIR) + "/assets/models/block.csg"), 5));
}

}  // namespace
}  // namespace mortise::test
