// Which leaves hold more surfaces than can be cut into elements of any use (crowd.cpp tells what becomes of
// them).
#include <algorithm>

#include "host/cnio/extract.hpp"
#include "host/common/parallel.hpp"

namespace mortise::cnio {
namespace {

constexpr std::size_t kFewSurfaces = 4;       ///< never too many
constexpr std::size_t kMostSurfaces = 16;     ///< more are always too many
constexpr std::size_t kManyTetrahedra = 400;  ///< of a cell that is not cut as it should be; usually 80
constexpr std::size_t kMostTetrahedra = 700;  ///< of any

/// Whether the tape tells one region from the outside.
bool has_one_region(const std::uint32_t* words, std::size_t length) {
    const std::uint32_t last = words[length - 1];
    return tape_operation(last) == kTapeSelectConst && tape_otherwise(last) == 0 &&
           std::none_of(words, words + length - 1, [](std::uint32_t word) {
               return tape_operation(word) == kTapeSelect || tape_operation(word) == kTapeSelectConst;
           });
}

/// Whether the certificate makes too many elements of a leaf.
bool is_overcut(Certificate& certificate, const TreeNode& leaf) {
    CellArena arena;
    const CellCounters before = certificate.counters();
    const CellRecord record = certificate.run(leaf, arena);
    const CellCounters& after = certificate.counters();
    const bool in_trouble = after.refused != before.refused || after.unresolved != before.unresolved;
    return record.element_count[static_cast<std::size_t>(ElementType::kTetrahedron)] >
           (in_trouble ? kManyTetrahedra : kMostTetrahedra);
}

/// Whether a leaf is crowded; `surfaces` is scratch.
bool is_crowded(const octree::Octree& tree, const TreeNode& leaf, Certificate& certificate,
                std::vector<std::uint32_t>& surfaces) {
    const std::uint32_t* words = tree.tapes.data() + leaf.tape_offset;
    if (leaf.tape_length <= kFewSurfaces || !has_one_region(words, leaf.tape_length)) return false;
    if (tree.joint_in(leaf.morton) != nullptr) return false;
    tape::list_surfaces(words, leaf.tape_length, surfaces);
    if (surfaces.size() <= kFewSurfaces) return false;
    return surfaces.size() > kMostSurfaces || is_overcut(certificate, leaf);
}

}  // namespace

std::vector<std::uint64_t> find_crowded(const tape::BoundModel& model, const octree::Octree& tree,
                                        const std::vector<std::uint32_t>& leaves, int threads) {
    constexpr std::size_t kChunk = 64;
    std::vector<std::uint8_t> crowded(leaves.size(), 0);
    const auto judge = [&](std::size_t begin, std::size_t end, int) {
        Certificate certificate(model, tree);
        std::vector<std::uint32_t> surfaces;
        for (std::size_t i = begin; i < end; ++i)
            crowded[i] = is_crowded(tree, tree.nio[leaves[i]], certificate, surfaces);
    };
    parallel_chunks(leaves.size(), kChunk, thread_count(threads), judge);
    std::vector<std::uint64_t> codes;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (crowded[i] != 0) codes.push_back(tree.nio[leaves[i]].morton);
    }
    return codes;
}

}  // namespace mortise::cnio
