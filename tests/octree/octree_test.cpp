// The device's tree against the model's definition, the host reference, and itself on other settings.
#include <doctest/doctest.h>

#include <cmath>

#include "host/octree/octree.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/octree/trees.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

TEST_CASE("random models: leaves, bitmaps and tapes, by eight lanes and by one") {
    Comparison total;
    for (std::uint64_t seed = 1; seed <= 48; ++seed) {
        const RandomModel source = make_random_model(seed);
        CAPTURE(seed);
        CAPTURE(source.style);
        const int level = 3 + static_cast<int>(seed % 3);
        tape::BoundModel model;
        try {
            model = bind_model(source.model, level);
        } catch (const Error& error) {
            CHECK(std::string(error.what()).find("empty") != std::string::npos);
            continue;
        }
        const octree::Octree wide = octree::build(device_with(8, 0), model, level, nullptr);
        const octree::Octree narrow = octree::build(device_with(1, 0), model, level, nullptr);
        for (const octree::Octree* tree : {&wide, &narrow}) {
            RandomSource random(seed);
            check_bitmaps(*tree);
            check_decided(*tree, source.model, model, random, 1);
            check_tapes(*tree, model, random, 2);
            const Comparison one = compare_with_reference(*tree, model);
            total.nio += one.nio;
            total.extra += one.extra;
        }
    }
    MESSAGE("random models: " << total.nio << " NIO leaves, " << total.extra
                              << " of them decided by the reference");
    CHECK(total.extra < total.nio / 20);
}

TEST_CASE("rounded solids: decided leaves hold their region, and few are undecided that need not be") {
    Comparison total;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        const Model source = make_random_hulls(seed).model;
        const tape::BoundModel model = bind_model(source, 5);
        for (const int lanes : {1, 8}) {
            const octree::Octree tree = octree::build(device_with(lanes, 0), model, 5, nullptr);
            RandomSource random(seed);
            check_decided(tree, source, model, random, 1);
            const Comparison one = compare_with_reference(tree, model);
            total.nio += one.nio;
            total.extra += one.extra;
        }
    }
    MESSAGE("rounded solids: " << total.nio << " NIO leaves, " << total.extra
                               << " of them decided by the reference");
    CHECK(total.nio > 10000);
    CHECK(total.extra < total.nio / 50);
}

TEST_CASE("planes and quadrics leave few leaves undecided that need not be") {
    Comparison total;
    for (const Model& source : {rotated_box(), ball(), crossing_cylinders(), random_polyhedron(3)}) {
        const tape::BoundModel model = bind_model(source, 5);
        const octree::Octree tree = octree::build(device_with(8, 0), model, 5, nullptr);
        const Comparison one = compare_with_reference(tree, model);
        total.nio += one.nio;
        total.extra += one.extra;
    }
    MESSAGE("planes and quadrics: " << total.nio << " NIO leaves, " << total.extra
                                    << " of them decided by the reference");
    CHECK(total.nio > 1000);
    CHECK(total.extra < total.nio / 100);
}

TEST_CASE("formulas: decided leaves hold their region") {
    for (const char* formula :
         {"x^2+y^2+z^2-1", "(sqrt(x^2+y^2)-0.7)^2+z^2-0.09", "sin(5*x)*cos(5*y)+sin(5*z)-0.3",
          "abs(x)+abs(y)+abs(z)-0.9", "exp(3*x)-2*y-log(z+3)", "min(x^2-0.2, max(y-0.3, z/(2+x)))",
          "min(x,y)*max(y,z)-0.1", "x/y-0.5"}) {
        CAPTURE(formula);
        const tape::BoundModel model = bind_model(formula_model(formula, 1.2), 4);
        for (const int lanes : {1, 8}) {
            RandomSource random(7);
            const octree::Octree tree = octree::build(device_with(lanes, 0), model, 4, nullptr);
            check_bitmaps(tree);
            check_tapes(tree, model, random, 4);
            const auto regions = leaf_regions(tree);
            for (std::size_t cell = 0; cell < regions.size(); ++cell) {
                if (regions[cell] == kUnknown) continue;
                for (int k = 0; k < 3; ++k) {
                    const Vec3 at = {(gather_bits(cell) + random.uniform(0, 1)) / 16,
                                     (gather_bits(cell >> 1) + random.uniform(0, 1)) / 16,
                                     (gather_bits(cell >> 2) + random.uniform(0, 1)) / 16};
                    REQUIRE(run_tape(model.tape.data(), model.tape.size(), halves_at(model, at)) ==
                            regions[cell]);
                }
            }
        }
    }
}

