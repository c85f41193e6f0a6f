// 2:1 balance of a tree given by its split nodes.
#include <algorithm>

#include "host/common/parallel.hpp"
#include "host/octree/octree.hpp"

namespace mortise::octree {
namespace {

constexpr std::size_t kChunk = 8192;

void sort_unique(std::vector<std::uint64_t>& codes) {
    std::sort(codes.begin(), codes.end());
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
}

/// Parents of a node of this level and of the places around it: the 2³ nodes of the level above that its
/// closed cube touches.
void add_parents(std::uint64_t code, int level, std::vector<std::uint64_t>& out) {
    const std::int64_t size = std::int64_t{1} << (level - 1);
    const std::int64_t at[3] = {gather_bits(code), gather_bits(code >> 1), gather_bits(code >> 2)};
    std::int64_t places[3][2];
    for (int j = 0; j < 3; ++j) {
        places[j][0] = at[j] >> 1;
        places[j][1] = (at[j] & 1) != 0 ? (at[j] >> 1) + 1 : (at[j] >> 1) - 1;
    }
    for (int d = 0; d < 8; ++d) {
        const std::int64_t x = places[0][d & 1];
        const std::int64_t y = places[1][(d >> 1) & 1];
        const std::int64_t z = places[2][d >> 2];
        if (x < 0 || y < 0 || z < 0 || x >= size || y >= size || z >= size) continue;
        out.push_back(morton_encode(static_cast<u32>(x), static_cast<u32>(y), static_cast<u32>(z)));
    }
}

/// Makes the places around these nodes nodes.
void split_around(const std::vector<std::uint64_t>& nodes, std::size_t level, int threads,
                  std::vector<std::uint64_t>& split) {
    std::vector<std::vector<std::uint64_t>> parts(chunk_count(nodes.size(), kChunk));
    parallel_chunks(nodes.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        auto& part = parts[begin / kChunk];
        for (std::size_t i = begin; i < end; ++i) add_parents(nodes[i], static_cast<int>(level), part);
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
