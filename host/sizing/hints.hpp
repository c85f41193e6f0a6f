// Sizes asked for where certain surfaces meet, and between them (SizeHint of the model).
#pragma once

#include <cstdint>
#include <vector>

#include "host/sizing/sizing.hpp"

namespace mortise::sizing {

/// Whether one of `some` is in `list`; both ascending.
bool holds_one(const std::vector<std::uint32_t>& list, const std::vector<std::uint32_t>& some);

/// Whether surfaces of all groups that are among `here` meet in the cell or close beside it.
bool meet_in(const tape::BoundModel& model, const SizeField::Meeting& meeting,
             const std::vector<std::uint32_t>& here, const tape::Cell& cell);

/// The edge that the gap asks of the cell: half of the smallest distance between two of its surfaces that the
/// cell touches or lies between, or the least; infinity if there are none.
double gap_size(const tape::BoundModel& model, const SizeField::Gap& gap, const tape::Cell& cell);

/// Distance of two surfaces if both are planes and parallel, else 0.
double distance_of_planes(const tape::BoundModel& model, std::uint32_t a, std::uint32_t b);

}  // namespace mortise::sizing
