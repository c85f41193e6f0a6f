#include "host/io/periodic_links.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "host/common/periodic_originals.hpp"

namespace mortise::io {
namespace {

/// Corners in ascending order; a triangle ends with kNoOriginal.
using CornerKey = std::array<NodeId, 4>;

template <class Map>
CornerKey corner_key(const FacetNodes& corners, const Map& map) {
    CornerKey key;
    key.fill(kNoOriginal);
    for (std::size_t k = 0; k < corners.size(); ++k) key[k] = map(corners[k]);
    std::sort(key.begin(), key.end());
    return key;
}

/// What the facets of a group are copies of.
struct Images {
    std::uint32_t group = kNoGroup;     ///< of the first of them
    bool is_whole = true;               ///< every facet has an image, and all of these are in `group`
    std::vector<std::uint32_t> facets;  ///< the images
};

/// The links of one pair; `size`: facets, by group.
void add_links(const Mesh& mesh, const std::vector<std::uint32_t>& group_of,
               const std::vector<std::size_t>& size, std::size_t pair, std::vector<PeriodicLink>& links) {
    const FacetBlock& facets = mesh.facets;
    const std::vector<NodeId> original = originals_of(mesh.periodic[pair], mesh.node_count());
    std::vector<std::uint8_t> is_original(mesh.node_count(), 0);
    for (const NodeId node : mesh.periodic[pair].original) is_original[node] = 1;
    const auto all = [&](std::size_t f, const auto& is) {
        const FacetNodes corners = facets.facet(f);
        return group_of[f] != kNoGroup && std::all_of(corners.begin(), corners.end(), is);
    };
    std::vector<std::pair<CornerKey, std::uint32_t>> known;  // facets whose corners are all originals
    for (std::uint32_t f = 0; f < facets.size(); ++f) {
        if (all(f, [&](NodeId node) { return is_original[node] != 0; }))
            known.emplace_back(corner_key(facets.facet(f), [](NodeId node) { return node; }), f);
    }
    std::sort(known.begin(), known.end());
    std::map<std::uint32_t, Images> images;
    std::vector<std::uint8_t> has_others(size.size(), 0);  // by group: a facet that is no copy
    for (std::size_t f = 0; f < facets.size(); ++f) {
        if (group_of[f] == kNoGroup) continue;
        if (!all(f, [&](NodeId node) { return original[node] != kNoOriginal; })) {
            has_others[group_of[f]] = 1;
            continue;
        }
        const CornerKey key = corner_key(facets.facet(f), [&](NodeId node) { return original[node]; });
        const auto found = std::lower_bound(known.begin(), known.end(), std::make_pair(key, 0u));
        Images& seen = images[group_of[f]];
        if (found == known.end() || found->first != key) {
            seen.is_whole = false;
            continue;
        }
        const std::uint32_t group = group_of[found->second];
        if (seen.group == kNoGroup) seen.group = group;
        seen.is_whole = seen.is_whole && seen.group == group;
        seen.facets.push_back(found->second);
    }
    for (auto& [group, seen] : images) {
        std::sort(seen.facets.begin(), seen.facets.end());
        const bool once = std::adjacent_find(seen.facets.begin(), seen.facets.end()) == seen.facets.end();
        if (seen.is_whole && once && has_others[group] == 0 && group != seen.group &&
            size[group] == size[seen.group])
            links.push_back({pair, group, seen.group});
    }
}

}  // namespace

std::vector<PeriodicLink> periodic_links(const Mesh& mesh, const std::vector<std::uint32_t>& group_of) {
    std::vector<std::size_t> size;
    for (const std::uint32_t group : group_of) {
        if (group == kNoGroup) continue;
        size.resize(std::max<std::size_t>(size.size(), std::size_t{group} + 1));
        ++size[group];
    }
    std::vector<PeriodicLink> links;
    for (std::size_t pair = 0; pair < mesh.periodic.size(); ++pair)
        add_links(mesh, group_of, size, pair, links);
    return links;
}

}  // namespace mortise::io
