// Groups of facets that are copies of others (Mesh::periodic), as formats with periodic surfaces want them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::io {

/// Each facet of group `copy` is one of group `original`, moved by the shift of Mesh::periodic[pair].
struct PeriodicLink {
    std::size_t pair = 0;
    std::uint32_t copy = 0;
    std::uint32_t original = 0;
};

/// All groups whose facets are the copies of all facets of another, by pair, then by group. `group_of`: per
/// facet; kNoGroup: none.
inline constexpr std::uint32_t kNoGroup = 0xffffffffu;
std::vector<PeriodicLink> periodic_links(const Mesh& mesh, const std::vector<std::uint32_t>& group_of);

}  // namespace mortise::io
