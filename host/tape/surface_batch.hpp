// A surface at many places at once: the same bits as one after the other, but a formula's operations are read
// once for all places, and what depends on one coordinate only is computed once for each plane of a grid.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"
#include "kernels/shared/surface.h"

namespace mortise::tape {

/// Equal cells of a cube.
struct Grid {
    double low[3];
    double edge;  ///< of a cell
    std::size_t side;

    double middle(std::size_t axis, std::size_t at) const {
        return low[axis] + (static_cast<double>(at) + 0.5) * edge;
    }
};
struct GridPlace {
    std::uint8_t at[3];
};

/// Middles of cells of a grid, or any points. Refers to what it is made of.
struct Places {
    Places(const Grid& of, const std::vector<GridPlace>& cells)
        : grid(&of), places(cells.data()), count(cells.size()) {}
    explicit Places(const std::vector<Vec3>& of) : points(of.data()), count(of.size()) {}

    Vec3 point(std::size_t k) const {
        if (grid == nullptr) return points[k];
        const std::uint8_t* at = places[k].at;
        return {grid->middle(0, at[0]), grid->middle(1, at[1]), grid->middle(2, at[2])};
    }

    const Grid* grid = nullptr;
    const GridPlace* places = nullptr;
    const Vec3* points = nullptr;
    std::size_t count;
};

/// Keeps its scratch memory. One per thread.
class SurfaceBatch {
  public:
    explicit SurfaceBatch(const BoundModel& model);
    ~SurfaceBatch();

    /// classify_surface in cells of a grid. `widths`, if any: what a bound of the rounding of surface_value
    /// in the cell is a millionth of.
    void classify(std::uint32_t surface, const Grid& grid, const std::vector<GridPlace>& cells,
                  std::vector<std::int8_t>& signs, std::vector<double>* widths = nullptr);
    /// Bounds of how far a surface's value in a cell may be from that in its middle, per length along all
    /// axes at once; infinite if unknown, as for all but formulas.
    void slopes(std::uint32_t surface, const Grid& grid, const std::vector<GridPlace>& cells,
                std::vector<double>& slopes);
    /// has_small_variation of a formula in cells of a size around points, by bounds that are sharper by some
    /// rounding.
    void find_steady(std::uint32_t surface, const std::vector<Vec3>& centres, double half,
                     std::vector<std::uint8_t>& steady);
    /// surface_value at each place.
    void values(std::uint32_t surface, const Places& places, std::vector<double>& values);
    /// surface_sample at each place.
    void samples(std::uint32_t surface, const Places& places, std::vector<SurfaceSample>& samples);

  private:
    struct Programs;

    const BoundModel& model_;
    std::unique_ptr<Programs> programs_;
};

}  // namespace mortise::tape
