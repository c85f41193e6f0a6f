#include "tests/improve/raw_mesh.hpp"

#include <cmath>

#include "mortise/mesher.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {

RawMesh raw_mesh(const Model& model, int level) {
    MeshOptions options;
    options.level = level;
    options.improve = false;
    RawMesh raw{generate(model, options), bind_model(model, level), level};
    const std::vector<std::string> names = tape::compile(model).surface_names;
    for (std::size_t f = 0; f < raw.mesh.facets.size(); ++f) {
        const std::string& name = raw.mesh.surface_names[raw.mesh.facets.surface[f]];
        double nearest = HUGE_VAL;
        std::uint32_t best = 0;
        // Of the surfaces with this name the one that the facet lies on.
        for (std::uint32_t s = 0; s < raw.model.surfaces.size(); ++s) {
            if (names[raw.model.surface_name[s]] != name) continue;
            double off = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                double x[3];
                for (std::size_t j = 0; j < 3; ++j) {
                    const double p = raw.mesh.points[3 * raw.mesh.facets.nodes[4 * f + k] + j];
                    x[j] = (p - raw.model.origin[j]) / raw.model.side;
                }
                const SurfaceSample at =
                    surface_sample(&raw.model.surfaces[s], raw.model.expression_ops.data(), x[0], x[1], x[2]);
                off += std::fabs(at.value) / std::hypot(at.gradient[0], at.gradient[1], at.gradient[2]);
            }
            if (off >= nearest) continue;
            nearest = off;
            best = s;
        }
        raw.mesh.facets.surface[f] = best;
    }
    raw.mesh.surface_names.clear();
    for (std::size_t i = 0; i < raw.model.surfaces.size(); ++i)
        raw.mesh.surface_names.push_back("surface" + std::to_string(i));
    return raw;
}

}  // namespace mortise::test
