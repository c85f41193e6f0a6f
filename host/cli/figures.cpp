#include "host/cli/figures.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/parallel.hpp"

namespace mortise::cli {

void MeshFigures::add_outline(const Mesh& mesh) {
    regions = mesh.region_names;
    in_region.resize(regions.size());
    surfaces = mesh.surface_names;
    on_surface.resize(surfaces.size());
    for (const std::uint32_t surface : mesh.facets.surface) ++on_surface[surface];
    for (const PeriodicNodes& pair : mesh.periodic) periodic.push_back({pair.shift, pair.size()});
}

void MeshFigures::add_elements(const Mesh& mesh, const std::vector<float>& jacobians, int threads) {
    struct Part {
        float worst = 1;
        std::array<std::uint64_t, 5> kinds{};
        std::vector<std::uint64_t> in_region;
    };
    constexpr std::size_t kChunk = std::size_t{1} << 17;
    nodes += mesh.node_count();
    std::size_t first = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        std::vector<Part> parts(chunk_count(block.size(), kChunk));
        parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            Part part;
            part.in_region.resize(in_region.size());
            for (std::size_t i = begin; i < end; ++i) {
                part.worst = std::min(part.worst, jacobians[first + i]);
                if (block.kind[i] < part.kinds.size()) ++part.kinds[block.kind[i]];
                ++part.in_region[block.region[i] - 1u];
            }
            parts[begin / kChunk] = std::move(part);
        });
        for (const Part& part : parts) {
            min_scaled_jacobian[t] = std::min(min_scaled_jacobian[t], static_cast<double>(part.worst));
            for (std::size_t k = 0; k < kinds.size(); ++k) kinds[k] += part.kinds[k];
            for (std::size_t r = 0; r < in_region.size(); ++r) in_region[r] += part.in_region[r];
        }
        elements[t] += block.size();
        first += block.size();
    }
}

namespace {

/// The first of the worst; `worst`: its scaled Jacobian.
Vec3 worst_place(const Mesh& mesh, const std::vector<float>& jacobians, double worst) {
    const auto found = std::find_if(jacobians.begin(), jacobians.end(),
                                    [worst](float value) { return !(static_cast<double>(value) > worst); });
    if (found == jacobians.end()) return worst_place(mesh, jacobians, HUGE_VAL);  // rounded up from 1
    auto index = static_cast<std::size_t>(found - jacobians.begin());
    std::size_t type = 0;
    while (index >= mesh.elements[type].size()) index -= mesh.elements[type++].size();
    const auto count = static_cast<std::size_t>(kElementNodes[type]);
    Vec3 place{};
    for (std::size_t k = 0; k < count; ++k) {
        const NodeId node = mesh.elements[type].nodes[count * index + k];
        for (std::size_t j = 0; j < 3; ++j)
            place[j] += mesh.points[3 * node + j] / static_cast<double>(count);
    }
    return place;
}

}  // namespace

MeshFigures figures_of(const Mesh& mesh, const std::vector<float>& jacobians, int threads) {
    MeshFigures figures;
    figures.add_outline(mesh);
    figures.add_elements(mesh, jacobians, threads);
    if (!jacobians.empty()) {
        const auto& least = figures.min_scaled_jacobian;
        figures.worst_place = worst_place(mesh, jacobians, *std::min_element(least.begin(), least.end()));
    }
    return figures;
}

}  // namespace mortise::cli
