// 2:1 balance of a tree given by its split nodes.
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/octree/octree.hpp"

namespace mortise::octree {
namespace {

constexpr std::size_t kBalanceChunk = 8192;
/// Children on the low and high side of each axis.
constexpr std::uint32_t kSide[3][2] = {{0x55, 0xaa}, {0x33, 0xcc}, {0x0f, 0xf0}};

/// Nodes of the level above `level` that the closed cubes of some children of one node touch; bit c of
/// `children`: child c is one of them. A child touches the 2³ nodes on its side.
void add_parents(std::uint64_t parent, std::uint32_t children, int level, std::vector<std::uint64_t>& out) {
    const std::int64_t size = std::int64_t{1} << (level - 1);
    const std::int64_t at[3] = {gather_bits(parent), gather_bits(parent >> 1), gather_bits(parent >> 2)};
    for (int k = 0; k < 27; ++k) {
        const int d[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        std::uint32_t touching = children;
        bool inside = true;
        for (int j = 0; j < 3; ++j) {
            if (d[j] != 0) touching &= kSide[j][d[j] > 0 ? 1 : 0];
            inside = inside && at[j] + d[j] >= 0 && at[j] + d[j] < size;
        }
        if (touching == 0 || !inside) continue;
        out.push_back(morton_encode(static_cast<u32>(at[0] + d[0]), static_cast<u32>(at[1] + d[1]),
                                    static_cast<u32>(at[2] + d[2])));
    }
}

/// Makes the places around these nodes, in ascending order, nodes.
void split_around(const std::vector<std::uint64_t>& nodes, std::size_t level, int threads,
                  std::vector<std::uint64_t>& split) {
    std::vector<std::vector<std::uint64_t>> parts(chunk_count(nodes.size(), kBalanceChunk));
    parallel_chunks(nodes.size(), kBalanceChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        auto& part = parts[begin / kBalanceChunk];
        for (std::size_t i = begin; i < end;) {
            const std::uint64_t parent = nodes[i] >> 3;
            std::uint32_t children = 0;
            for (; i < end && nodes[i] >> 3 == parent; ++i) children |= 1u << (nodes[i] & 7);
            add_parents(parent, children, static_cast<int>(level), part);
        }
        sort_unique(part);
    });
    for (const auto& part : parts) split.insert(split.end(), part.begin(), part.end());
}

}  // namespace

void balance(SplitNodes& split, const SplitNodes& ringed, int threads) {
    for (std::size_t level = 1; level < ringed.size() && level <= split.size(); ++level) {
        split_around(ringed[level], level, threads, split[level - 1]);
    }
    for (std::size_t level = split.size(); level-- > 1;) {
        sort_unique(split[level]);
        split_around(split[level], level, threads, split[level - 1]);
    }
    if (!split.empty()) sort_unique(split[0]);
}

}  // namespace mortise::octree
