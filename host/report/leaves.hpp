// The boundary leaves of a solid, found by descending with the host reference of the classification.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/common/leaf_grid.hpp"
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/watch.hpp"
#include "host/features/surfaces.hpp"
#include "host/tape/reference.hpp"

namespace mortise::report {

using features::Vector;

/// Deepest level that the report descends to in uniform trees: about a million boundary leaves.
inline constexpr int kDeepestLevel = 8;
/// In graded trees it descends deeper, as far as no more leaves than these are needed.
inline constexpr std::size_t kMostLeaves = std::size_t{1} << 21;

/// Where the report stops descending: at `deepest`, or where the mesh's own leaves are no smaller.
struct Depth {
    int deepest = 0;
    const LeafGrid* leaves = nullptr;  ///< null: uniform

    static Depth of(int level, const LeafGrid* leaves) {
        Depth depth{std::min(level, kDeepestLevel), nullptr};
        if (leaves == nullptr || leaves->is_uniform()) return depth;
        depth.leaves = leaves;
        while (depth.deepest < leaves->level && depth.count_leaves(depth.deepest + 1) <= kMostLeaves) {
            ++depth.deepest;
        }
        return depth;
    }

    /// Leaves of the tree cut off at a level.
    std::size_t count_leaves(int level) const {
        std::size_t count = 0;
        std::uint64_t before = ~std::uint64_t{0};
        const int shift = 3 * (leaves->level - level);
        for (std::size_t i = 0; i < leaves->size(); ++i) {
            const std::uint64_t cell = leaves->code[i] >> shift;
            count += leaves->leaf_level[i] <= level || cell != before ? 1 : 0;
            before = cell;
        }
        return count;
    }

    /// Whether a cell is not split. One without meshed leaves is as long as a leaf beside it is finer.
    bool ends_at(std::uint64_t number, int depth) const {
        if (depth == deepest) return true;
        if (leaves == nullptr) return false;
        const int size_class = leaves->level - depth;
        const GridCube cell{number << (3 * size_class), size_class};
        const std::size_t leaf = find_leaf(*leaves, cell.code);
        if (leaf != kNoLeaf && leaves->size_class(leaf) >= size_class) return true;
        const auto next = std::lower_bound(leaves->code.begin(), leaves->code.end(), cell.code);
        if (next != leaves->code.end() && *next < cell.end()) return false;
        bool finer = false;
        for_touching_leaves(
            *leaves, cell, [&](std::size_t near) { finer = finer || leaves->size_class(near) < size_class; });
        return !finer;
    }
};

/// A cell that the solid's boundary may pass through.
struct Leaf {
    tape::Cell cell{};
    std::uint64_t number = 0;             ///< Morton code
    std::vector<std::uint32_t> tape;      ///< pruned
    std::vector<std::uint32_t> surfaces;  ///< of the tape, ascending

    Vector centre() const { return {cell.centre[0], cell.centre[1], cell.centre[2]}; }

    /// Region for the signs (-1 or 1) of the surfaces.
    std::int32_t region(const std::vector<std::int8_t>& signs) const {
        return tape::evaluate_signs(tape.data(), tape.size(), surfaces.data(), surfaces.size(), signs.data());
    }

    /// Signs at a point of the closed cell; zero counts as inside.
    void signs_at(const tape::BoundModel& model, const Vector& local, std::vector<std::int8_t>& signs) const {
        signs.resize(surfaces.size());
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            signs[i] = features::value(model, surfaces[i], local) <= 0 ? std::int8_t{-1} : std::int8_t{1};
        }
    }
};

inline void list_surfaces(Leaf& leaf) {
    leaf.surfaces.clear();
    for (const std::uint32_t word : leaf.tape) {
        if (tape_operation(word) == kTapeLiteral) leaf.surfaces.push_back(tape_surface(word));
    }
    sort_unique(leaf.surfaces);
}

/// Child in Morton order.
inline tape::Cell child_of(const tape::Cell& cell, unsigned child) {
    tape::Cell part{{0, 0, 0}, 0.5 * cell.half};
    for (unsigned j = 0; j < 3; ++j) {
        part.centre[j] = cell.centre[j] + ((child >> j & 1u) != 0 ? part.half : -part.half);
    }
    return part;
}

/// Visits the boundary leaves below a cell of a level, in Morton order.
template <class Visit>
void descend(const tape::BoundModel& model, const std::vector<std::uint32_t>& tape, const tape::Cell& cell,
             std::uint64_t number, int level, const Depth& depth, const Visit& visit) {
    keep_watch();
    std::vector<std::uint32_t> pruned;
    if (tape::classify_cell(model, tape, cell, &pruned) != kUnknown) return;
    if (depth.ends_at(number, level)) {
        Leaf leaf{cell, number, std::move(pruned), {}};
        list_surfaces(leaf);
        visit(leaf);
        return;
    }
    for (unsigned child = 0; child < 8; ++child) {
        descend(model, pruned, child_of(cell, child), number << 3 | child, level + 1, depth, visit);
    }
}

/// Calls visit(leaf, result) for every boundary leaf; one result per subtree, in Morton order.
template <class Result, class Visit>
std::vector<Result> visit_leaves(const tape::BoundModel& model, const Depth& depth, int threads,
                                 const Visit& visit) {
    const int top = std::min(depth.deepest, 3);
    const std::size_t side = std::size_t{1} << top;
    std::vector<Result> results(side * side * side);
    parallel_chunks(results.size(), 1, threads, [&](std::size_t begin, std::size_t, int) {
        // From the root: what a tape says of polyhedra holds in the children of its cell only.
        std::vector<std::uint32_t> tape = model.tape;
        tape::Cell cell{{0.5, 0.5, 0.5}, 0.5};
        for (int level = 0; level < top; ++level) {
            std::vector<std::uint32_t> pruned;
            if (tape::classify_cell(model, tape, cell, &pruned) != kUnknown) return;
            tape = std::move(pruned);
            cell = child_of(cell, static_cast<unsigned>(begin >> (3 * (top - 1 - level)) & 7u));
        }
        descend(model, tape, cell, begin, top, depth, [&](const Leaf& leaf) { visit(leaf, results[begin]); });
    });
    return results;
}

}  // namespace mortise::report
