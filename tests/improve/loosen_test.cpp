// The last resort for slivers: where corners of several solids lie within a hundredth of a cell, nodes may
// leave the model by a small part of one.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr int kLooseLevel = 5;
constexpr double kMerge = 0.05;
constexpr double kMostLoose = 3 * kMerge;  ///< cells

/// A box of [0, w] that a rotation and a shift move.
struct Block {
    Affine turn;
    Vec3 shift;
    Vec3 width;

    /// Distance from a point to the box's surface.
    double distance(const Vec3& at) const {
        // A rotation's inverse is its transpose.
        double local[3] = {};
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) local[j] += turn[4 * k + j] * (at[k] - shift[k]);
        }
        double outside = 0;
        double inside = -1e9;
        for (std::size_t j = 0; j < 3; ++j) {
            const double beyond = std::max(-local[j], local[j] - width[j]);
            outside += beyond > 0 ? beyond * beyond : 0;
            inside = std::max(inside, beyond);
        }
        return outside > 0 ? std::sqrt(outside) : -inside;
    }
};

/// Boxes in random orientation, each with a corner within 0.02 of the origin, taken out of a larger one.
struct Clump {
    Model model;
    std::vector<Block> blocks;
};

Clump make_clump(std::uint64_t seed) {
    RandomSource random(seed);
    Clump clump;
    const auto vector = [&](double low, double high) {
        return Vec3{random.uniform(low, high), random.uniform(low, high), random.uniform(low, high)};
    };
    clump.blocks.push_back({rotation({0, 0, 1}, 0), {-9, -9, -9}, {18, 18, 18}});
    for (int i = 0; i < 3; ++i)
        clump.blocks.push_back(
            {rotation(vector(-1, 1), random.uniform(0, 3)), vector(-0.02, 0.02), vector(5, 9)});
    clump.model = one_solid([&](Model& m) {
        std::vector<NodeIndex> parts;
        for (const Block& b : clump.blocks)
            parts.push_back(
                m.add_transform(compose(translation(b.shift), b.turn), add_box(m, {0, 0, 0}, b.width)));
        return subtract(m, parts);
    });
    return clump;
}

/// Boundary nodes off the surfaces of all boxes.
struct Off {
    std::uint64_t count = 0;
    double farthest = 0;
};

Off nodes_off(const Meshed& m, const Clump& clump) {
    Off off;
    std::vector<std::uint8_t> seen(m.mesh.node_count());
    for (const NodeId node : m.mesh.facets.nodes) {
        if (seen[node] != 0) continue;
        seen[node] = 1;
        const double* p = m.mesh.points.data() + 3 * std::size_t{node};
        double nearest = 1e9;
        for (const Block& b : clump.blocks) nearest = std::min(nearest, b.distance({p[0], p[1], p[2]}));
        off.farthest = std::max(off.farthest, nearest);
        off.count += nearest > 2e-4 * m.report.cell_size ? 1 : 0;
    }
    return off;
}

}  // namespace

TEST_CASE("nodes of slivers leave the model by a small part of a cell") {
    int poor = 0;
    int better = 0;
    for (std::uint64_t seed = 0; seed < 9; ++seed) {
        CAPTURE(seed);
        const Clump clump = make_clump(seed);
        MeshOptions options;
        options.level = kLooseLevel;
        options.threads = 1;
        options.merge_distance = 0;
        const Meshed kept = mesh_and_check(clump.model, options);
        CHECK(kept.defects == "");
        CHECK(kept.report.loosened_nodes == 0);
        options.merge_distance = kMerge;
        const Meshed loose = mesh_and_check(clump.model, options);
        CHECK(loose.defects == "");
        CHECK(worst(loose) > 0.9f * worst(kept));
        poor += worst(kept) < 0.1f ? 1 : 0;
        better += worst(kept) < 0.1f && worst(loose) > 1.5f * worst(kept) ? 1 : 0;
        CHECK(loose.check.volume == doctest::Approx(kept.check.volume).epsilon(2e-4));
        // Where features are too fine for the cells, some nodes are off the model anyway.
        const Off before = nodes_off(kept, clump);
        const Off after = nodes_off(loose, clump);
        // Along its planes, beyond the box, a node is off the box only.
        CHECK(after.count <= before.count + 2 * loose.report.loosened_nodes);
        CHECK(after.farthest <= before.farthest + kMostLoose * loose.report.cell_size);
        if (seed % 3 != 0) continue;
        options.threads = 3;
        options.pieces = 3;
        CHECK(is_same_mesh(loose.mesh, generate(clump.model, options)));
    }
    CHECK(poor >= 5);
    CHECK(3 * better >= poor);  // the others are as poor as the model is sharp
}

TEST_CASE("meshes of tetrahedra keep what loose nodes have mended") {
    int loose = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        CAPTURE(seed);
        MeshOptions options;
        options.level = kLooseLevel;
        const Clump clump = make_clump(seed);
        const Meshed hybrid = mesh_and_check(clump.model, options);
        options.tetrahedra = true;
        const Meshed split = mesh_and_check(clump.model, options);
        CHECK(split.defects == "");
        loose += hybrid.report.loosened_nodes > 0 ? 1 : 0;
        CHECK(worst(split) > 0.99f * worst(hybrid));
    }
    CHECK(loose >= 3);
}

TEST_CASE("a thin wall stays as thin as it is") {
    const Affine turn = rotation({1, 2, 3}, 0.7);
    const Model model = one_solid([&](Model& m) {
        return m.add_transform(
            turn, unite(m, {add_box(m, {0, 0, 0}, {20, 20, 6}), add_box(m, {4, 5, 3}, {17, 5.02, 12})}));
    });
    const Meshed m = mesh_and_check(model, kLooseLevel);
    CHECK(m.defects == "");
    CHECK(worst(m) < 0.1f);
    CHECK(m.report.loosened_nodes == 0);
    CHECK(m.check.volume == doctest::Approx(20 * 20 * 6 + 13 * 0.02 * 6).epsilon(1e-8));
}

TEST_CASE("a sharp edge stays sharp") {
    // The angle between two boxes that are turned against each other, 8 degrees.
    const Affine turn = rotation({1, 2, 3}, 0.7);
    const Model model = one_solid([&](Model& m) {
        const NodeIndex cut =
            m.add_transform(rotation({0, 1, 0}, -0.1396), add_box(m, {-30, -30, 0}, {30, 30, 30}));
        return m.add_transform(turn, subtract(m, {add_box(m, {0, 0, 0}, {20, 15, 9}), cut}));
    });
    const Meshed m = mesh_and_check(model, kLooseLevel);
    CHECK(m.defects == "");
    CHECK(m.report.loosened_nodes == 0);
    for (const double y : {0.0, 15.0}) CHECK(nearest_node(m.mesh, apply(turn, {0, y, 0})) < 1e-9);
}

}  // namespace mortise::test
