// Corners of the solid itself, found without a mesh.
//
// Candidates in a leaf: common zeros of three surfaces, isolated points where two surfaces touch (the poles
// of two crossing cylinders), apexes of cones. A candidate's surfaces are reduced to those whose flip changes
// the region somewhere near the point; a corner is left if three of these meet in a point, if both touching
// surfaces are left, or the apex's.
#pragma once

#include "host/report/leaves.hpp"

namespace mortise::report {

struct Corner {
    Vector local;                         ///< box-local
    std::vector<std::uint32_t> surfaces;  ///< bound surfaces that meet here, ascending
};

/// Appends the corners inside the closed leaf.
void find_corners(const tape::BoundModel& model, const Leaf& leaf, std::vector<Corner>& corners);

/// Sorts corners by place and makes those that coincide one.
void merge_corners(std::vector<Corner>& corners);

}  // namespace mortise::report
