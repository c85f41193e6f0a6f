#include "host/cnio/extract.hpp"

#include <algorithm>
#include <memory>

#include "host/common/parallel.hpp"

namespace mortise::cnio {

Extraction extract(const tape::BoundModel& model, const octree::Octree& tree,
                   const std::vector<std::uint32_t>& leaves, const std::vector<probe::Apex>& apexes,
                   int threads) {
    Extraction result;
    result.leaves = leaves;
    result.records.resize(leaves.size());
    std::vector<CellToMesh> all;
    for (std::uint32_t i = 0; i < leaves.size(); ++i) all.push_back({tree.nio[leaves[i]], i});
    extract_again(model, tree, all, apexes, threads, result);
    return result;
}

void extract_again(const tape::BoundModel& model, const octree::Octree& tree,
                   const std::vector<CellToMesh>& cells, const std::vector<probe::Apex>& apexes, int threads,
                   Extraction& extraction) {
    constexpr std::size_t kChunk = 64;
    const auto workers = static_cast<std::size_t>(thread_count(threads));
    extraction.arenas.resize(std::max(extraction.arenas.size(), workers));
    std::vector<std::unique_ptr<Certificate>> certificates(workers);
    const auto run = [&](std::size_t begin, std::size_t end, int thread) {
        const auto t = static_cast<std::size_t>(thread);
        if (!certificates[t]) certificates[t] = std::make_unique<Certificate>(model, tree);
        Certificate& certificate = *certificates[t];
        for (std::size_t i = begin; i < end; ++i) {
            const CellCounters before = certificate.counters();
            const TreeNode& leaf = cells[i].leaf;
            const auto apex =
                std::lower_bound(apexes.begin(), apexes.end(), leaf.morton,
                                 [](const probe::Apex& a, std::uint64_t code) { return a.morton < code; });
            const bool moved = apex != apexes.end() && apex->morton == leaf.morton;
            CellRecord& record = extraction.records[cells[i].place];
            record = certificate.run(leaf, extraction.arenas[t], moved ? &apex->at : nullptr);
            record.arena = static_cast<std::uint32_t>(thread);
            const CellCounters& after = certificate.counters();
            record.refused = static_cast<std::uint32_t>(after.refused - before.refused);
            record.limited = static_cast<std::uint32_t>(after.limited - before.limited);
            record.unresolved = static_cast<std::uint32_t>(after.unresolved - before.unresolved);
        }
    };
    parallel_chunks(cells.size(), kChunk, threads, run);
}

}  // namespace mortise::cnio
