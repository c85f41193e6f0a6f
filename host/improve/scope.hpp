// For meshes that never lie in memory whole: which of their elements improvement needs, found part by part.
//
// Improving only these, in the order that they have in the whole mesh, gives what improving the whole mesh
// would give: all that decides is order and position. Uniform trees only.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/improve/cell_set.hpp"
#include "host/improve/zone.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::improve {

/// Elements of a mesh by type: their numbers, ascending.
using ElementNumbers = std::array<std::vector<std::uint32_t>, kElementTypes>;

class Scope {
  public:
    /// `goal` as Options::goal.
    Scope(const tape::BoundModel& model, const std::vector<tape::Pole>& poles, int level, double goal,
          int threads);

    /// Notes the cells of a part's poor elements. Positions must be there for all its nodes.
    void add_poor(const Mesh& part);

    /// The scope is all cells within `reach` cells of the noted ones, from now on.
    void spread(int reach);

    bool is_empty() const { return poor_.empty(); }

    /// Elements of the part that are in the scope.
    ElementNumbers select(const Mesh& part) const;

    /// False only if no element of the leaves with Morton codes in [begin, end) is in the scope.
    bool touches(std::uint64_t begin, std::uint64_t end) const;

  private:
    static constexpr int kBrickLevels = 3;

    CellFrame frame_;
    double goal_;
    int threads_;
    CellSet cells_;
    std::vector<CellId> poor_;  ///< ascending after spread()
    /// Morton codes, ascending, of bricks of 8³ cells that hold cells of the scope, or cells beside them.
    std::vector<std::uint64_t> bricks_;
};

}  // namespace mortise::improve
