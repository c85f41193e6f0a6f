#include "host/layers/layers.hpp"

#include <algorithm>

#include "host/common/vec3.hpp"
#include "host/layers/band.hpp"
#include "host/layers/fit.hpp"
#include "host/layers/insert.hpp"
#include "host/layers/slides.hpp"
#include "host/layers/walls.hpp"

namespace mortise::layers {
namespace {

LayerFigures count(const Mesh& mesh, const Walls& walls, const Fit& fit) {
    LayerFigures figures;
    figures.facets = walls.facets.size();
    for (const WallFacet& facet : walls.facets) {
        const auto share = [&](NodeId node) { return fit.share[walls.place[node]]; };
        const auto is = [&](auto&& what) {
            return [&share, what](NodeId node) { return what(share(node)); };
        };
        if (std::all_of(facet.node.begin(), facet.node.end(), is([](double s) { return s == 0; }))) {
            if (figures.bare++ == 0) figures.first_bare = point_of(mesh, facet.node[0]);
        } else if (std::any_of(facet.node.begin(), facet.node.end(), is([](double s) { return s < 1; }))) {
            ++figures.lower;
        }
    }
    std::vector<std::uint8_t> is_wall(mesh.surface_names.size(), 0);
    for (const WallFacet& facet : walls.facets) {
        if (mesh.facets.outside[facet.facet] == 0) is_wall[mesh.facets.surface[facet.facet]] = 1;
    }
    for (std::size_t s = 0; s < is_wall.size(); ++s) {
        if (is_wall[s] != 0) figures.surfaces.push_back(mesh.surface_names[s]);
    }
    std::size_t nodes = 0;
    for (std::size_t i = 0; i < walls.nodes.size(); ++i) {
        if (fit.share[i] == 0) continue;
        ++nodes;
        figures.thickness += length(difference(fit.inner[i], point_of(mesh, walls.nodes[i])));
    }
    if (nodes > 0) figures.thickness /= static_cast<double>(nodes);
    return figures;
}

}  // namespace

LayerFigures add_layers(Mesh& mesh, std::vector<std::uint32_t>& facet_surface, const tape::BoundModel& model,
                        const LayerOptions& options, int threads) {
    const Heights heights = {options.count, options.first, options.growth};
    Walls walls = find_walls(mesh, options.on, threads);
    if (walls.facets.empty()) return {};
    const Slides slides(mesh, walls, facet_surface, model, threads);
    const Growth growth = find_growth(mesh, slides, heights, threads, walls);
    const Band band = find_band(mesh, walls, rings_for(growth), threads);
    const Fit fit = fit_layers(mesh, walls, band, slides, growth, heights, threads);
    LayerFigures figures = count(mesh, walls, fit);
    insert_layers(walls, band, heights, fit, threads, mesh, facet_surface);
    for (const ElementBlock& block : mesh.elements)
        figures.elements += static_cast<std::uint64_t>(
            std::count(block.kind.begin(), block.kind.end(), static_cast<std::uint8_t>(ElementKind::kLayer)));
    return figures;
}

}  // namespace mortise::layers
