#include "host/assembly/nodes.hpp"

#include <algorithm>

#include "host/common/parallel.hpp"

namespace mortise::assembly {

CnioCells::CnioCells(const octree::Octree& tree, const std::vector<std::uint32_t>& extracted,
                     const cnio::Extraction& extraction)
    : tree_(tree), extraction_(extraction), index_(tree.nio.size(), kNotCnio) {
    for (std::uint32_t i = 0; i < extracted.size(); ++i) index_[extracted[i]] = i;
}

CnioCells::Owner CnioCells::owner(std::uint32_t nio, std::uint32_t place) const {
    const cnio::CellRecord& mine = *record(nio);
    const cnio::NodeKey key = arena(mine).extras[mine.first_extra + place];
    const std::uint64_t morton = tree_.nio[nio].morton;
    const std::int64_t at[3] = {key.x, key.y, key.z};
    const std::int64_t cell[3] = {gather_bits(morton), gather_bits(morton >> 1), gather_bits(morton >> 2)};
    const std::int64_t size = std::int64_t{1} << tree_.level;
    // Neighbours whose closed cell holds the node: a step along each axis in which it lies on a side.
    int step[3];
    for (int j = 0; j < 3; ++j) {
        const std::int64_t local = at[j] - (cell[j] << kCellUnitBits);
        step[j] = local == 0 ? -1 : local == kCellUnits ? 1 : 0;
    }
    Owner best{nio, place};
    std::uint64_t first = morton;
    for (int d = 1; d < 8; ++d) {
        std::int64_t other[3];
        bool exists = true;
        for (int j = 0; j < 3; ++j) {
            const int move = (d >> j) & 1;
            if (move != 0 && step[j] == 0) exists = false;
            other[j] = cell[j] + move * step[j];
            exists = exists && other[j] >= 0 && other[j] < size;
        }
        if (!exists) continue;
        const std::uint64_t code =
            morton_encode(static_cast<u32>(other[0]), static_cast<u32>(other[1]), static_cast<u32>(other[2]));
        if (code >= first || !tree_.is_nio(code)) continue;
        const std::uint32_t index = tree_.nio_index(code);
        const cnio::CellRecord* theirs = record(index);
        if (theirs == nullptr) continue;
        const auto begin = arena(*theirs).extras.begin() + theirs->first_extra;
        const auto end = begin + theirs->extra_count;
        const auto found = std::lower_bound(begin, end, key);
        if (found == end || !(*found == key)) continue;
        best = {index, static_cast<std::uint32_t>(found - begin)};
        first = code;
    }
    return best;
}

ExtraRanks rank_extras(const Input& input, const CnioCells& cells) {
    ExtraRanks result;
    result.owned_count.assign(input.tree.nio.size(), 0);
    for (const cnio::CellArena& arena : input.extraction.arenas) {
        result.rank.emplace_back(arena.extras.size(), ExtraRanks::kNotOwned);
    }
    const auto& list = input.extraction.leaves;
    parallel_chunks(list.size(), 256, input.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const cnio::CellRecord& record = input.extraction.records[i];
            std::uint32_t count = 0;
            for (std::uint32_t k = 0; k < record.extra_count; ++k) {
                if (cells.owner(list[i], k).nio != list[i]) continue;
                result.rank[record.arena][record.first_extra + k] = count++;
            }
            result.owned_count[list[i]] = count;
        }
    });
    return result;
}

bool NodeLookup::grid_owner(std::uint64_t morton, std::uint16_t code, std::uint64_t* owner,
                            std::uint32_t* bit) const {
    const u32 corner = code < 8 ? code : kEdgeCorners[code - 8][0];
    const u32 x = gather_bits(morton) + (corner & 1);
    const u32 y = gather_bits(morton >> 1) + ((corner >> 1) & 1);
    const u32 z = gather_bits(morton >> 2) + (corner >> 2);
    const u32* in = tree_.in_bits.data();
    const u32* nio = tree_.nio_bits.data();
    *owner = code < 8 ? vertex_owner(in, nio, tree_.nio_rank.data(), numbering_.used.data(), tree_.level, x,
                                     y, z, bit)
                      : edge_owner(in, nio, tree_.nio_rank.data(), numbering_.used.data(), tree_.level,
                                   static_cast<u32>((code - 8) / 4), x, y, z, bit);
    return *owner != kNoOwner;
}

NodeId NodeLookup::grid_node(std::uint64_t morton, std::uint16_t code) const {
    std::uint64_t owner = 0;
    std::uint32_t bit = 0;
    if (!grid_owner(morton, code, &owner, &bit)) {
        throw Error(ExitCode::kMeshing, "internal error: a node has no owner; please report the model");
    }
    if (!numbering_.range.holds(owner)) {
        const auto& list = numbering_.foreign_grid;
        const auto found = std::lower_bound(list.begin(), list.end(), node_key(owner, bit));
        return numbering_.nodes + static_cast<NodeId>(found - list.begin());
    }
    const std::uint32_t rank = meshed_rank(owner);
    return numbering_.base[rank] + mask_rank(numbering_.owned[rank], bit);
}

NodeId NodeLookup::first_extra(std::uint32_t nio) const {
    const std::uint32_t rank = meshed_rank(tree_.nio[nio].morton);
    return numbering_.base[rank] + count_bits(numbering_.owned[rank]);
}

NodeId NodeLookup::node(std::uint32_t nio, const cnio::CellRecord& record, std::uint16_t code) const {
    if (code < cnio::kExtraCode) return grid_node(tree_.nio[nio].morton, code);
    const std::uint32_t place = code - cnio::kExtraCode;
    std::uint32_t rank = extras_.rank[record.arena][record.first_extra + place];
    const bool own = rank != ExtraRanks::kNotOwned;
    if (own && numbering_.range.holds(tree_.nio[nio].morton)) return first_extra(nio) + rank;
    const CnioCells::Owner owner = own ? CnioCells::Owner{nio, place} : cells_.owner(nio, place);
    if (!numbering_.range.holds(tree_.nio[owner.nio].morton)) {
        const auto& list = numbering_.foreign_extras;
        const auto found = std::lower_bound(list.begin(), list.end(), ExtraName{owner.nio, owner.place});
        return numbering_.nodes + static_cast<NodeId>(numbering_.foreign_grid.size() +
                                                      static_cast<std::size_t>(found - list.begin()));
    }
    const cnio::CellRecord& theirs = *cells_.record(owner.nio);
    rank = extras_.rank[theirs.arena][theirs.first_extra + owner.place];
    return first_extra(owner.nio) + rank;
}

}  // namespace mortise::assembly
