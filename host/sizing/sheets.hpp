// The surfaces of a node's tape that pass through the node, with what tells how they lie there.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/common/vec3.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"

namespace mortise::sizing {

/// One smooth surface in a node.
struct Sheet {
    static constexpr std::size_t kSamples = 9;  ///< the node's corners, a little drawn in, and its centre
    std::uint32_t surface = 0;                  ///< index into BoundModel::surfaces
    bool flat = false;                          ///< a plane
    /// No two normals in the node are 90° or more apart: the surface is a graph there (variation.hpp).
    bool steady = false;
    bool has_apex = false;                    ///< its singular point is in the node or within two edges of it
    Vec3 apex{};                              ///< if has_apex
    Vec3 foot{};                              ///< point of the surface next to the centre
    Vec3 normal{};                            ///< unit gradient there
    std::array<double, kSamples> distance{};  ///< signed, to first order near the surface
    int orientation = 0;  ///< +1: the solid is where f < 0, -1: where f > 0, 0: both, or not known
};

/// Finds the sheets of one node after the other; keeps its scratch memory.
class SheetFinder {
  public:
    explicit SheetFinder(const tape::BoundModel& model) : model_(model) {}

    /// Fills sheets() and signs(). `closely`: also what lies near the node's boundary.
    void run(const std::uint32_t* words, std::size_t length, const tape::Cell& cell, bool closely = false);

    /// By surface, ascending. A surface that touches only the node's boundary is none, unless it is parallel
    /// to a sheet inside.
    std::vector<Sheet>& sheets() { return sheets_; }
    /// The node, a little larger if some sheets are on its boundary.
    tape::Cell seen(const tape::Cell& cell) const;
    /// All surfaces of the tape, ascending; signs of those that are no sheet, 0 for sheets.
    const std::vector<std::uint32_t>& surfaces() const { return surfaces_; }
    const std::vector<std::int8_t>& signs() const { return signs_; }

  private:
    void find_inside(const tape::Cell& cell, double factor);
    void add_touching(const tape::Cell& cell);
    bool make_sheet(std::uint32_t surface, const tape::Cell& cell, Sheet& sheet, double& at_centre) const;
    bool make_patch(const tape::Cell& cell, Sheet& sheet, double& at_centre) const;
    bool passes(std::uint32_t surface, const tape::Cell& cell, int depth) const;
    bool looks_steady(std::uint32_t surface, const tape::Cell& cell) const;
    bool is_far(std::uint32_t surface, const tape::Cell& cell) const;

    const tape::BoundModel& model_;
    std::vector<Sheet> sheets_;
    std::vector<std::uint32_t> surfaces_;
    std::vector<std::int8_t> signs_;
    bool touches_ = false;
};

/// Sample point of a cell: a corner drawn in, or the centre.
Vec3 sample_point(const tape::Cell& cell, std::size_t index);

struct Sampled {
    double value;
    Vec3 gradient;
    double slope;  ///< length of the gradient
};

/// Value and gradient at a point; where a formula's gradient is no number though its values are (√x² at 0),
/// by differences.
Sampled sample_at(const tape::BoundModel& model, std::uint32_t surface, const Vec3& x);

/// Newton's method along the gradient; false if it does not end on the surface. `reach`: longest step.
bool project(const tape::BoundModel& model, std::uint32_t surface, double reach, Vec3& x, Vec3& unit_normal,
             double& slope);

/// Whether a point lies in the cell, whose half edge is stretched by a factor.
bool is_within(const Vec3& x, const tape::Cell& cell, double factor);

}  // namespace mortise::sizing
