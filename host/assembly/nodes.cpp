#include "host/assembly/nodes.hpp"

#include <algorithm>

#include "host/common/parallel.hpp"

namespace mortise::assembly {

CnioCells::CnioCells(const octree::Octree& tree, const std::vector<std::uint32_t>& extracted,
                     const cnio::Extraction& extraction)
    : tree_(tree), extraction_(extraction), index_(tree.nio.size(), kNotCnio) {
    for (std::uint32_t i = 0; i < extracted.size(); ++i) index_[extracted[i]] = i;
}

/// Whether a CNIO leaf uses a node as one of its extras; then it is the owner.
bool CnioCells::find_extra(std::uint32_t nio, const cnio::NodeKey& key, Owner& owner) const {
    const cnio::CellRecord* cell = record(nio);
    if (cell == nullptr) return false;
    const auto begin = arena(*cell).extras.begin() + cell->first_extra;
    const auto end = begin + cell->extra_count;
    const auto found = std::lower_bound(begin, end, key);
    if (found == end || !(*found == key)) return false;
    if (arena(*cell).extra_used[static_cast<std::size_t>(found - arena(*cell).extras.begin())] == 0)
        return false;
    owner = {nio, static_cast<std::uint32_t>(found - begin)};
    return true;
}

/// A vertex of leaves of level + 1, or the single root on one of their edges.
bool CnioCells::find_grid_owner(const cnio::NodeKey& key, int level, const std::vector<std::uint32_t>& used,
                                Owner& owner) const {
    const Tree tree = tree_.view();
    const std::int64_t half = std::int64_t{leaf_edge(&tree, level) / 2} << kCellUnitBits;
    const std::int64_t at[3] = {key.x, key.y, key.z};
    int off = -1;
    for (int j = 0; j < 3; ++j) {
        if (at[j] % half == 0) continue;
        if (off >= 0) return false;
        off = j;
    }
    u32 low[3];
    for (int j = 0; j < 3; ++j) low[j] = static_cast<u32>(at[j] / half * half >> kCellUnitBits);
    owner.grid = off < 0 ? vertex_owner(&tree, used.data(), low[0], low[1], low[2], &owner.bit)
                         : edge_owner(&tree, used.data(), level + 1, static_cast<u32>(off), low[0], low[1],
                                      low[2], &owner.bit);
    return owner.grid != kNoOwner;
}

/// An extra of cells of level + 1, the Morton-first of them.
void CnioCells::find_finer_owner(const cnio::NodeKey& key, std::uint64_t code, int level,
                                 Owner& owner) const {
    const Tree tree = tree_.view();
    const std::int64_t half = leaf_edge(&tree, level) / 2;
    const std::int64_t at[3] = {key.x, key.y, key.z};
    // Half-cells around the node, from -1 to 2 along each axis.
    int low[3];
    int high[3];
    for (int j = 0; j < 3; ++j) {
        const std::int64_t local = at[j] - (std::int64_t{gather_bits(code >> j)} << kCellUnitBits);
        high[j] = static_cast<int>(local / (half << kCellUnitBits));
        low[j] = local % (half << kCellUnitBits) == 0 ? high[j] - 1 : high[j];
    }
    std::uint64_t first = kNoOwner;
    for (int z = low[2]; z <= high[2]; ++z) {
        for (int y = low[1]; y <= high[1]; ++y) {
            for (int x = low[0]; x <= high[0]; ++x) {
                const Leaf leaf = octree::leaf_at_half(tree, code, level, x, y, z);
                if (leaf.kind != kLeafNio || leaf.level != level + 1 || leaf.code >= first) continue;
                if (find_extra(leaf.index, key, owner)) first = leaf.code;
            }
        }
    }
}

CnioCells::Owner CnioCells::owner(std::uint32_t nio, std::uint32_t place,
                                  const std::vector<std::uint32_t>& used) const {
    const cnio::CellRecord& mine = *record(nio);
    const cnio::NodeKey key = arena(mine).extras[mine.first_extra + place];
    const std::uint64_t code = tree_.nio[nio].morton;
    const Tree tree = tree_.view();
    const int level = leaf_level(&tree, code);
    const u32 edge = leaf_edge(&tree, level);
    Owner best{nio, place};
    if (level < tree_.level) {
        if (find_grid_owner(key, level, used, best)) return best;
        find_finer_owner(key, code, level, best);
        if (best.nio != nio) return best;
    }
    // Cells of the same level whose closed cube holds the node: a step along each axis in which it lies on a
    // side.
    const std::int64_t at[3] = {key.x, key.y, key.z};
    int step[3];
    for (int j = 0; j < 3; ++j) {
        const std::int64_t local = at[j] - (std::int64_t{gather_bits(code >> j)} << kCellUnitBits);
        step[j] = local == 0 ? -1 : local == std::int64_t{edge} << kCellUnitBits ? 1 : 0;
    }
    std::uint64_t first = code;
    for (int d = 1; d < 8; ++d) {
        i32 direction[3];
        bool exists = true;
        for (int j = 0; j < 3; ++j) {
            const int move = (d >> j) & 1;
            if (move != 0 && step[j] == 0) exists = false;
            direction[j] = move * step[j];
        }
        if (!exists) continue;
        const Leaf leaf = leaf_beside(&tree, code, level, direction);
        if (leaf.kind != kLeafNio || leaf.level != level || leaf.code >= first) continue;
        if (find_extra(leaf.index, key, best)) first = leaf.code;
    }
    return best;
}

ExtraRanks rank_extras(const Input& input, const CnioCells& cells, const std::vector<std::uint32_t>& used) {
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
                if (cells.arena(record).extra_used[record.first_extra + k] == 0) continue;
                const CnioCells::Owner owner = cells.owner(list[i], k, used);
                if (owner.nio != list[i] || owner.grid != kNoOwner) continue;
                result.rank[record.arena][record.first_extra + k] = count++;
            }
            result.owned_count[list[i]] = count;
        }
    });
    return result;
}

