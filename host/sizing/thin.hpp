// Walls and gaps that a grid plane cuts: each node sees one of their sheets only.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/sizing/sheets.hpp"
#include "kernels/shared/bounds.h"

namespace mortise::sizing {

/// What the nodes around one need of its sheets.
struct SheetTrace {
    std::uint32_t surface = 0;
    bool flat = false;
    int orientation = 0;  ///< as Sheet::orientation
    Vec3 foot{};
    Vec3 normal{};
};

/// Sheets of many nodes: those of node i are trace[begin[i]] to trace[begin[i + 1]].
struct SheetTraces {
    std::vector<std::uint32_t> begin = {0};
    std::vector<SheetTrace> trace;
};

/// Whether two surfaces meet near a cell, asked by a thread.
using MeetNear = std::function<bool(std::uint32_t a, std::uint32_t b, const tape::Cell& cell, int thread)>;

/// Sets which[i] for nodes that touch one another (26 places around) and hold sheets that face each other, or
/// turn their backs, closer than an edge and not closer than `least`; not those that meet beside the nodes.
/// `nodes` of one level in ascending order.
void mark_thin(const std::vector<TreeNode>& nodes, int level, const SheetTraces& sheets, double least,
               const MeetNear& meet, int threads, std::vector<std::uint8_t>& which);

}  // namespace mortise::sizing
