// Models of thousands of primitives: their tapes are pruned as well as short ones.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/mesher/solids.hpp"
#include "tests/octree/trees.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

/// `count` balls on a jittered grid that overlap here and there.
std::vector<NodeIndex> scattered_balls(Model& model, int count, std::uint64_t seed) {
    RandomSource random(seed);
    std::vector<NodeIndex> parts;
    const int row = static_cast<int>(std::ceil(std::cbrt(count)));
    for (int i = 0; i < count; ++i) {
        const Vec3 at = {i % row + random.uniform(-0.2, 0.2), i / row % row + random.uniform(-0.2, 0.2),
                         i / row / row + random.uniform(-0.2, 0.2)};
        parts.push_back(add_ball(model, at, random.uniform(0.3, 0.6)));
    }
    return parts;
}

Model many_balls(int count, std::uint64_t seed) {
    Model model;
    add_region(model, unite(model, scattered_balls(model, count, seed)), "balls");
    return model;
}

/// A third of them is cut out of turned boxes around the others: tapes of planes, unions and differences.
Model many_kinds(int count, std::uint64_t seed) {
    RandomSource random(seed);
    Model model;
    std::vector<NodeIndex> solid;
    std::vector<NodeIndex> removed;
    const int row = static_cast<int>(std::ceil(std::cbrt(count)));
    for (int i = 0; i < count; ++i) {
        const double at[3] = {i % row + random.uniform(-0.2, 0.2), i / row % row + random.uniform(-0.2, 0.2),
                              i / row / row + random.uniform(-0.2, 0.2)};
        const Affine turn = rotation({random.uniform(0.1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                                     random.uniform(0, 3));
        const Affine map = compose(translation({at[0], at[1], at[2]}), turn);
        const double r = random.uniform(0.2, 0.45);
        const NodeIndex node = i % 3 == 0   ? add_box(model, {-r, -r, -r}, {r, r, r})
                               : i % 3 == 1 ? add_torus(model, r, 0.4 * r)
                                            : add_cylinder(model, 0.7 * r, -r, r);
        (i % 3 == 2 ? removed : solid).push_back(model.add_transform(map, node));
    }
    std::vector<NodeIndex> operands = {unite(model, solid)};
    operands.insert(operands.end(), removed.begin(), removed.end());
    add_region(model, subtract(model, operands), "solid");
    return model;
}

double bytes_per_leaf(const octree::Octree& tree) {
    return sizeof(TreeNode) + static_cast<double>(tree.tapes.size() * sizeof(std::uint32_t)) /
                                  static_cast<double>(tree.nio.size());
}

}  // namespace

TEST_CASE("long tapes: beyond the reduction, beyond the first arena") {
    struct Size {
        int balls;
        int level;
    };
    for (const Size& size : {Size{60, 4}, Size{1200, 3}, Size{6000, 4}}) {
        const Model source = many_balls(size.balls, 5);
        const tape::BoundModel model = bind_model(source, size.level);
        CAPTURE(size.balls);
        REQUIRE(model.tape.size() == static_cast<std::size_t>(2 * size.balls));
        for (const int lanes : {8, 1}) {
            RandomSource random(3);
            const octree::Octree tree = octree::build(device_with(lanes, 0), model, size.level, nullptr);
            check_bitmaps(tree);
            const Comparison one = compare_with_reference(tree, model);
            CHECK(one.nio > 0);
            CHECK(one.extra <= one.nio / 20);
            if (size.balls <= 1200) {
                check_decided(tree, source, model, random, 1);
                check_tapes(tree, model, random, 1);
            }
        }
    }
}

TEST_CASE("3,000 primitives: the reference's tree, short tapes, few bytes, whatever the launch") {
    const Model source = many_kinds(3000, 2);
    const tape::BoundModel model = bind_model(source, 6);
    REQUIRE(model.tape.size() > 10000);
    const octree::Octree tree = octree::build(device_with(8, 0), model, 6, nullptr);
    check_bitmaps(tree);
    const Comparison found = compare_with_reference(tree, model);
    MESSAGE("3,000 primitives: " << found.nio << " NIO leaves, " << found.extra
                                 << " of them decided by the reference, " << bytes_per_leaf(tree)
                                 << " bytes for each");
    CHECK(found.nio > 30000);
    CHECK(found.extra <= found.nio / 20);
    CHECK(bytes_per_leaf(tree) < 100);  // 5,000 with tapes that are not pruned beyond 2,048 words
    std::uint32_t longest = 0;
    for (const TreeNode& leaf : tree.nio) longest = std::max(longest, leaf.tape_length);
    CHECK(longest < 100);
    RandomSource random(4);
    std::size_t checked = 0;
    for (std::size_t i = 0; i < tree.nio.size(); i += 97, ++checked) {  // each costs the whole tape
        const TreeNode& leaf = tree.nio[i];
        const double size = tree.finest_edge();
        const Vec3 at = {(gather_bits(leaf.morton) + random.uniform(0, 1)) * size,
                         (gather_bits(leaf.morton >> 1) + random.uniform(0, 1)) * size,
                         (gather_bits(leaf.morton >> 2) + random.uniform(0, 1)) * size};
        const auto inside = halves_at(model, at);
        REQUIRE(run_tape(tree.tapes.data() + leaf.tape_offset, leaf.tape_length, inside) ==
                run_tape(model.tape.data(), model.tape.size(), inside));
    }
    CHECK(checked > 300);
    const auto expected = contents(tree);
    for (const auto& [lanes, size] : {std::make_pair(8, 1), std::make_pair(8, 64), std::make_pair(1, 0)}) {
        CAPTURE(lanes);
        CHECK(contents(octree::build(device_with(lanes, size), model, 6, nullptr)) == expected);
    }
}

TEST_CASE("long tapes of several regions: selects whose rest is known become constants") {
    Model source;
    for (int region = 0; region < 5; ++region) {
        auto parts = scattered_balls(source, 300, static_cast<std::uint64_t>(region + 1));
        add_region(source, unite(source, parts), "region" + std::to_string(region));
    }
    for (const int level : {2, 5}) {
        const tape::BoundModel model = bind_model(source, level);
        CAPTURE(level);
        RandomSource random(6);
        const octree::Octree wide = octree::build(device_with(8, 0), model, level, nullptr);
        const octree::Octree narrow = octree::build(device_with(1, 0), model, level, nullptr);
        check_bitmaps(wide);
        check_tapes(wide, model, random, 1);
        const Comparison one = compare_with_reference(wide, model);
        CHECK(one.nio > 30);
        CHECK(one.extra <= one.nio / 20);
        CHECK(contents(narrow) == contents(wide));
        std::size_t constants = 0;
        for (const TreeNode& leaf : wide.nio) {
            for (std::uint32_t i = 0; i < leaf.tape_length; ++i) {
                const std::uint32_t word = wide.tapes[leaf.tape_offset + i];
                constants += tape_operation(word) == kTapeSelectConst && tape_otherwise(word) > 0 ? 1 : 0;
            }
        }
        if (level == 5) CHECK(constants > 100);
    }
}