bool NodeLookup::grid_owner(std::uint64_t morton, std::uint16_t code, std::uint64_t* owner,
                            std::uint32_t* bit) const {
    const Tree tree = tree_.view();
    const int level = leaf_level(&tree, morton);
    const u32 edge = leaf_edge(&tree, level);
    const u32 corner = code < 8 ? code : kEdgeCorners[code - 8][0];
    const u32 x = gather_bits(morton) + (corner & 1) * edge;
    const u32 y = gather_bits(morton >> 1) + ((corner >> 1) & 1) * edge;
    const u32 z = gather_bits(morton >> 2) + (corner >> 2) * edge;
    const u32* used = numbering_.used.data();
    *owner = code < 8 ? vertex_owner(&tree, used, x, y, z, bit)
                      : edge_owner(&tree, used, level, static_cast<u32>((code - 8) / 4), x, y, z, bit);
    return *owner != kNoOwner;
}

NodeId NodeLookup::owned_node(std::uint64_t owner, std::uint32_t bit) const {
    if (!numbering_.range.holds(owner)) {
        const auto& list = numbering_.foreign_grid;
        const auto found = std::lower_bound(list.begin(), list.end(), node_key(owner, bit));
        return numbering_.nodes + static_cast<NodeId>(found - list.begin());
    }
    const std::uint32_t rank = rank_of(owner);
    return numbering_.base[rank] + mask_rank(numbering_.owned[rank], bit);
}

NodeId NodeLookup::grid_node(std::uint64_t morton, std::uint16_t code) const {
    std::uint64_t owner = 0;
    std::uint32_t bit = 0;
    if (!grid_owner(morton, code, &owner, &bit)) {
        throw Error(ExitCode::kMeshing, "internal error: a node has no owner; please report the model");
    }
    return owned_node(owner, bit);
}

NodeId NodeLookup::first_extra(std::uint32_t nio) const {
    const std::uint32_t rank = rank_of(tree_.nio[nio].morton);
    return numbering_.base[rank] + count_bits(numbering_.owned[rank]);
}

NodeId NodeLookup::node(std::uint32_t nio, const cnio::CellRecord& record, std::uint16_t code) const {
    if (code < cnio::kExtraCode) return grid_node(tree_.nio[nio].morton, code);
    const std::uint32_t place = code - cnio::kExtraCode;
    std::uint32_t rank = extras_.rank[record.arena][record.first_extra + place];
    const bool own = rank != ExtraRanks::kNotOwned;
    if (own && numbering_.range.holds(tree_.nio[nio].morton)) return first_extra(nio) + rank;
    const CnioCells::Owner owner =
        own ? CnioCells::Owner{nio, place} : cells_.owner(nio, place, numbering_.used);
    if (owner.grid != kNoOwner) return owned_node(owner.grid, owner.bit);
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
