#include "host/layers/layers.hpp"

#include <algorithm>
#include <limits>

#include "host/layers/band.hpp"
#include "host/layers/fit.hpp"
#include "host/layers/growth.hpp"
#include "host/layers/insert.hpp"
#include "host/layers/slides.hpp"
#include "host/layers/walls.hpp"
#include "mortise/error.hpp"

namespace mortise::layers {
namespace {

/// Names of the outer boundary's surfaces that are walls.
std::vector<std::string> wall_names(const Mesh& mesh, const Walls& walls) {
    std::vector<std::uint8_t> is_wall(mesh.surface_names.size(), 0);
    for (const WallFacet& facet : walls.facets) {
        if (mesh.facets.outside[facet.facet] == 0) is_wall[mesh.facets.surface[facet.facet]] = 1;
    }
    std::vector<std::string> names;
    for (std::size_t s = 0; s < is_wall.size(); ++s) {
        if (is_wall[s] != 0) names.push_back(mesh.surface_names[s]);
    }
    return names;
}

LayerFigures count(const Mesh& mesh, const Walls& walls, const Growth& growth, const Fit& fit) {
    constexpr double kAll = 1 - 1e-9;
    LayerFigures figures;
    figures.facets = walls.facets.size();
    figures.surfaces = wall_names(mesh, walls);
    figures.unused = walls.unused;
    const auto height = [&](std::size_t place) { return fit.share[place] * growth.height[place]; };
    for (const WallFacet& facet : walls.facets) {
        std::size_t bare = 0, lower = 0;
        for (const NodeId node : facet.node) {
            const std::size_t place = walls.place[node];
            bare += fit.share[place] == 0;
            lower += height(place) < kAll * growth.asked[place];
        }
        if (bare == facet.node.size()) {
            if (figures.bare++ == 0) figures.first_bare = point_of(mesh, facet.node[0]);
        } else if (lower > 0) {
            ++figures.lower;
        }
    }
    const auto count = static_cast<double>(walls.nodes.size());
    std::size_t covered = 0;
    for (std::size_t i = 0; i < walls.nodes.size(); ++i) {
        figures.asked += growth.asked[i] / count;
        figures.edge += growth.edges[i] / count;
        figures.thickness += height(i);
        covered += fit.share[i] > 0;
    }
    if (covered > 0) figures.thickness /= static_cast<double>(covered);
    return figures;
}

}  // namespace

LayerFigures add_layers(Mesh& mesh, std::vector<std::uint32_t>& facet_surface, const tape::BoundModel& model,
                        const LayerOptions& options, int threads) {
    const Heights heights = {options.count, options.first, options.growth};
    Walls walls = find_walls(mesh, options.on, threads);
    if (walls.facets.empty()) {
        LayerFigures figures;
        figures.unused = walls.unused;
        return figures;
    }
    const std::uint64_t nodes =
        mesh.node_count() + walls.nodes.size() * static_cast<std::uint64_t>(options.count);
    if (nodes > std::numeric_limits<NodeId>::max() / 2)
        throw Error(ExitCode::kMeshing,
                    "layers make " + std::to_string(nodes) +
                        " nodes, more than a mesh can number; use larger cells or fewer layers");
    const Slides slides(mesh, walls, facet_surface, model, threads);
    const Growth growth = find_growth(mesh, slides, heights, threads, walls);
    const Band band = find_band(mesh, walls, rings_for(growth), threads);
    const Fit fit = fit_layers(mesh, walls, band, slides, growth, heights, threads);
    LayerFigures figures = count(mesh, walls, growth, fit);
    insert_layers(walls, band, heights, fit, threads, mesh, facet_surface);
    for (const ElementBlock& block : mesh.elements)
        figures.elements += static_cast<std::uint64_t>(
            std::count(block.kind.begin(), block.kind.end(), static_cast<std::uint8_t>(ElementKind::kLayer)));
    return figures;
}

}  // namespace mortise::layers
