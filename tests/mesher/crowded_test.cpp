// Cells with far more surfaces than elements could show: valid meshes of ordinary size, with a warning.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

/// The union of boxes through one point, each turned otherwise: nearly a ball, whose surface is made of some
/// dozen small faces to a cell.
Model turned_boxes(int count, RandomSource& random) {
    return one_solid([&](Model& m) {
        std::vector<NodeIndex> boxes;
        for (int i = 0; i < count; ++i) {
            const Vec3 axis = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            boxes.push_back(
                m.add_transform(rotation(axis, random.uniform(0, kPi)), add_box(m, {-1, -1, -1}, {1, 1, 1})));
        }
        return unite(m, boxes);
    });
}

/// A screw's thread as libraries make it: wedges side by side around a core.
std::string thread(int turns, int wedges) {
    std::string text = "union() { cylinder(r = 4, h = " + std::to_string(turns) + ", $fn = 0);";
    for (int i = 0; i < turns * wedges; ++i) {
        text += "rotate([0, 0, " + std::to_string(360.0 * i / wedges) + "]) translate([0, 0, " +
                std::to_string(static_cast<double>(i) / wedges) +
                "]) polyhedron(points = [[3.5, -0.4, 0], [3.5, 0.4, 0.03], [3.5, 0.4, 0.9], [3.5, -0.4, "
                "0.87], [4.6, -0.5, 0.4], [4.6, 0.5, 0.43], [4.6, 0.5, 0.5], [4.6, -0.5, 0.47]], faces = "
                "[[0, 3, 7, 4], [1, 5, 6, 2], [0, 1, 2, 3], [4, 7, 6, 5], [7, 2, 6], [7, 3, 2], [0, 5, 1], "
                "[0, 4, 5]]);";
    }
    return text + "}";
}

}  // namespace

TEST_CASE("unions of many boxes through one point are coarse, but valid") {
    RandomSource random(3);
    for (int i = 0; i < 4; ++i) {
        const Model model = turned_boxes(50 + 20 * i, random);
        const Meshed meshed = mesh_and_check(model, 3 + i % 2);
        CAPTURE(i);
        CHECK(meshed.defects == "");
        // The ball that goes through the middles of all edges, and the one around the boxes.
        CHECK(meshed.check.volume > 4 * kPi / 3 * std::pow(2, 1.5) * 0.9);
        CHECK(meshed.check.volume < 4 * kPi / 3 * std::pow(3, 1.5) * 1.02);
        CHECK(meshed.mesh.element_count() < 120 * meshed.report.nio_cells);
        CHECK(meshed.report.dropped_features > 0);
        CHECK(!meshed.report.warnings.empty());
        MeshOptions strict;
        strict.level = 3;
        strict.strict = true;
        CHECK_THROWS_AS(generate(model, strict), Error);
    }
}

TEST_CASE("crowded cells are meshed alike in pieces, on threads, and in graded trees") {
    RandomSource random(8);
    const Model model = turned_boxes(60, random);
    MeshOptions options;
    options.level = 4;
    options.threads = 1;
    const Mesh whole = generate(model, options);
    options.threads = 3;
    options.pieces = 7;
    CHECK(is_same_mesh(whole, generate(model, options)));
    MeshOptions graded;
    graded.level = 3;
    graded.refine = 1;
    const Meshed meshed = mesh_and_check(model, graded);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.transition_cells + meshed.report.dropped_features > 0);
}

TEST_CASE("a thread made of polyhedra narrower than a cell is meshed") {
    const Model model = parse_model(thread(4, 40), "csg", "thread.csg");
    const Meshed meshed = mesh_and_check(model, 4);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.dropped_features > 0);
    CHECK(meshed.mesh.element_count() < 60 * meshed.report.nio_cells);
    // Between the core and the cylinder around the thread.
    CHECK(meshed.check.volume > kPi * 16 * 4);
    CHECK(meshed.check.volume < kPi * 4.7 * 4.7 * 5);
}

}  // namespace mortise::test
