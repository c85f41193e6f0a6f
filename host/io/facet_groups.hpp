// Facets by surface and regions, as formats with a surface entity for each want them.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::io {

/// Facets that a file shows as one surface.
struct FacetGroup {
    std::uint32_t surface = 0;
    std::uint16_t inside = 0;
    std::uint16_t outside = 0;
};

struct FacetGroups {
    std::vector<FacetGroup> groups;  ///< ascending by surface, inside, outside; none is empty
    std::vector<std::uint32_t> of;   ///< per facet: its group
};
FacetGroups group_facets(const FacetBlock& facets);

/// By group: the name of its surface, and where that has facets between several pairs of regions,
/// ":inside" or ":inside|outside" behind it.
std::vector<std::string> group_names(const Mesh& mesh, const std::vector<FacetGroup>& groups);

/// The name, or with the first number behind it that no name of `taken` has, which it joins.
std::string unique_name(const std::string& name, std::set<std::string>& taken);

}  // namespace mortise::io
