#include "host/tape/hints.hpp"

#include <algorithm>

namespace mortise::tape {
namespace {

/// Surfaces of these primitives, wherever they are used, ascending.
std::vector<std::uint32_t> surfaces_of(std::vector<std::uint32_t> nodes,
                                       const std::vector<std::uint32_t>& surface_node) {
    std::sort(nodes.begin(), nodes.end());
    std::vector<std::uint32_t> found;
    for (std::uint32_t s = 0; s < surface_node.size(); ++s) {
        if (std::binary_search(nodes.begin(), nodes.end(), surface_node[s])) found.push_back(s);
    }
    return found;
}

}  // namespace

void find_hints(const Model& model, const std::vector<std::uint32_t>& surface_node, CompiledModel& compiled) {
    for (const SizeHint& hint : model.hints) {
        SurfaceHint own{hint.kind, hint.at, {}, hint.max_size};
        for (const auto& group : hint.groups) own.groups.push_back(surfaces_of(group, surface_node));
        compiled.hints.push_back(std::move(own));
    }
    const auto first_of = [&](const std::vector<std::uint32_t>& nodes) {
        const std::vector<std::uint32_t> surfaces = surfaces_of(nodes, surface_node);
        return surfaces.empty() ? PeriodicSurfaces::kNoSurface : surfaces[0];
    };
    for (const PeriodicPair& pair : model.periodic)
        compiled.periodic.push_back({first_of(pair.first), first_of(pair.second)});
}

}  // namespace mortise::tape
