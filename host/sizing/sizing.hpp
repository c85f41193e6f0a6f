// Which undecided nodes of the tree must be split, level by level during the descent.
//
// Three criteria: the sizes that are wanted, the curvature of the surfaces, and whether the solid is so
// simple in a node that a leaf can show it (topology.hpp).
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"
#include "kernels/shared/bounds.h"
#include "kernels/shared/expression.h"

namespace mortise::sizing {

/// Element sizes wanted, box-local (the root cube is [0,1]^3). An infinity means no wish.
struct SizeField {
    /// A leaf whose closed cube comes as close as d has an edge of at most size + grading * d.
    struct Source {
        Vec3 at;
        double size;
        double grading;
    };
    double everywhere = std::numeric_limits<double>::infinity();  ///< edge of any leaf
    std::vector<double> surface;  ///< per surface: edge of the leaves it passes through; empty: none
    std::vector<double> region;   ///< per region (number - 1): edge of leaves in it or on its boundary
    std::vector<Source> sources;
    /// Edge of a leaf anywhere, as a function of place: a register program (kernels/shared/expression.h) in
    /// model coordinates and units; empty: no wish. A leaf meets its smallest value in the leaf, by interval
    /// bounds.
    std::vector<ExpressionOp> formula;
    Box3 within{};  ///< where the solid lies, in model coordinates: the formula is asked nowhere else
    /// Leaves where a surface of each group meets those of the others.
    struct Meeting {
        std::vector<std::vector<std::uint32_t>> groups;  ///< two or three, surfaces ascending
        double size;
    };
    std::vector<Meeting> meetings;
    /// Leaves between surfaces `a` and surfaces `b`: an edge of at most half of their distance there, but not
    /// below `least`.
    struct Gap {
        std::vector<std::uint32_t> a, b;
        double least;
    };
    std::vector<Gap> gaps;
    double curvature_elements = 0;  ///< leaves per full turn of a curved surface; 0: no wish
    /// Edge of the finest leaf that the caller makes, 0: not told. Features thinner than half of it are not
    /// worth a split.
    double finest = 0;
    bool features = false;  ///< split where the solid is not simple in a leaf (topology.hpp)
};

/// The sizes that the model itself asks for.
SizeField size_field(const tape::BoundModel& model);

/// Decides what to split. Pure: any thread may ask. The model must outlive it.
class Sizer {
  public:
    Sizer(const tape::BoundModel& model, const SizeField& field);

    /// which[i] = 1 if undecided node i of `level` must be split: its edge is above a wish somewhere in its
    /// closed cube, a surface turns too much in it, the solid is not simple in it, or its tape still holds an
    /// undivided polyhedron. The same for any number of threads (0: all cores).
    std::vector<std::uint8_t> split_undecided(const std::vector<TreeNode>& nodes,
                                              const std::vector<std::uint32_t>& tapes, int level,
                                              int threads) const;

    /// Largest edge of an IN leaf of `region` (1, 2, …) in the cube with this Morton code and level.
    double in_size(std::uint64_t morton, int level, std::uint16_t region) const;

    /// Whether an IN node must be split.
    bool splits_in(std::uint64_t morton, int level, std::uint16_t region) const;

    /// The smallest size that any leaf of the root cube may have to meet; 0 if a formula may get that small.
    double smallest() const;

  private:
    double size_in(const tape::Cell& cell) const;
    bool is_too_large(const std::uint32_t* words, std::size_t length, const tape::Cell& cell) const;

    const tape::BoundModel& model_;
    SizeField field_;
};

/// The cube with this Morton code and level.
tape::Cell cell_of(std::uint64_t morton, int level);

}  // namespace mortise::sizing
