// Names of surfaces, from the model to the mesh.
#pragma once

#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::pipeline {

/// Facets carry bound surfaces; the mesh lists names, each once and only those in use.
inline void name_surfaces(const tape::CompiledModel& compiled, const tape::BoundModel& model, Mesh& mesh) {
    std::vector<std::uint32_t> place(compiled.surface_names.size(), 0xffffffffu);
    std::vector<bool> present(compiled.surface_names.size(), false);
    for (const std::uint32_t surface : mesh.facets.surface) present[model.surface_name[surface]] = true;
    for (std::size_t i = 0; i < present.size(); ++i) {
        if (!present[i]) continue;
        place[i] = static_cast<std::uint32_t>(mesh.surface_names.size());
        mesh.surface_names.push_back(compiled.surface_names[i]);
    }
    for (std::uint32_t& surface : mesh.facets.surface) surface = place[model.surface_name[surface]];
}

}  // namespace mortise::pipeline
