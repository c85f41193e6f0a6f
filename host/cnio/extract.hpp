// Extraction of all complex cells by the certificate, on host threads.
#pragma once

#include <cstdint>
#include <vector>

#include "host/cnio/certificate.hpp"
#include "host/probe/probe.hpp"

namespace mortise::cnio {

/// Meshes of the CNIO leaves. records[i] belongs to leaves[i]; its data lies in one
/// arena.
struct Extraction {
    std::vector<std::uint32_t> leaves;  ///< the list, indices into Octree::nio, ascending
    std::vector<CellRecord> records;
    std::vector<CellArena> arenas;  ///< one per thread; which one a cell is in does not matter to anyone
};

/// The codes for Octree::crowded, ascending: leaves with more surfaces than can be cut into elements of any
/// use, by their number or by what the certificate makes of each while none counts as crowded. Leaves with
/// several regions or a joint are never among them.
std::vector<std::uint64_t> find_crowded(const tape::BoundModel& model, const octree::Octree& tree,
                                        const std::vector<std::uint32_t>& leaves, int threads);

/// Runs the certificate on the leaves tree.nio[leaves[i]]. Cells do not depend on each other. `apexes`, by
/// Morton code, tell where the cones of some of them have their apex.
Extraction extract(const tape::BoundModel& model, const octree::Octree& tree,
                   const std::vector<std::uint32_t>& leaves, const std::vector<probe::Apex>& apexes,
                   int threads);

/// A leaf to be meshed, and the place of its record.
struct CellToMesh {
    TreeNode leaf;
    std::uint32_t place;
};

/// Meshes leaves for the first time or again. IN leaves, too: those with a face that is split.
void extract_again(const tape::BoundModel& model, const octree::Octree& tree,
                   const std::vector<CellToMesh>& cells, const std::vector<probe::Apex>& apexes, int threads,
                   Extraction& extraction);

}  // namespace mortise::cnio
