// Leaves of random trees: look-up and neighbours against plain loops over all leaves.
#include "host/common/leaf_grid.hpp"

#include <doctest/doctest.h>

#include <set>

#include "tests/mesher/random_source.hpp"

namespace mortise {
namespace {

/// A random tree, balanced or not, in which some leaves are missing.
LeafGrid random_grid(std::uint64_t seed, int level) {
    test::RandomSource random(seed);
    LeafGrid grid;
    grid.level = level;
    std::vector<GridCube> open = {{0, level}};
    while (!open.empty()) {
        const GridCube cube = open.back();
        open.pop_back();
        if (cube.size_class == 0 || random.chance(0.4)) {
            if (!random.chance(0.8)) continue;
            grid.code.push_back(cube.code);
            grid.leaf_level.push_back(static_cast<std::uint8_t>(level - cube.size_class));
            continue;
        }
        for (std::uint64_t child = 8; child-- > 0;) {
            open.push_back({cube.code + (child << (3 * (cube.size_class - 1))), cube.size_class - 1});
        }
    }
    return grid;
}

}  // namespace

TEST_CASE("leaves of random trees are found by point, with and without a hint") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const LeafGrid grid = random_grid(seed, 4);
        if (grid.is_uniform()) continue;
        REQUIRE(std::is_sorted(grid.code.begin(), grid.code.end()));
        test::RandomSource random(seed + 100);
        for (std::uint64_t cell = 0; cell < 4096; ++cell) {
            std::size_t expected = kNoLeaf;
            for (std::size_t i = 0; i < grid.size(); ++i) {
                if (cell >= grid.code[i] && cell < cube_of(grid, i).end()) expected = i;
            }
            CHECK(find_leaf(grid, cell) == expected);
            CHECK(find_leaf(grid, cell, random.next() % grid.size()) == expected);
        }
    }
}

TEST_CASE("points have the finest cell that holds them; outside the box the nearest") {
    LeafGrid grid;
    grid.level = 18;
    CHECK(finest_cell(grid, {0.5, 1.5, 2.5}) == morton_encode(0, 1, 2));
    CHECK(finest_cell(grid, {-1, 262144, 1e9}) == morton_encode(0, 262143, 262143));
}

TEST_CASE("the leaves that touch a cube are those that share a point with it") {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        const LeafGrid grid = random_grid(seed, 4);
        test::RandomSource random(seed + 200);
        for (int k = 0; k < 60; ++k) {
            const GridCube cube = cube_of(random.next() % 4096, random.integer(0, 4));
            std::set<std::size_t> expected, found;
            for (std::size_t i = 0; i < grid.size(); ++i) {
                if (touch(cube_of(grid, i), cube)) expected.insert(i);
            }
            for_touching_leaves(grid, cube, [&](std::size_t leaf) { found.insert(leaf); });
            CHECK(found == expected);
        }
    }
}

TEST_CASE("a leaf of the deepest tree among coarse ones") {
    LeafGrid grid;
    grid.level = kMaxTreeLevel;
    for (int size_class = 0; size_class < kMaxTreeLevel; ++size_class) {
        for (std::uint64_t child = size_class == 0 ? 0 : 1; child < 8; ++child) {
            grid.code.push_back(child << (3 * size_class));
            grid.leaf_level.push_back(static_cast<std::uint8_t>(kMaxTreeLevel - size_class));
        }
    }
    CHECK(finest_class(grid) == 0);
    for (std::size_t i = 0; i < grid.size(); ++i) {
        std::set<std::size_t> expected, found;
        for (std::size_t j = 0; j < grid.size(); ++j) {
            if (touch(cube_of(grid, j), cube_of(grid, i))) expected.insert(j);
        }
        for_touching_leaves(grid, cube_of(grid, i), [&](std::size_t leaf) { found.insert(leaf); });
        CHECK(found == expected);
    }
}

}  // namespace mortise
