// Node numbers of the certificate's cells: ownership of their extra nodes, and lookup of any local code.
#pragma once

#include <cstdint>
#include <vector>

#include "host/assembly/assembly.hpp"

namespace mortise::assembly {

inline constexpr std::uint32_t kNotCnio = 0xffffffffu;

/// Read access to the certificate's cells by NIO leaf.
class CnioCells {
  public:
    CnioCells(const octree::Octree& tree, const std::vector<std::uint32_t>& extracted,
              const cnio::Extraction& extraction);

    /// Record of an NIO leaf, or null if a template meshes it.
    const cnio::CellRecord* record(std::uint32_t nio) const {
        const std::uint32_t index = index_[nio];
        return index == kNotCnio ? nullptr : &extraction_.records[index];
    }
    const cnio::CellArena& arena(const cnio::CellRecord& r) const { return extraction_.arenas[r.arena]; }

    /// Owner of an extra node of leaf `nio`: of the finest cells around it that use it, the Morton-first, and
    /// its place there. In a graded tree, vertices and single roots of finer leaves belong to these.
    struct Owner {
        std::uint32_t nio;
        std::uint32_t place;            ///< index among the owner's extras
        std::uint64_t grid = kNoOwner;  ///< else: the leaf that has the node
        std::uint32_t bit = 0;          ///< as this bit of its mask
    };
    Owner owner(std::uint32_t nio, std::uint32_t place, const std::vector<std::uint32_t>& used) const;

  private:
    bool find_grid_owner(const cnio::NodeKey& key, int level, const std::vector<std::uint32_t>& used,
                         Owner& owner) const;
    void find_finer_owner(const cnio::NodeKey& key, std::uint64_t code, int level, Owner& owner) const;
    bool find_extra(std::uint32_t nio, const cnio::NodeKey& key, Owner& owner) const;

    const octree::Octree& tree_;
    const cnio::Extraction& extraction_;
    std::vector<std::uint32_t> index_;
};

/// Ownership of all extra nodes, by arena: rank among the owner's owned extras, or kNotOwned.
struct ExtraRanks {
    static constexpr std::uint32_t kNotOwned = 0xffffffffu;
    std::vector<std::vector<std::uint32_t>> rank;  ///< [arena][extra]
    std::vector<std::uint32_t> owned_count;        ///< per NIO leaf
};
ExtraRanks rank_extras(const Input& input, const CnioCells& cells, const std::vector<std::uint32_t>& used);

/// Numbering of the piece's nodes, for host lookups.
struct Numbering {
    MortonRange range;
    std::uint32_t nodes = 0;                  ///< own ones
    std::vector<std::uint64_t> foreign_grid;  ///< ascending
    std::vector<ExtraName> foreign_extras;    ///< ascending
    std::vector<std::uint32_t> used;          ///< per NIO leaf
    std::uint32_t first_rank = 0;             ///< of the range's first leaf among all meshed ones
    std::vector<std::uint32_t> owned;         ///< per meshed leaf of the range
    std::vector<std::uint32_t> base;          ///< the same, one more at the end: the number of nodes
};

class NodeLookup {
  public:
    NodeLookup(const octree::Octree& tree, const CnioCells& cells, const ExtraRanks& extras,
               const Numbering& numbering)
        : tree_(tree), cells_(cells), extras_(extras), numbering_(numbering) {}

    /// Node of a corner (code 0–7) or single root (8–19) of the cell at `morton`, whoever uses it.
    NodeId grid_node(std::uint64_t morton, std::uint16_t code) const;

    /// Node of any code of a CNIO leaf.
    NodeId node(std::uint32_t nio, const cnio::CellRecord& record, std::uint16_t code) const;

    /// Owner and bit of a grid node; false if no leaf uses it.
    bool grid_owner(std::uint64_t morton, std::uint16_t code, std::uint64_t* owner, std::uint32_t* bit) const;

    /// Number of a grid node by owner and bit.
    NodeId owned_node(std::uint64_t owner, std::uint32_t bit) const;

    /// Number of the leaf's first owned extra node.
    NodeId first_extra(std::uint32_t nio) const;

    /// Place of a leaf of the range among its meshed leaves.
    std::uint32_t rank_of(std::uint64_t code) const {
        const Tree tree = tree_.view();
        return meshed_rank(&tree, code) - numbering_.first_rank;
    }

  private:
    const octree::Octree& tree_;
    const CnioCells& cells_;
    const ExtraRanks& extras_;
    const Numbering& numbering_;
};

}  // namespace mortise::assembly
