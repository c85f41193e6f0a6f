// Morton codes and the tables of corners, edges and faces, against their definitions in lattice.h; owners of
// vertices and edges by brute force.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "kernels/shared/lattice.h"
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

TEST_CASE("the owner of a vertex or edge root is the first leaf in Morton order that uses it") {
    RandomSource random(3);
    constexpr i32 kLevel = 3;
    constexpr u32 kSize = 1u << kLevel;
    constexpr u32 kCells = kSize * kSize * kSize;
    for (int trial = 0; trial < 12; ++trial) {
        std::vector<u32> in(kCells / 32, 0);
        std::vector<u32> nio(kCells / 32, 0);
        std::vector<u32> rank(kCells / 32 + 1, 0);
        std::vector<u32> used;
        std::vector<u32> mask(kCells, 0);  // by cell: what it uses
        for (u32 cell = 0; cell < kCells; ++cell) {
            const int kind = random.integer(0, 2);
            if (kind == 1) {
                in[cell / 32] |= 1u << (cell % 32);
                mask[cell] = 0xff;
            } else if (kind == 2) {
                nio[cell / 32] |= 1u << (cell % 32);
                mask[cell] = static_cast<u32>(random.next()) & 0xfffffu;
                used.push_back(mask[cell]);
            }
        }
        for (std::size_t w = 0; w < nio.size(); ++w) {
            rank[w + 1] = rank[w];
            for (int bit = 0; bit < 32; ++bit) rank[w + 1] += (nio[w] >> bit) & 1;
        }
        for (u32 cell = 0, index = 0; cell < kCells; ++cell) {
            if (test_bit(nio.data(), cell) == 0) continue;
            REQUIRE(rank_of(nio.data(), rank.data(), cell) == index);
            ++index;
        }
        // First leaf of each vertex and edge, cell by cell in Morton order.
        for (u32 x = 0; x <= kSize; ++x) {
            for (u32 y = 0; y <= kSize; ++y) {
                for (u32 z = 0; z <= kSize; ++z) {
                    for (int axis = -1; axis < 3; ++axis) {
                        u64 expected = kNoOwner;
                        u32 expected_bit = 0;
                        for (u32 cell = 0; cell < kCells && expected == kNoOwner; ++cell) {
                            const u32 at[3] = {gather_bits(cell), gather_bits(cell >> 1),
                                               gather_bits(cell >> 2)};
                            const u32 d[3] = {x - at[0], y - at[1], z - at[2]};
                            if (d[0] > 1 || d[1] > 1 || d[2] > 1) continue;
                            u32 bit = d[0] + 2 * d[1] + 4 * d[2];
                            if (axis >= 0) {
                                if (d[axis] != 0) continue;
                                for (u32 e = 0; e < 12; ++e) {
                                    if (kEdgeCorners[e][0] == bit && static_cast<int>(e / 4) == axis) {
                                        bit = 8 + e;
                                        break;
                                    }
                                }
                            }
                            if (((mask[cell] >> bit) & 1) == 0) continue;
                            expected = cell;
                            expected_bit = bit;
                        }
                        u32 bit = 0;
                        const u64 owner = axis < 0
                                              ? vertex_owner(in.data(), nio.data(), rank.data(), used.data(),
                                                             kLevel, x, y, z, &bit)
                                              : edge_owner(in.data(), nio.data(), rank.data(), used.data(),
                                                           kLevel, static_cast<u32>(axis), x, y, z, &bit);
                        REQUIRE(owner == expected);
                        if (owner != kNoOwner) REQUIRE(bit == expected_bit);
                    }
                }
            }
        }
    }
    CHECK(mask_rank(0b1011010, 6) == 3);
    CHECK(mask_rank(0b1011010, 0) == 0);
}
