// A mesh of unit cubes that fills a box, with the box as its bound model: no mesher involved.
#pragma once

#include <vector>

#include "host/features/features.hpp"
#include "host/report/report.hpp"
#include "host/tape/compile.hpp"
#include "tests/quality/sample_meshes.hpp"

namespace mortise::test {

struct HandMade {
    Mesh mesh;
    tape::BoundModel model;
    std::vector<std::uint32_t> facet_surface;  ///< bound surfaces

    Features features() const { return features::find_features(mesh, facet_surface, model); }
    QualityReport assess(int level) const {
        return report::assess(mesh, facet_surface, model, features(), {level, 10, 2});
    }
};

/// n³ cubes over [0, n]³, in a root cube with two cells of margin on each side. Surfaces are told by facet
/// normals.
inline HandMade cube_of_cubes(int n) {
    HandMade made;
    made.mesh = samples::grid(n, n, n, 1);
    Model model;
    const double size = n;
    const std::uint32_t box = model.add_primitive(mortise::box({0, 0, 0}, {size, size, size}), "cube");
    model.regions.push_back({"solid", box, 0, {}});
    const tape::CompiledModel compiled = tape::compile(model);
    made.model = tape::bind(compiled, {-2, -2, -2}, size + 4);
    made.mesh.surface_names = compiled.surface_names;
    for (std::size_t f = 0; f < made.mesh.facets.size(); ++f) {
        const NodeId* node = made.mesh.facets.nodes.data() + 4 * f;
        for (std::uint32_t s = 0; s < made.model.surfaces.size(); ++s) {
            const double* plane = made.model.surfaces[s].map;
            double worst = 0;
            for (int k = 0; k < 4; ++k) {
                const double* p = made.mesh.points.data() + 3 * std::size_t{node[k]};
                double value = plane[3];
                for (std::size_t j = 0; j < 3; ++j) value += plane[j] * ((p[j] + 2) / (size + 4));
                worst = std::max(worst, value < 0 ? -value : value);
            }
            if (worst > 1e-12) continue;
            made.mesh.facets.surface[f] = made.model.surface_name[s];
            made.facet_surface.push_back(s);
        }
    }
    return made;
}

}  // namespace mortise::test