TEST_CASE("work-group size and repetition do not change the tree") {
    for (const std::uint64_t seed : {2, 5, 9, 14}) {
        const RandomModel source = make_random_model(seed);
        CAPTURE(source.style);
        const tape::BoundModel model = bind_model(source.model, 4);
        const auto expected = contents(octree::build(device_with(8, 1), model, 4, nullptr));
        for (const int size : {16, 64}) {
            CHECK(contents(octree::build(device_with(8, size), model, 4, nullptr)) == expected);
        }
        CHECK(contents(octree::build(device_with(1, 0), model, 4, nullptr)) == expected);
    }
}

TEST_CASE("pages of the bitmaps without leaves are not stored") {
    // 200 cells across in the box of level 8, one cell thick: two layers of pages at most, and the first.
    Model plate;
    plate.add_primitive(box({-1, -1, 0}, {1, 1, 0.01}));
    plate.regions.push_back({"plate", 0, 0, {}});
    const octree::Octree tree = octree::build(device_with(8, 0), bind_model(plate, 8), 8, nullptr);
    check_bitmaps(tree);
    CHECK(tree.page_shift == kPageShift);
    CHECK(tree.page_codes.size() <= 2 * 16 * 16 + 1);
    CHECK(tree.in_count + tree.nio.size() > 50000);
    std::size_t empty = 0;
    for (std::size_t page = 0; page < tree.page_codes.size(); ++page) {
        const std::size_t begin = page << kPageShift, end = begin + (std::size_t{1} << kPageShift);
        empty += tree.in_rank[begin] == tree.in_rank[end] && tree.nio_rank[begin] == tree.nio_rank[end];
        if (page > 0) REQUIRE(tree.page_codes[page - 1] < tree.page_codes[page]);
    }
    CHECK(empty <= 1);  // the first one is always there
}

TEST_CASE("a rod of thousands of cells has as few pages; too many leaves are refused") {
    const int level = octree::kMaxUniformLevel;
    Model rod;
    rod.add_primitive(box({-1, -0.001, -0.001}, {1, 0.001, 0.001}));
    rod.regions.push_back({"rod", 0, 0, {}});
    const octree::Octree tree = octree::build(device_with(8, 0), bind_model(rod, level), level, nullptr);
    CHECK(tree.in_count + tree.nio.size() > 4000);
    CHECK(tree.page_codes.size() <= 4 * (1u << (level - 4)) + 1);  // 16 cells long, at most four side by side
    for (const TreeNode& leaf : tree.nio) REQUIRE(tree.is_nio(leaf.morton));

    InNode node{};
    node.level = static_cast<std::uint32_t>(level - 10);  // 2^30 cells each
    node.region = 1;
    std::vector<InNode> nodes(3, node);
    CHECK_NOTHROW(octree::check_leaf_count(nodes, 1u << 20, level));
    nodes.push_back(node);
    CHECK_THROWS_WITH_AS(octree::check_leaf_count(nodes, 0, level),
                         doctest::Contains("2^32 or more cells of level"), Error);
}

TEST_CASE("every level from 1 on works") {
    for (int level = 1; level <= 6; ++level) {
        const Model source = rotated_box();
        const tape::BoundModel model = bind_model(source, level);
        RandomSource random(5);
        const octree::Octree tree = octree::build(device_with(8, 0), model, level, nullptr);
        check_bitmaps(tree);
        check_decided(tree, source, model, random, 1);
        check_tapes(tree, model, random, 1);
        CHECK(tree.nio.size() > 0);
    }
    CHECK_THROWS_AS(octree::build(device_with(8, 0), bind_model(ball(), 3), 0, nullptr), Error);
    CHECK_THROWS_AS(
        octree::build(device_with(8, 0), bind_model(ball(), 3), octree::kMaxUniformLevel + 1, nullptr),
        Error);
}
