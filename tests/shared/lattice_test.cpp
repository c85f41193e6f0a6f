// Morton codes and the tables of corners, edges and faces, against their definitions in lattice.h; owners of
// vertices and edges by brute force.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "kernels/shared/lattice.h"
#include "kernels/shared/leaves_before.h"
#include "kernels/shared/tree.h"
#include "tests/mesher/random_source.hpp"

using mortise::test::RandomSource;

namespace {

/// Bit by bit, from the definition.
u64 interleave(u32 x, u32 y, u32 z) {
    u64 code = 0;
    for (int bit = 0; bit < 21; ++bit) {
        code |= static_cast<u64>((x >> bit) & 1) << (3 * bit);
        code |= static_cast<u64>((y >> bit) & 1) << (3 * bit + 1);
        code |= static_cast<u64>((z >> bit) & 1) << (3 * bit + 2);
    }
    return code;
}

}  // namespace

TEST_CASE("Morton codes interleave bits and come apart again") {
    RandomSource random(1);
    for (int i = 0; i < 20000; ++i) {
        const int bits = random.integer(1, 21);
        const u32 mask = (1u << bits) - 1;
        const u32 x = static_cast<u32>(random.next()) & mask;
        const u32 y = static_cast<u32>(random.next()) & mask;
        const u32 z = static_cast<u32>(random.next()) & mask;
        const u64 code = morton_encode(x, y, z);
        REQUIRE(code == interleave(x, y, z));
        REQUIRE(gather_bits(code) == x);
        REQUIRE(gather_bits(code >> 1) == y);
        REQUIRE(gather_bits(code >> 2) == z);
    }
    CHECK(morton_encode(0x1fffff, 0x1fffff, 0x1fffff) == 0x7fffffffffffffffULL);
}

TEST_CASE("Morton order of cells is the order of their parents, then of the children") {
    RandomSource random(2);
    for (int i = 0; i < 20000; ++i) {
        u32 a[3];
        u32 b[3];
        for (int j = 0; j < 3; ++j) {
            a[j] = static_cast<u32>(random.integer(0, 1 << 18));
            b[j] = random.chance(0.5) ? a[j] : static_cast<u32>(random.integer(0, 1 << 18));
        }
        const u64 code_a = morton_encode(a[0], a[1], a[2]);
        const u64 code_b = morton_encode(b[0], b[1], b[2]);
        const u64 parent_a = morton_encode(a[0] / 2, a[1] / 2, a[2] / 2);
        const u64 parent_b = morton_encode(b[0] / 2, b[1] / 2, b[2] / 2);
        REQUIRE((code_a >> 3) == parent_a);
        const u32 child = (a[0] & 1) + 2 * (a[1] & 1) + 4 * (a[2] & 1);
        REQUIRE((code_a & 7) == child);
        if (parent_a < parent_b) REQUIRE(code_a < code_b);
    }
}

TEST_CASE("edges join corners that differ along their axis") {
    std::set<std::pair<int, int>> seen;
    for (int e = 0; e < 12; ++e) {
        const int axis = e / 4;
        const int first = axis == 0 ? 1 : 0;
        const int second = axis == 2 ? 1 : 2;
        const int low = kEdgeCorners[e][0];
        const int high = kEdgeCorners[e][1];
        CHECK(high - low == (1 << axis));
        CHECK(((low >> axis) & 1) == 0);
        CHECK(((low >> first) & 1) == (e & 1));
        CHECK(((low >> second) & 1) == ((e >> 1) & 1));
        seen.insert({low, high});
    }
    CHECK(seen.size() == 12);
}

TEST_CASE("faces list their corners and edges in the frame of the two other axes") {
    for (int f = 0; f < 6; ++f) {
        const int axis = f / 2;
        const int u = axis == 0 ? 1 : 0;
        const int v = axis == 2 ? 1 : 2;
        const int frame[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int i = 0; i < 4; ++i) {
            const int corner = ((f & 1) << axis) | (frame[i][0] << u) | (frame[i][1] << v);
            CHECK(kFaceCorners[f][i] == corner);
            const int next = kFaceCorners[f][(i + 1) % 4];
            const int edge = kFaceEdges[f][i];
            CHECK(std::min(corner, next) == kEdgeCorners[edge][0]);
            CHECK(std::max(corner, next) == kEdgeCorners[edge][1]);
        }
    }
}

namespace {

/// Leaves of a random tree of two levels, and what they use.
struct RandomLeaves {
    static constexpr i32 kLevel = 3;
    static constexpr u32 kSize = 1u << kLevel;

    struct Entry {
        u64 code;
        i32 level;
        int kind;  ///< kLeafNone …
        u32 mask;
    };
    std::vector<Entry> entries;  ///< in Morton order
    std::vector<u32> in, nio, in_rank, nio_rank, used;
    std::vector<u64> page_codes;
    std::vector<u32> directory;
    std::vector<u8> marks;
    bool graded;
    TreeShape shape{};

