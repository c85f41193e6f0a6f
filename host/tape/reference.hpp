// Host reference of the device's cell classification: scalar, in double precision, without pruned tapes'
// tricks.
//
// Used to find the bounds of a model before there is a tree, and as the oracle of kernels/octree/descend.cl.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Half-open cube of box-local space: centre and half edge length.
struct Cell {
    double centre[3];
    double half;
};

/// Sign of a surface over the closed cell: -1 inside, +1 outside everywhere, 0 undecided. Conservative.
int classify_surface(const BoundModel& model, std::uint32_t surface, const Cell& cell);

/// Region of the closed cell, or kUnknown; `pruned` receives the tape of what is unknown (may be null). The
/// tape must be that of the cell's parent, or of the root for the root.
std::int32_t classify_cell(const BoundModel& model, const std::vector<std::uint32_t>& tape, const Cell& cell,
                           std::vector<std::uint32_t>* pruned);

/// Region at a point: signs by surface_value alone, zero counts as inside.
std::int32_t region_at(const BoundModel& model, double x, double y, double z);

/// Value of a tape when surface surfaces[i] (ascending) has sign signs[i]: -1, 0 (unknown) or +1. Literals of
/// surfaces that are not listed are unknown.
std::int32_t evaluate_signs(const std::uint32_t* tape, std::size_t length, const std::uint32_t* surfaces,
                            std::size_t surface_count, const std::int8_t* signs);

/// The same, by cases: known also if every choice of the unknown signs gives one value (up to eight of them
/// are tried). Three-valued logic alone does not see that p ∨ ¬p holds.
std::int32_t resolve_signs(const std::uint32_t* tape, std::size_t length, const std::uint32_t* surfaces,
                           std::size_t surface_count, const std::int8_t* signs);

/// Simplifies a tape for known states of its literals: states[i] belongs to word i (0, 1 or kUnknown).
/// Returns the value if it is known.
std::int32_t prune(const std::vector<std::uint32_t>& tape, const std::vector<std::int32_t>& states,
                   std::vector<std::uint32_t>* pruned);

}  // namespace mortise::tape
