// Whether the solid is so simple in a node that one cell can show it.
//
// Only surfaces count that pass through the node and bound the solid there. Simple are, by increasing number
// of them:
//   one surface    whose normals are less than 90° apart (Plantinga & Vegter 2004);
//   one sheet      surfaces that bound the same region on the same side, with normals within 25°: whatever
//                  Boolean combination they are in, it is a graph over one plane (facets, tangent blends);
//   a crease       two surfaces that meet within an edge of the node, two edges if the crease is sharp and
//                  really there: splitting never ends at a sharp crease;
//   a corner       three or more that meet in one point within an edge of the node.
// All else (sheets side by side, several creases, hidden features, closed surfaces) must be split.
#pragma once

#include <cstdint>
#include <vector>

#include "host/sizing/arrangement.hpp"
#include "host/sizing/sheets.hpp"
#include "host/sizing/signs.hpp"

namespace mortise::sizing {

/// Looks at one node after the other; keeps its scratch memory. One per thread.
class Topology {
  public:
    /// Sheets closer than half of `finest`, the edge of the finest leaf to come, cannot be told apart by any
    /// split: they count as touching.
    Topology(const tape::BoundModel& model, double finest);

    /// Finds the sheets that count. Then ask the others.
    void load(const std::uint32_t* words, std::size_t length, const tape::Cell& cell);
    bool is_simple();
    /// Those that count; the region in the node is a function of their signs.
    const std::vector<Sheet>& sheets() const { return sheets_; }
    /// Whether two surfaces have a crease, or touch, within two edges of a cell.
    bool meet_near(std::uint32_t a, std::uint32_t b, const tape::Cell& cell);
    /// Largest angle by which a surface's normal turns along an edge's length.
    double turn() const;

  private:
    enum class Meeting : std::uint8_t { kNone, kBeyond, kInside };

    void keep_bounding(const std::uint32_t* words, std::size_t length);
    void orient_by_tape(const std::uint32_t* words, std::size_t length);
    bool is_one_sheet() const;
    void merge_sheets();
    bool groups_meet();
    bool is_same_sheet(const Sheet& a, const Sheet& b);
    bool is_apex(const Sheet& cone) const;
    Meeting meet(const std::vector<const Sheet*>& sheets, double edges, Vec3& at) const;
    bool bound_solid(const std::vector<const Sheet*>& sheets, const Vec3& at);
    Vec3 outward(const Sheet& sheet) const;

    double touching() const;
    double bend(const Sheet& sheet) const;

    const tape::BoundModel& model_;
    double finest_;
    SheetFinder finder_;
    PossibleSigns possible_;
    Arrangement arrangement_;
    Arrangement at_point_;
    tape::Cell cell_{};
    bool one_region_ = true;
    std::vector<Sheet> sheets_;
    std::vector<std::vector<const Sheet*>> groups_;  ///< parts of one smooth sheet each
    std::vector<const Sheet*> chosen_;               ///< one of each group, by surface
    std::vector<std::uint32_t> root_surfaces_;       ///< of the whole tape, ascending
    std::vector<std::int8_t> root_signs_;
    std::vector<std::size_t> asked_;
    std::vector<std::uint32_t> all_choices_;
    bool root_is_spatial_ = false;
    std::vector<bool> of_polyhedron_;  ///< per surface: outward by construction
};

}  // namespace mortise::sizing
