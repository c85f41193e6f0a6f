#include "host/pipeline/piece.hpp"

#include <algorithm>

#include "host/cnio/extract.hpp"

namespace mortise::pipeline {

std::uint64_t pieces_needed(const octree::Octree& tree, std::uint64_t largest) {
    constexpr std::uint64_t kInBytes = 36, kNioBytes = 200;  // measured: 32 and 24; and up to 150
    return (kInBytes * tree.in_count + kNioBytes * tree.nio.size()) / largest + 1;
}

std::uint64_t piece_end(const octree::Octree& tree, std::uint64_t p, std::uint64_t count) {
    const auto leaves = [&tree](std::size_t word) {
        return std::uint64_t{tree.in_rank[word]} + tree.nio_rank[word];
    };
    const std::uint64_t wanted = leaves(tree.words()) * p / count;
    std::size_t low = 0, high = tree.words();
    while (low < high) {
        const std::size_t middle = (low + high) / 2;
        if (leaves(middle) < wanted) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return tree.code_of_word(low);
}

assembly::Piece make_piece(device::Device& device, const MeshOptions& options, Prepared& prepared,
                           const octree::InRegions& in_regions, const assembly::MortonRange& range,
                           Stages& stages, double begin, double end, Extracted& extracted,
                           assembly::Arena* arena) {
    const octree::Octree& tree = prepared.tree;
    const bool whole = range.begin == 0 && range.end == assembly::MortonRange{}.end;
    stages.begin("extract", begin);
    const std::vector<std::uint32_t> leaves =
        whole ? prepared.classification.cnio
              : assembly::leaves_needed(tree, prepared.classification.cnio, range);
    const bool is_known = whole && prepared.extraction.records.size() == leaves.size();
    if (!is_known) prepared.extraction = {};
    const cnio::Extraction extraction =
        is_known ? std::move(prepared.extraction)
                 : cnio::extract(prepared.bound, tree, leaves, prepared.apexes, options.threads);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (!range.holds(tree.nio[leaves[i]].morton)) continue;
        const cnio::CellRecord& record = extraction.records[i];
        extracted.refused += record.refused;
        extracted.unresolved += record.unresolved;
        // A split that is refused leaves out what is flatter than the lattice tells, if all is labelled.
        if (record.unresolved + record.limited == 0) continue;
        ++extracted.troubled;
        extracted.first_troubled = std::min(extracted.first_troubled, tree.nio[leaves[i]].morton);
    }
    stages.end(leaves.size());
    stages.begin("assemble", begin + 0.6 * (end - begin));
    assembly::Piece piece =
        assembly::assemble(device, {prepared.bound, tree, prepared.on_device, prepared.classification,
                                    extraction, in_regions, options.threads, range, arena});
    stages.end(piece.mesh.element_count());
    return piece;
}

}  // namespace mortise::pipeline
