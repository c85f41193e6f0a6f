// check_mesh and scaled_jacobians: runs the passes and puts the report together.
//
// Nothing here, or in any file of this folder, uses code of the stages that make meshes.
#include "mortise/check.hpp"

#include <algorithm>

#include "host/common/parallel.hpp"
#include "host/quality/passes.hpp"
#include "host/quality/shape.hpp"

namespace mortise {

CheckReport check_mesh(const Mesh& mesh, int threads) {
    CheckReport report;
    report.nodes = mesh.node_count();
    for (std::size_t t = 0; t < kElementTypes; ++t) report.elements[t] = mesh.elements[t].size();
    report.min_scaled_jacobian.fill(1);
    report.region_volume.assign(mesh.region_names.size(), 0.0);
    quality::DefectLog log;
    if (quality::check_structure(mesh, threads, log)) {
        quality::check_nodes(mesh, threads, log);
        quality::check_elements(mesh, threads, log, report);
        const std::vector<quality::EdgeMiddle> middles = quality::check_middles(mesh, threads, log);
        report.middle_nodes = middles.size();
        const std::vector<HangingFace> hanging = quality::check_hanging(mesh, log);
        const std::vector<quality::BoundaryFacet> boundary =
            quality::check_facets(mesh, hanging, threads, log, report);
        quality::check_boundary(mesh, boundary, middles, log, report);
        quality::check_hinges(mesh, boundary, report);
    }
    report.defects = log.defects();
    return report;
}

std::vector<float> scaled_jacobians(const Mesh& mesh, int threads) {
    constexpr std::size_t kChunk = 16384;
    quality::require_elements(mesh);
    std::vector<float> values(mesh.element_count());
    std::size_t first = 0;
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementType type = static_cast<ElementType>(t);
        const std::size_t count = mesh.block(type).size();
        parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                const quality::Corners corners = quality::corners_of(mesh, type, i);
                values[first + i] = static_cast<float>(quality::scaled_jacobian(type, corners));
            }
        });
        first += count;
    }
    return values;
}

}  // namespace mortise
