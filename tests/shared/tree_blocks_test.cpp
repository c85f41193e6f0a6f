// Blocks of 32 cells against their cells one by one.
#include <doctest/doctest.h>

#include <vector>

#include "kernels/shared/tree_blocks.h"
#include "tests/mesher/random_source.hpp"

using mortise::test::RandomSource;

namespace {

/// A uniform tree most of whose cells are IN, but for pages without leaves.
struct MostlyIn {
    std::vector<u32> in, nio, in_rank, nio_rank, used, directory = {0};
    std::vector<u64> page_codes;
    i32 level;
    u32 size;

    MostlyIn(RandomSource& random, i32 at_level) : level(at_level), size(1u << at_level) {
        const std::size_t cells = std::size_t{size} * size * size;
        for (std::size_t word = 0; word < (cells + 31) / 32; ++word) {  // each a page
            directory.push_back(directory.back());
            if (word > 0 && random.chance(0.05)) continue;
            ++directory.back();
            page_codes.push_back(word);
            in_rank.push_back(count_of(in, in_rank));
            nio_rank.push_back(count_of(nio, nio_rank));
            in.push_back(0);
            nio.push_back(0);
            for (std::size_t bit = 0; bit < 32 && 32 * word + bit < cells; ++bit) {
                const int kind = random.chance(0.95) ? 0 : random.integer(0, 2);
                if (kind == 0) in.back() |= 1u << bit;
                if (kind != 1) continue;
                nio.back() |= 1u << bit;
                used.push_back(static_cast<u32>(random.next()) & 0x1fffffu);
            }
        }
        directory.push_back(directory.back());
        in_rank.push_back(count_of(in, in_rank));
        nio_rank.push_back(count_of(nio, nio_rank));
    }
    static u32 count_of(const std::vector<u32>& bits, const std::vector<u32>& ranks) {
        return bits.empty() ? 0 : ranks.back() + count_bits(bits.back());
    }
    Tree tree() const {
        return make_tree(in.data(), nio.data(), in_rank.data(), nio_rank.data(), page_codes.data(),
                         directory.data(), nullptr, {level, 0, static_cast<u32>(in.size()), 5, 0});
    }
    bool is_in(i64 x, i64 y, i64 z) const {
        if (x < 0 || y < 0 || z < 0) return false;
        const Tree view = tree();
        return leaf_at(&view, morton_encode(static_cast<u32>(x), static_cast<u32>(y), static_cast<u32>(z)))
                   .kind == kLeafIn;
    }
};

}  // namespace

TEST_CASE("inner cells of a block are those between IN cells, and own their last corner only") {
    RandomSource random(11);
    std::size_t inner_count = 0;
    for (int trial = 0; trial < 12; ++trial) {
        const MostlyIn leaves(random, 1 + trial % 4);
        const Tree tree = leaves.tree();
        for (u32 word = 0; word < leaves.in.size(); ++word) {
            TreeBlock block;
            make_block(&tree, word, &block);
            const u32 inner = inner_cells(&block);
            for (u32 bit = 0; bit < 32; ++bit) {
                const u64 code = word_code(&tree, word) | bit;
                const u32 x = gather_bits(code), y = gather_bits(code >> 1), z = gather_bits(code >> 2);
                if (x >= leaves.size || y >= leaves.size || z >= leaves.size) {
                    REQUIRE(((inner >> bit) & 1) == 0);
                    continue;
                }
                REQUIRE(place_in_block(x & 3, y & 3, z & 1) == bit);
                bool expected = true;
                for (u32 c = 0; c < 8; ++c) {
                    expected = expected &&
                               leaves.is_in(i64{x} - (c & 1), i64{y} - ((c >> 1) & 1), i64{z} - (c >> 2));
                }
                REQUIRE(((inner >> bit) & 1) == (expected ? 1u : 0u));
                for (u32 c = 0; c < 8 && expected; ++c) {
                    u32 owned_bit = 0;
                    const u64 owner = vertex_owner(&tree, leaves.used.data(), x + (c & 1), y + ((c >> 1) & 1),
                                                   z + (c >> 2), &owned_bit);
                    REQUIRE(owned_bit == 7);
                    REQUIRE((owner == code) == (c == 7));
                    REQUIRE(
                        leaves.is_in(gather_bits(owner), gather_bits(owner >> 1), gather_bits(owner >> 2)));
                    ++inner_count;
                }
            }
        }
    }
    CHECK(inner_count > 1000);
}