    /// Of one level if `coarse` is 0, else with that share of larger leaves in percent; `sparse`: stored as a
    /// graded tree.
    RandomLeaves(RandomSource& random, int coarse, bool sparse) : graded(sparse) {
        constexpr u64 kCells = kSize * kSize * kSize;
        bool is_empty = false;  // so are some pages of a uniform tree
        for (u64 parent = 0; parent < kCells / 8; ++parent) {
            const bool is_coarse = random.integer(1, 100) <= coarse;
            if (parent % 16 == 0) is_empty = random.chance(0.3);
            for (u64 child = 0; child < (is_coarse ? 1 : 8); ++child) {
                const int kind = is_empty ? kLeafNone : random.integer(0, 2);
                const u32 mask = kind == kLeafIn    ? 0xffu
                                 : kind == kLeafNio ? static_cast<u32>(random.next()) & 0xfffffu
                                                    : 0u;
                entries.push_back({8 * parent + child, is_coarse ? kLevel - 1 : kLevel, kind, mask});
            }
        }
        shape.level = kLevel;
        shape.graded = sparse ? 1 : 0;
        shape.page_shift = sparse ? 0 : 2;
        shape.directory_shift = sparse ? 3 * (kLevel - 1) : 7;
        for (const Entry& entry : entries) {
            if (entry.kind == kLeafNone) continue;
            const u64 page = entry.code / 32 >> shape.page_shift;
            if (page_codes.empty() || page_codes.back() != page) {
                page_codes.push_back(page);
                in.resize(page_codes.size() << shape.page_shift, 0);
                nio.resize(in.size(), 0);
            }
            const std::size_t word = ((page_codes.size() - 1) << shape.page_shift) +
                                     entry.code / 32 % (u64{1} << shape.page_shift);
            if (sparse) marks.push_back(static_cast<u8>(mark(entry)));
            (entry.kind == kLeafIn ? in : nio)[word] |= 1u << (entry.code % 32);
            if (entry.kind == kLeafNio) used.push_back(entry.mask);
        }
        shape.words = static_cast<u32>(in.size());
        for (u64 cell = 0; cell < (kCells >> shape.directory_shift) + 2; ++cell) {
            u32 before = 0;
            for (const u64 page : page_codes)
                before += page << (shape.page_shift + 5) < cell << shape.directory_shift ? 1 : 0;
            directory.push_back(before);
        }
        in_rank = ranks(in);
        nio_rank = ranks(nio);
    }

    /// Level of a leaf, and whether a finer one touches it.
    u32 mark(const Entry& leaf) const {
        const u32 edge = 1u << (kLevel - leaf.level);
        u32 result = static_cast<u32>(leaf.level);
        for (const Entry& other : entries) {
            if (other.kind == kLeafNone || other.level <= leaf.level) continue;
            bool touches = true;
            for (int j = 0; j < 3; ++j) {
                const u32 d = gather_bits(other.code >> j) + 1 - gather_bits(leaf.code >> j);
                touches = touches && d <= edge + 1;  // wraps below the leaf
            }
            if (touches) result |= kFinerAround;
        }
        return result;
    }

    static std::vector<u32> ranks(const std::vector<u32>& bits) {
        std::vector<u32> result = {0};
        for (const u32 word : bits) result.push_back(result.back() + count_bits(word));
        return result;
    }

    Tree tree() const {
        return make_tree(in.data(), nio.data(), in_rank.data(), nio_rank.data(), page_codes.data(),
                         directory.data(), marks.data(), shape);
    }

    /// The first of the finest leaves that use the vertex, or the root on the edge from it along `axis` of
    /// leaves of `edge_level`.
    const Entry* owner(const std::array<u32, 3>& vertex, int axis, i32 edge_level, u32& owner_bit) const {
        const Entry* best = nullptr;
        for (const Entry& entry : entries) {
            const u32 edge = 1u << (kLevel - entry.level);
            u32 bit = 0;
            bool touches = true;
            for (int j = 0; j < 3; ++j) {
                const u32 d = vertex[static_cast<std::size_t>(j)] - gather_bits(entry.code >> j);
                touches = touches && (d == 0 || (d == edge && j != axis));
                if (d == edge) bit |= 1u << j;
            }
            if (axis >= 0) {
                touches = touches && entry.level == edge_level;
                for (u32 e = 0; e < 12 && touches; ++e) {
                    if (kEdgeCorners[e][0] != bit || static_cast<int>(e / 4) != axis) continue;
                    bit = 8 + e;
                    break;
                }
            }
            if (!touches || ((entry.mask >> bit) & 1) == 0) continue;
            if (best != nullptr && best->level >= entry.level) continue;
            best = &entry;
            owner_bit = bit;
        }
        return best;
    }
};

}  // namespace

