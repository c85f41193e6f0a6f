// Graded trees against definitions: balance by a slow reference, leaves by the host's classification.
#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "host/octree/octree.hpp"
#include "host/tape/reference.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

device::Device& shared_device() {
    static device::Device device("cpu", {});
    return device;
}

/// Level of the leaf at each finest cell of a tree that is complete: every node that is not split is a leaf.
std::vector<int> leaf_levels(const octree::SplitNodes& split, int finest) {
    std::vector<std::set<std::uint64_t>> sets;
    for (const auto& nodes : split) sets.emplace_back(nodes.begin(), nodes.end());
    std::vector<int> result(std::size_t{1} << (3 * finest), 0);
    for (std::uint64_t cell = 0; cell < result.size(); ++cell) {
        int level = 0;
        while (static_cast<std::size_t>(level) < sets.size() &&
               sets[static_cast<std::size_t>(level)].count(cell >> (3 * (finest - level))) != 0)
            ++level;
        result[cell] = level;
    }
    return result;
}

/// Splits a leaf that touches one more than one level finer, one after another, until there is none.
void balance_slowly(octree::SplitNodes& split, int finest) {
    const std::int64_t size = std::int64_t{1} << finest;
    for (bool again = true; again;) {
        again = false;
        const std::vector<int> level = leaf_levels(split, finest);
        for (std::uint64_t cell = 0; cell < level.size(); ++cell) {
            for (int k = 0; k < 27; ++k) {
                const std::int64_t x = std::int64_t{gather_bits(cell)} + k % 3 - 1;
                const std::int64_t y = std::int64_t{gather_bits(cell >> 1)} + k / 3 % 3 - 1;
                const std::int64_t z = std::int64_t{gather_bits(cell >> 2)} + k / 9 - 1;
                if (x < 0 || y < 0 || z < 0 || x >= size || y >= size || z >= size) continue;
                const std::uint64_t other =
                    morton_encode(static_cast<u32>(x), static_cast<u32>(y), static_cast<u32>(z));
                if (level[other] <= level[cell] + 1) continue;
                const int here = level[cell];
                auto& nodes = split[static_cast<std::size_t>(here)];
                const std::uint64_t code = cell >> (3 * (finest - here));
                if (std::find(nodes.begin(), nodes.end(), code) == nodes.end()) nodes.push_back(code);
                again = true;
            }
        }
    }
    for (auto& nodes : split) std::sort(nodes.begin(), nodes.end());
}

/// Randomly split nodes, parents before children.
octree::SplitNodes random_split(RandomSource& random, int finest, int percent) {
    octree::SplitNodes split(static_cast<std::size_t>(finest));
    split[0] = {0};
    for (std::size_t level = 1; level < split.size(); ++level) {
        for (const std::uint64_t parent : split[level - 1]) {
            for (std::uint64_t c = 0; c < 8; ++c) {
                if (random.integer(1, 100) <= percent) split[level].push_back(8 * parent + c);
            }
        }
    }
    return split;
}

std::uint64_t scramble(std::uint64_t h) {
    h *= 0x9e3779b97f4a7c15ULL;
    h ^= h >> 29;
    h *= 0xbf58476d1ce4e5b9ULL;
    return h ^ (h >> 32);
}

/// Splits that depend on the node alone, and so on neither thread nor order.
octree::Grading random_grading(std::uint64_t seed, int coarsest, int finest, int percent) {
    octree::Grading grading;
    grading.coarsest = coarsest;
    grading.finest = finest;
    grading.coarsest_in = 1;
    grading.split_undecided = [seed, percent](const std::vector<TreeNode>& nodes,
                                              const std::vector<std::uint32_t>&, int level) {
        std::vector<std::uint8_t> result;
        for (const TreeNode& node : nodes) {
            const std::uint64_t h = scramble(node.morton * 31 + static_cast<std::uint64_t>(level) + seed);
            result.push_back(h % 100 < static_cast<std::uint64_t>(percent) ? 1 : 0);
        }
        return result;
    };
    grading.split_in = [seed](std::uint64_t morton, int level, std::uint16_t) {
        return scramble(morton * 37 + static_cast<std::uint64_t>(level) + seed) % 100 < 10;
    };
    return grading;
}

/// The region of a leaf's closed cube by the host's reference; kUnknown if it cannot tell.
std::int32_t reference_region(const tape::BoundModel& model, std::uint64_t code, int level, int finest) {
    const double edge = std::ldexp(1.0, -level);
    const double unit = std::ldexp(1.0, -finest);
    tape::Cell cell{};
    for (int j = 0; j < 3; ++j) cell.centre[j] = gather_bits(code >> j) * unit + 0.5 * edge;
    cell.half = 0.5 * edge;
    return tape::classify_cell(model, model.tape, cell, nullptr);
}

}  // namespace

TEST_CASE("balance adds what a slow reference adds, and no more") {
    RandomSource random(11);
    for (int trial = 0; trial < 40; ++trial) {
        const int finest = 3 + trial % 3;
        octree::SplitNodes fast = random_split(random, finest, 8 + 6 * (trial % 4));
        octree::SplitNodes slow = fast;
        octree::balance(fast, {}, 1 + trial % 2);
        balance_slowly(slow, finest);
        CHECK(fast == slow);
    }
}

