#include "host/cnio/extract.hpp"

#include <algorithm>
#include <memory>
#include <mutex>

#include "host/common/parallel.hpp"

namespace mortise::cnio {

Extraction extract(const tape::BoundModel& model, const octree::Octree& tree,
                   const std::vector<std::uint32_t>& leaves, const std::vector<probe::Apex>& apexes,
                   int threads) {
    constexpr std::size_t kChunk = 64;
    const int workers = thread_count(threads);
    Extraction result;
    result.leaves = leaves;
    result.records.resize(leaves.size());
    result.arenas.resize(static_cast<std::size_t>(workers));
    std::vector<std::unique_ptr<Certificate>> certificates(static_cast<std::size_t>(workers));
    parallel_chunks(leaves.size(), kChunk, workers, [&](std::size_t begin, std::size_t end, int thread) {
        const auto t = static_cast<std::size_t>(thread);
        if (!certificates[t]) certificates[t] = std::make_unique<Certificate>(model, tree);
        Certificate& certificate = *certificates[t];
        for (std::size_t i = begin; i < end; ++i) {
            const CellCounters before = certificate.counters();
            const TreeNode& leaf = tree.nio[leaves[i]];
            const auto apex =
                std::lower_bound(apexes.begin(), apexes.end(), leaf.morton,
                                 [](const probe::Apex& a, std::uint64_t code) { return a.morton < code; });
            const bool moved = apex != apexes.end() && apex->morton == leaf.morton;
            result.records[i] = certificate.run(leaf, result.arenas[t], moved ? &apex->at : nullptr);
            result.records[i].arena = static_cast<std::uint32_t>(thread);
            const CellCounters& after = certificate.counters();
            result.records[i].refused = static_cast<std::uint32_t>(after.refused - before.refused);
            result.records[i].limited = static_cast<std::uint32_t>(after.limited - before.limited);
            result.records[i].unresolved = static_cast<std::uint32_t>(after.unresolved - before.unresolved);
        }
    });
    for (std::size_t t = 0; t < certificates.size(); ++t) {
        if (!certificates[t]) continue;
        result.counters.refused += certificates[t]->counters().refused;
        result.counters.limited += certificates[t]->counters().limited;
        result.counters.unresolved += certificates[t]->counters().unresolved;
        result.counters.forced_caps += certificates[t]->counters().forced_caps;
    }
    return result;
}

}  // namespace mortise::cnio
