#include "host/io/periodic_groups.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace mortise::io {
namespace {

/// Corners in ascending order; a triangle ends with kNoOriginal.
using Key = std::array<NodeId, 4>;

template <class Map>
Key key_of(const FacetNodes& corners, const Map& map) {
    Key key;
    key.fill(kNoOriginal);
    for (std::size_t k = 0; k < corners.size(); ++k) key[k] = map(corners[k]);
    std::sort(key.begin(), key.end());
    return key;
}

/// What the facets of a group are copies of.
struct Images {
    std::uint32_t group = kNoGroup;  ///< the one group of all of them
    bool differ = false;             ///< there is no such group
};

}  // namespace

std::vector<NodeId> originals_of(const PeriodicNodes& pair, std::size_t nodes) {
    std::vector<NodeId> original(nodes, kNoOriginal);
    for (std::size_t i = 0; i < pair.size(); ++i) original[pair.node[i]] = pair.original[i];
    return original;
}

std::vector<PeriodicGroups> periodic_groups(const Mesh& mesh, const std::vector<std::uint32_t>& group_of) {
    const FacetBlock& facets = mesh.facets;
    std::vector<std::size_t> size;
    for (const std::uint32_t group : group_of) {
        if (group == kNoGroup) continue;
        size.resize(std::max<std::size_t>(size.size(), std::size_t{group} + 1));
        ++size[group];
    }
    std::vector<PeriodicGroups> result;
    for (std::size_t pair = 0; pair < mesh.periodic.size(); ++pair) {
        const std::vector<NodeId> original = originals_of(mesh.periodic[pair], mesh.node_count());
        std::vector<std::uint8_t> is_original(mesh.node_count(), 0);
        for (const NodeId node : mesh.periodic[pair].original) is_original[node] = 1;
        std::vector<std::pair<Key, std::uint32_t>> known;  // facets whose corners are all originals
        for (std::size_t f = 0; f < facets.size(); ++f) {
            const FacetNodes corners = facets.facet(f);
            if (group_of[f] != kNoGroup && std::all_of(corners.begin(), corners.end(),
                                                       [&](NodeId node) { return is_original[node] != 0; }))
                known.emplace_back(key_of(corners, [](NodeId node) { return node; }), group_of[f]);
        }
        std::sort(known.begin(), known.end());
        std::map<std::uint32_t, Images> images;
        std::vector<std::uint8_t> stays(size.size(), 0);  // per group: some facet is not a copy
        for (std::size_t f = 0; f < facets.size(); ++f) {
            if (group_of[f] == kNoGroup) continue;
            const Key key = key_of(facets.facet(f), [&](NodeId node) { return original[node]; });
            const auto found = std::lower_bound(known.begin(), known.end(), std::make_pair(key, 0u));
            if (found == known.end() || found->first != key) {
                stays[group_of[f]] = 1;
                continue;
            }
            Images& seen = images[group_of[f]];
            seen.differ = seen.differ || (seen.group != kNoGroup && seen.group != found->second);
            seen.group = found->second;
        }
        for (const auto& [group, seen] : images) {
            if (!seen.differ && stays[group] == 0 && size[group] == size[seen.group])
                result.push_back({pair, group, seen.group});
        }
    }
    return result;
}

}  // namespace mortise::io
