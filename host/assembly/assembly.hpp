// Assembly: one numbering by ownership, node positions, connectivity and facets of all leaves.
//
// A piece of the mesh is made by the leaves of one Morton range, from those leaves and one ring around them;
// pieces made apart merge into the same bytes as the whole.
//
// Counts first, then fills at the offsets that follow from them, so every part can be made by anyone, in any
// order (invariant 6 of ARCHITECTURE.md). Grid vertices, IN hexahedra and templates are written by
// kernels/assembly/number.cl, the certificate's cells by host threads.
#pragma once

#include "host/cnio/extract.hpp"
#include "host/device/device.hpp"
#include "host/octree/octree.hpp"
#include "host/snio/classify.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::assembly {

/// Leaves with Morton codes in [begin, end) at the finest level; both are multiples of 32, or the whole tree.
struct MortonRange {
    std::uint64_t begin = 0;
    std::uint64_t end = ~std::uint64_t{0};
    bool holds(std::uint64_t morton) const { return morton >= begin && morton < end; }
};

/// Memory that a run leaves to the next one; all of it may be empty.
struct Arena {
    Mesh mesh;                               ///< nobody needs it: its arrays serve the new one where they fit
    std::vector<std::uint32_t> owned, base;  ///< of the numbering
};

struct Input {
    const tape::BoundModel& model;
    const octree::Octree& tree;
    octree::DeviceTree& on_device;
    const snio::Classification& classification;
    const cnio::Extraction& extraction;
    const octree::InRegions& in_regions;
    int threads;
    MortonRange range{};
    Arena* arena = nullptr;  ///< its arrays are used where they fit
};

/// An extra node of a CNIO leaf: the leaf's index and the node's place among its extras.
struct ExtraName {
    std::uint32_t nio;
    std::uint32_t place;
    friend bool operator<(const ExtraName& a, const ExtraName& b) {
        return a.nio != b.nio ? a.nio < b.nio : a.place < b.place;
    }
};

/// The mesh of one range. Nodes 0 … owned - 1 are its own, with positions; then come the foreign ones,
/// without.
struct Piece {
    Mesh mesh;
    std::vector<std::uint64_t> foreign_grid;  ///< node_key of foreign grid nodes, ascending
    std::vector<ExtraName> foreign_extras;  ///< foreign extra nodes, ascending; numbered behind foreign_grid
    /// Own nodes that other pieces may name, ascending.
    std::vector<std::pair<std::uint64_t, NodeId>> grid_frontier;
    std::vector<std::pair<ExtraName, NodeId>> extra_frontier;
};

/// Meshes one range. The extraction must hold the CNIO leaves of the range and of the ring around it
/// (leaves_needed). Facets carry indices of BoundModel::surface_name; names are left to the caller.
Piece assemble(device::Device& device, const Input& input);

/// CNIO leaves, out of `cnio`, that lie in the range or touch one of its cells.
std::vector<std::uint32_t> leaves_needed(const octree::Octree& tree, const std::vector<std::uint32_t>& cnio,
                                         const MortonRange& range);

/// Joins the pieces of consecutive ranges that cover the tree into one mesh; takes little more memory than
/// the pieces do.
Mesh merge(std::vector<Piece> pieces, int threads);

}  // namespace mortise::assembly
