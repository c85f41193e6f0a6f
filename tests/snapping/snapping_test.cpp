// Vertices of the grid beside creases: which of them snap, and what their cells are like afterwards.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/octree/odd_corner.hpp"
#include "host/snapping/snapping.hpp"
#include "host/snio/classify.hpp"
#include "host/tape/compile.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

Affine random_turn(RandomSource& random) {
    const Vec3 axis = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.2, 1)};
    return rotation(axis, random.uniform(0, 3));
}

/// Two boxes, turned against each other, one taken out of the other.
Model notched(std::uint64_t seed, double* volume) {
    RandomSource random(seed);
    const Vec3 size = {random.uniform(1.5, 2.5), random.uniform(1.5, 2.5), random.uniform(1.5, 2.5)};
    const Vec3 notch = {random.uniform(0.4, 0.9), random.uniform(0.4, 0.9), random.uniform(0.4, 0.9)};
    *volume = size[0] * size[1] * size[2] - notch[0] * notch[1] * notch[2];
    return transformed(one_solid([&](Model& m) {
                           return subtract(m, {add_box(m, {0, 0, 0}, size), add_box(m, {-1, -1, -1}, notch)});
                       }),
                       random_turn(random));
}

std::uint64_t poor(const Mesh& mesh, const std::vector<float>& jacobians) {
    CHECK(jacobians.size() == mesh.element_count());
    return static_cast<std::uint64_t>(
        std::count_if(jacobians.begin(), jacobians.end(), [](float x) { return x < 0.2f; }));
}

struct Snapped {
    tape::BoundModel model;
    octree::DeviceTree on_device;
    octree::Octree tree;
    std::vector<octree::SnappedVertex> vertices;
};

Snapped snap(const Model& source, int level) {
    Snapped result;
    device::Device device("");
    result.model = tape::bind(tape::compile(source), {-4.03, -3.97, -4.01}, 8);
    result.tree = octree::build(device, result.model, level, &result.on_device);
    snio::Classifier classifier(device, result.tree, result.on_device, true, true, {});
    std::vector<std::uint32_t> complex;
    for (std::uint32_t i = 0; i < result.tree.nio.size(); ++i) {
        if ((classifier.candidates()[i].flags & kCandidateSimple) == 0) complex.push_back(i);
    }
    result.vertices = snapping::find_snapped(result.model, result.tree, complex, {}, 1);
    return result;
}

}  // namespace

TEST_CASE("targets lie on all surfaces of their vertex, near it, and on one side of all others as before") {
    std::uint64_t by_count[4] = {};
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        double volume = 0;
        const Snapped s = snap(notched(seed, &volume), 5);
        const double cell = s.tree.finest_edge();
        const auto value = [&](std::size_t surface, const Vec3& x) {  // of planes: distance times slope
            const auto& map = s.model.surfaces[surface].map;
            const double slope = std::sqrt(map[0] * map[0] + map[1] * map[1] + map[2] * map[2]);
            return (map[0] * x[0] + map[1] * x[1] + map[2] * x[2] + map[3]) / slope;
        };
        for (const octree::SnappedVertex& vertex : s.vertices) {
            Vec3 from{};
            for (std::size_t j = 0; j < 3; ++j) from[j] = gather_bits(vertex.code >> j) * cell;
            const Vec3 to = vertex.target(cell);
            const double way = std::hypot(to[0] - from[0], std::hypot(to[1] - from[1], to[2] - from[2]));
            CHECK(way > 0);
            CHECK(way < 0.46 * cell);
            ++by_count[vertex.surface_count];
            for (std::size_t k = 0; k < vertex.surface_count; ++k)
                CHECK(std::fabs(value(vertex.surface[k], to)) < 1e-6 * cell);
        }
    }
    CHECK(by_count[1] > 100);
    CHECK(by_count[2] > 100);
    CHECK(by_count[3] > 10);
}

