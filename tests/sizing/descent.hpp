// A slow descent on the host that asks the sizer, for its tests.
#pragma once

#include <cstdint>
#include <vector>

#include "host/sizing/sizing.hpp"
#include "mortise/model.hpp"

namespace mortise::test {

/// Undecided nodes of one level in the form that the sizer takes.
struct Nodes {
    int level = 0;
    std::vector<TreeNode> nodes;
    std::vector<std::uint32_t> tapes;
};

/// All undecided nodes of a level.
Nodes nodes_at(const tape::BoundModel& model, int level);

/// The undecided children of the nodes that `which` marks.
Nodes children_of(const tape::BoundModel& model, const Nodes& parents,
                  const std::vector<std::uint8_t>& which);

/// How many nodes are split at `level` and each following one, by features alone, until none is or after
/// `levels` of them.
std::vector<std::size_t> feature_splits(const tape::BoundModel& model, int level, int levels = 6);

std::size_t count_split(const std::vector<std::uint8_t>& which);

}  // namespace mortise::test
