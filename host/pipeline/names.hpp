// Names of surfaces, from the model to the mesh.
#pragma once

#include <algorithm>
#include <utility>

#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::pipeline {

/// The name of a surface where it bounds a region: that of the region's own solid, if there are several.
inline std::uint32_t name_in(const tape::BoundModel& model, std::uint32_t surface, std::int32_t region) {
    const auto& names = model.names_by_region;
    const auto found = std::lower_bound(names.begin(), names.end(), std::make_pair(surface, region),
                                        [](const tape::RegionSurfaceName& name, const auto& wanted) {
                                            return std::make_pair(name.surface, name.region) < wanted;
                                        });
    const bool is_own = found != names.end() && found->surface == surface && found->region == region;
    return is_own ? found->name : model.surface_name[surface];
}

/// Facets carry bound surfaces; the mesh lists names, each once and only those in use.
inline void name_surfaces(const tape::CompiledModel& compiled, const tape::BoundModel& model, Mesh& mesh) {
    std::vector<std::uint32_t> place(compiled.surface_names.size(), 0xffffffffu);
    std::vector<bool> present(compiled.surface_names.size(), false);
    for (std::size_t f = 0; f < mesh.facets.surface.size(); ++f) {
        std::uint32_t& name = mesh.facets.surface[f];
        name = name_in(model, name, mesh.facets.inside[f]);
        present[name] = true;
    }
    for (std::size_t i = 0; i < present.size(); ++i) {
        if (!present[i]) continue;
        place[i] = static_cast<std::uint32_t>(mesh.surface_names.size());
        mesh.surface_names.push_back(compiled.surface_names[i]);
    }
    for (std::uint32_t& name : mesh.facets.surface) name = place[name];
}

}  // namespace mortise::pipeline