TEST_CASE("what touches a ringed node is not larger") {
    RandomSource random(12);
    for (int trial = 0; trial < 20; ++trial) {
        octree::SplitNodes split(5);
        split[0] = {0};
        octree::SplitNodes ringed(6);
        const auto cell = static_cast<std::uint64_t>(random.integer(0, (1 << 15) - 1));
        for (int level = 0; level < 5; ++level)
            split[static_cast<std::size_t>(level)] = {cell >> (3 * (5 - level))};
        ringed[5] = {cell};
        octree::balance(split, ringed, 1);
        const std::vector<int> level = leaf_levels(split, 5);
        for (int k = 0; k < 27; ++k) {
            const u32 x = gather_bits(cell) + static_cast<u32>(k % 3) - 1;
            const u32 y = gather_bits(cell >> 1) + static_cast<u32>(k / 3 % 3) - 1;
            const u32 z = gather_bits(cell >> 2) + static_cast<u32>(k / 9) - 1;
            if (x < 32 && y < 32 && z < 32) CHECK(level[morton_encode(x, y, z)] == 5);
        }
    }
}

TEST_CASE("graded trees: every place is a leaf of the right kind, levels differ by one at most") {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        CAPTURE(seed);
        const RandomModel source = make_random_model(seed);
        tape::BoundModel model;
        try {
            model = bind_model(source.model, 3);
        } catch (const Error&) {
            continue;  // empty
        }
        const octree::Grading grading = random_grading(seed, 2, 5, 25);
        const octree::Octree tree = octree::build_graded(shared_device(), model, grading, 2, nullptr);
        const octree::Octree again = octree::build_graded(shared_device(), model, grading, 1, nullptr);
        REQUIRE(tree.page_codes == again.page_codes);
        REQUIRE(tree.in_bits == again.in_bits);
        REQUIRE(tree.nio_bits == again.nio_bits);
        REQUIRE(tree.leaf_marks == again.leaf_marks);
        REQUIRE(tree.transitions == again.transitions);
        const std::set<std::uint32_t> transitions(tree.transitions.begin(), tree.transitions.end());
        const std::uint64_t cells = std::uint64_t{1} << (3 * tree.level);
        std::uint64_t meshed = 0;
        for (std::uint64_t cell = 0; cell < cells; ++cell) {
            const Leaf leaf = tree.at(cell);
            if (leaf.kind == kLeafNone) {
                // OUT: the reference must not say anything else of the finest cell.
                const std::int32_t region = reference_region(model, cell, tree.level, tree.level);
                REQUIRE((region == 0 || region == kUnknown));
                continue;
            }
            if (leaf.code != cell) continue;
            ++meshed;
            const bool promoted = leaf.kind == kLeafNio && tree.nio[leaf.index].tape_length == 0;
            if (leaf.kind == kLeafIn || promoted) {
                const std::int32_t region = reference_region(model, cell, leaf.level, tree.level);
                REQUIRE((region == octree::in_region(tree, cell) || region == kUnknown));
            }
            // Neighbours by their finest cells, all over the leaf's closed cube.
            const auto edge = std::int64_t{1} << (tree.level - leaf.level);
            bool touches_finer = false;
            for (std::int64_t x = -1; x <= edge; ++x) {
                for (std::int64_t y = -1; y <= edge; ++y) {
                    for (std::int64_t z = -1; z <= edge; ++z) {
                        const std::int64_t size = std::int64_t{1} << tree.level;
                        const std::int64_t at[3] = {gather_bits(cell) + x, gather_bits(cell >> 1) + y,
                                                    gather_bits(cell >> 2) + z};
                        if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= size || at[1] >= size ||
                            at[2] >= size)
                            continue;
                        const Leaf other = tree.at(morton_encode(
                            static_cast<u32>(at[0]), static_cast<u32>(at[1]), static_cast<u32>(at[2])));
                        if (other.kind == kLeafNone) continue;
                        REQUIRE(std::abs(other.level - leaf.level) <= 1);
                        touches_finer = touches_finer || other.level > leaf.level;
                    }
                }
            }
            if (leaf.kind == kLeafNio && touches_finer) REQUIRE(transitions.count(leaf.index) == 1);
            if (promoted) REQUIRE(transitions.count(leaf.index) == 1);
        }
        REQUIRE(meshed == tree.in_count + tree.nio.size());
    }
}

TEST_CASE("a graded tree of one level holds the leaves of the uniform tree") {
    for (std::uint64_t seed = 30; seed <= 36; ++seed) {
        CAPTURE(seed);
        const RandomModel source = make_random_model(seed);
        tape::BoundModel model;
        try {
            model = bind_model(source.model, 4);
        } catch (const Error&) {
            continue;
        }
        octree::Grading grading;
        grading.coarsest = grading.finest = grading.coarsest_in = 4;
        const octree::Octree graded = octree::build_graded(shared_device(), model, grading, 2, nullptr);
        const octree::Octree uniform = octree::build(shared_device(), model, 4, nullptr);
        if (graded.level != 4) continue;  // nothing is that deep
        CHECK(graded.transitions.empty());
        CHECK(graded.in_count == uniform.in_count);
        REQUIRE(graded.nio.size() == uniform.nio.size());
        for (std::uint64_t cell = 0; cell < (1u << 12); ++cell) {
            REQUIRE(graded.at(cell).kind == uniform.at(cell).kind);
            REQUIRE(graded.at(cell).index == uniform.at(cell).index);
        }
    }
}
