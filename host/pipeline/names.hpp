// Names of surfaces, from the model to the mesh.
#pragma once

#include <string>
#include <vector>

#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::pipeline {

/// Facets carry bound surfaces; the mesh lists names, each once and only those in use. Where equal surfaces
/// of several names are one, a facet has the name of the first whose solid it lies on, of the solids of its
/// region (`inside`) if these have one there.
void name_surfaces(const tape::CompiledModel& compiled, const tape::BoundModel& model, int threads,
                   Mesh& mesh);

/// Error(kUsage): no region or surface of the model has this name.
[[noreturn]] void refuse_name(const std::string& name, const tape::CompiledModel& compiled);

/// Refuses names that are neither of a region nor of a surface.
void check_names(const std::vector<std::string>& names, const tape::CompiledModel& compiled);

}  // namespace mortise::pipeline