TEST_CASE("faces that are split for three corners on a surface: both leaves tell the same corner") {
    std::uint64_t split = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        CAPTURE(seed);
        double volume = 0;
        Snapped s = snap(notched(seed, &volume), 5);
        s.tree.snapped = s.vertices;
        const Tree tree = s.tree.view();
        for (const TreeNode& leaf : s.tree.nio) {
            for (int f = 0; f < 6; ++f) {
                const std::size_t odd = octree::odd_corner(s.tree, s.model, leaf.morton, f);
                i32 direction[3] = {0, 0, 0};
                direction[f / 2] = (f & 1) != 0 ? 1 : -1;
                const Leaf beyond = leaf_beside(&tree, leaf.morton, s.tree.level, direction);
                if (beyond.kind != kLeafNone)
                    CHECK(octree::odd_corner(s.tree, s.model, beyond.code, f ^ 1) == odd);
                if (odd == 4) continue;
                ++split;
                // The surface of all others that snap, and not of this one.
                std::vector<std::uint32_t> shared;
                bool is_first = true;
                for (std::size_t i = 0; i < 4; ++i) {
                    const octree::SnappedVertex* vertex =
                        s.tree.snapped_at(s.tree.vertex_of(leaf.morton, s.tree.level, kFaceCorners[f][i]));
                    if (i == odd || vertex == nullptr) continue;
                    const auto end = vertex->surface.begin() + vertex->surface_count;
                    if (is_first) shared.assign(vertex->surface.begin(), end);
                    is_first = false;
                    shared.erase(std::remove_if(shared.begin(), shared.end(),
                                                [&](std::uint32_t own) { return !vertex->is_on(own); }),
                                 shared.end());
                }
                CHECK_FALSE(shared.empty());
            }
        }
    }
    CHECK(split > 100);
}

TEST_CASE("turned boxes with a notch: the same volume without improvement, far fewer poor elements") {
    std::uint64_t with = 0, without = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        CAPTURE(seed);
        double volume = 0;
        const Model model = notched(seed, &volume);
        MeshOptions options;
        options.level = 4 + static_cast<int>(seed % 2);
        options.improve = false;
        const Meshed snapped = mesh_and_check(model, options);
        CHECK(snapped.defects == "");
        CHECK(snapped.check.nonmanifold_edges == 0);
        CHECK(snapped.check.euler_characteristic == 2);
        CHECK(snapped.check.volume == doctest::Approx(volume).epsilon(1e-7));
        CHECK(snapped.report.dropped_features == 0);
        with += poor(snapped.mesh, snapped.report.scaled_jacobians);
        options.pieces = 3;
        CHECK(is_same_mesh(snapped.mesh, mesh_and_check(model, options).mesh));
        options.pieces = 1;
        options.snap = false;
        const Meshed unmoved = mesh_and_check(model, options);
        without += poor(unmoved.mesh, unmoved.report.scaled_jacobians);
    }
    MESSAGE("elements with a scaled Jacobian below 0.2: ", with, " of ", without, " without snapping");
    CHECK(7 * with < without);
}

TEST_CASE("a cell that does not bear all its vertices takes back one, not all") {
    std::uint64_t count = 0, elements = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        const double radius = random.uniform(0.15, 0.4);
        const Model joint = transformed(
            one_solid([&](Model& m) {
                const std::uint32_t strut = add_cylinder(m, radius, -1.5, 1.5);
                return unite(m, {strut, m.add_transform({0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0}, strut),
                                 m.add_transform({0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0}, strut)});
            }),
            random_turn(random));
        MeshOptions options;
        options.level = 5;
        options.improve = false;
        const Meshed meshed = mesh_and_check(joint, options);
        CHECK(meshed.defects == "");
        CHECK(meshed.check.euler_characteristic == 2);
        count += poor(meshed.mesh, meshed.report.scaled_jacobians);
        elements += meshed.mesh.element_count();
    }
    MESSAGE("elements with a scaled Jacobian below 0.2: ", count, " of ", elements);
    CHECK(6 * count < elements);  // more than that when all were taken back
}

TEST_CASE("curved parts that few vertices know of are left alone") {
    for (const double radius : {0.3, 0.5, 0.7}) {
        CAPTURE(radius);
        const double cell = 8.0 / 32;
        const Snapped s = snap(one_solid([&](Model& m) {
                                   return unite(m, {add_box(m, {-2, -2, -2}, {2, 2, -1}),
                                                    add_cylinder(m, radius * cell, -1.5, 1.5)});
                               }),
                               5);
        for (const octree::SnappedVertex& vertex : s.vertices) {
            for (std::size_t k = 0; k < vertex.surface_count; ++k)
                CHECK(s.model.surfaces[vertex.surface[k]].kind == kSurfacePlane);
        }
    }
}

}  // namespace mortise::test
