#include <cmath>

#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise {

ModelSummary summarize(const Model& model) {
    check_model(model);
    const tape::CompiledModel compiled = tape::compile(model);
    ModelSummary summary;
    summary.surfaces = compiled.surface_names;
    summary.surface_size.assign(compiled.surface_names.size(), 0);
    for (std::size_t s = 0; s < compiled.surfaces.size(); ++s) {
        const double wanted = compiled.surface_size[s];
        double& size = summary.surface_size[compiled.surfaces[s].name];
        if (std::isfinite(wanted) && (size == 0 || wanted < size)) size = wanted;
    }
    try {
        summary.bounds = tape::find_bounds(model, compiled);
    } catch (const Error& error) {
        summary.unbounded = error.what();
    }
    return summary;
}

}  // namespace mortise