TEST_CASE("leaves of uniform and graded trees are found by their cells") {
    RandomSource random(7);
    for (int trial = 0; trial < 30; ++trial) {
        const RandomLeaves leaves(random, 40 * (trial % 3), trial % 3 != 0 || trial % 2 == 0);
        const Tree tree = leaves.tree();
        u32 in = 0;
        u32 nio = 0;
        for (const auto& entry : leaves.entries) {
            const u64 cells = u64{1} << (3 * (leaves.kLevel - entry.level));
            for (u64 cell = entry.code; cell < entry.code + cells; ++cell) {
                const Leaf leaf = leaf_at(&tree, cell);
                REQUIRE(leaf.kind == entry.kind);
                if (leaf.kind == kLeafNone) continue;
                REQUIRE(leaf.code == entry.code);
                REQUIRE(leaf.level == entry.level);
                REQUIRE(leaf.index == (entry.kind == kLeafIn ? in : nio));
            }
            REQUIRE(meshed_rank(&tree, entry.code) == in + nio);
            REQUIRE(count_before(&tree, leaves.nio.data(), leaves.nio_rank.data(), entry.code) == nio);
            if (entry.kind != kLeafNone) REQUIRE(leaf_level(&tree, entry.code) == entry.level);
            in += entry.kind == kLeafIn ? 1 : 0;
            nio += entry.kind == kLeafNio ? 1 : 0;
        }
    }
}

TEST_CASE("a vertex or edge root belongs to the first in Morton order of the finest leaves that use it") {
    RandomSource random(3);
    for (int trial = 0; trial < 18; ++trial) {
        const RandomLeaves leaves(random, 40 * (trial % 3), trial % 3 != 0 || trial % 2 == 0);
        const Tree tree = leaves.tree();
        const u32 size = RandomLeaves::kSize;
        for (u32 k = 0; k < (size + 1) * (size + 1) * (size + 1); ++k) {
            const std::array<u32, 3> v = {k % (size + 1), k / (size + 1) % (size + 1),
                                          k / (size + 1) / (size + 1)};
            for (int axis = -1; axis < 3; ++axis) {
                for (i32 level = leaves.kLevel - 1; level <= leaves.kLevel; ++level) {
                    const u32 edge = leaf_edge(&tree, level);
                    if (axis >= 0 && ((v[0] | v[1] | v[2]) & (edge - 1)) != 0) continue;
                    u32 expected_bit = 0;
                    u32 bit = 0;
                    const auto* expected = leaves.owner(v, axis, level, expected_bit);
                    const u64 owner = axis < 0
                                          ? vertex_owner(&tree, leaves.used.data(), v[0], v[1], v[2], &bit)
                                          : edge_owner(&tree, leaves.used.data(), level,
                                                       static_cast<u32>(axis), v[0], v[1], v[2], &bit);
                    REQUIRE(owner == (expected != nullptr ? expected->code : kNoOwner));
                    if (owner != kNoOwner) REQUIRE(bit == expected_bit);
                }
            }
        }
    }
    for (int trial = 0; trial < 6; ++trial) {
        const RandomLeaves leaves(random, 40 * (trial % 2), trial % 2 != 0 || trial == 4);
        const Tree tree = leaves.tree();
        for (const auto& entry : leaves.entries) {
            if (entry.kind == kLeafNone) continue;
            const u32 x = gather_bits(entry.code), y = gather_bits(entry.code >> 1);
            const u32 z = gather_bits(entry.code >> 2), edge = leaf_edge(&tree, entry.level);
            const u32 mark = leaf_mark(&tree, meshed_rank(&tree, entry.code));
            u32 owned = 0;
            for (u32 c = 0; c < 8; ++c) {
                if (((entry.mask >> c) & 1) == 0) continue;
                u32 expected_bit = 0;
                u32 bit = 0;
                const u64 expected =
                    vertex_owner(&tree, leaves.used.data(), x + (c & 1) * edge, y + ((c >> 1) & 1) * edge,
                                 z + (c >> 2) * edge, &expected_bit);
                REQUIRE(corner_owner(&tree, leaves.used.data(), entry.code, mark, x, y, z, edge, c, &bit) ==
                        expected);
                if (expected != kNoOwner) REQUIRE(bit == expected_bit);
                owned |= expected == entry.code ? 1u << c : 0u;
            }
            for (u32 e = 0; e < 12; ++e) {
                if (((entry.mask >> (8 + e)) & 1) == 0) continue;
                const u32 low = kEdgeCorners[e][0];
                u32 expected_bit = 0;
                u32 bit = 0;
                const u64 expected =
                    edge_owner(&tree, leaves.used.data(), entry.level, e / 4, x + (low & 1) * edge,
                               y + ((low >> 1) & 1) * edge, z + (low >> 2) * edge, &expected_bit);
                REQUIRE(own_edge_owner(&tree, leaves.used.data(), entry.code, entry.level, e, &bit) ==
                        expected);
                if (expected != kNoOwner) REQUIRE(bit == expected_bit);
                owned |= expected == entry.code ? 1u << (8 + e) : 0u;
            }
            if (!leaves.graded)
                REQUIRE(owned_of_uniform(&tree, leaves.used.data(), entry.code, entry.mask) == owned);
        }
    }
    CHECK(mask_rank(0b1011010, 6) == 3);
    CHECK(mask_rank(0b1011010, 0) == 0);
}
