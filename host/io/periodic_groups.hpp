// Groups of facets that are copies of others (Mesh::periodic), as formats with periodic surfaces want them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::io {

/// Each facet of group `copy` is one of group `original`, moved by the shift of Mesh::periodic[pair].
struct PeriodicGroups {
    std::size_t pair = 0;
    std::uint32_t copy = 0;
    std::uint32_t original = 0;
};

/// The groups of equal size that are copies, by pair, then by group. `group_of`: per facet; kNoGroup: none.
inline constexpr std::uint32_t kNoGroup = 0xffffffffu;
std::vector<PeriodicGroups> periodic_groups(const Mesh& mesh, const std::vector<std::uint32_t>& group_of);

/// Per node its original in a pair, or kNoOriginal.
inline constexpr NodeId kNoOriginal = 0xffffffffu;
std::vector<NodeId> originals_of(const PeriodicNodes& pair, std::size_t nodes);

}  // namespace mortise::io
