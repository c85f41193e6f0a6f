#include "host/layers/slides.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/projection.hpp"
#include "kernels/shared/surface.h"

namespace mortise::layers {
namespace {

constexpr std::size_t kMostSurfaces = 3;
constexpr double kTangent = 0.05;  ///< sine between gradients below which surfaces count as tangent

/// Of a move's length: how far the surface may lie from its end, and Newton's last step.
constexpr double kReach = 0.5, kSettled = 1e-9;
constexpr double kRounding = 0x1p-46;  ///< of a position, in edges of the root box

/// Nodes with their surfaces, each pair once.
std::vector<std::pair<NodeId, std::uint32_t>> list_surfaces(const Mesh& mesh, const Walls& walls,
                                                            const std::vector<std::uint32_t>& facet_surface) {
    std::vector<std::pair<NodeId, std::uint32_t>> list;
    for (std::size_t f = 0; f < facet_surface.size(); ++f) {
        if (walls.role[f] != FacetRole::kOpen && walls.role[f] != FacetRole::kInner) continue;
        for (std::size_t k = 0; k < 4; ++k) list.emplace_back(mesh.facets.nodes[4 * f + k], facet_surface[f]);
    }
    sort_unique(list);
    return list;
}

}  // namespace

Slides::Slides(const Mesh& mesh, const Walls& walls, const std::vector<std::uint32_t>& facet_surface,
               const tape::BoundModel& model, int threads)
    : mesh_(mesh), model_(model), nodes_(mesh.node_count()) {
    const auto list = list_surfaces(mesh, walls, facet_surface);
    for (const auto& pair : list) nodes_.insert(pair.first);
    nodes_.number();
    surfaces_ = SmallGroups(nodes_.size(), [&](const auto& found) {
        for (const auto& [node, surface] : list) found(nodes_.place(node), surface);
    });
    across_.resize(nodes_.size());
    const std::vector<std::uint32_t> members = nodes_.members();
    parallel_chunks(members.size(), kNodeChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) across_[i] = across_at(i, point_of(mesh_, members[i]));
    });
}

Vec3 Across::free_part(Vec3 move) const {
    for (std::size_t i = 0; i < count; ++i) move = difference(move, scaled(normal[i], dot(move, normal[i])));
    return move;
}

bool Across::add(const Vec3& direction, double least) {
    const Vec3 rest = free_part(direction);
    if (count == 3 || !(length(rest) >= least)) return false;
    normal[count++] = unit(rest);
    return true;
}

Across Slides::across_at(std::size_t place, const Vec3& at) const {
    const Across fixed = {{}, 3};
    Across across;
    if (surfaces_[place].size() > kMostSurfaces) return fixed;
    const Vec3 x = scaled(difference(at, model_.origin), 1 / model_.side);
    for (const std::uint32_t surface : surfaces_[place]) {
        const SurfaceSample s =
            surface_sample(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2]);
        // Surfaces that touch there: nobody knows where which of them goes on.
        if (!across.add(unit({s.gradient[0], s.gradient[1], s.gradient[2]}), kTangent)) return fixed;
    }
    return across;
}

Across Slides::across(NodeId node) const { return holds(node) ? across_[nodes_.place(node)] : Across{}; }

Vec3 Slides::along(NodeId node, const Vec3& move) const {
    if (!holds(node)) return move;
    const Across& across = across_[nodes_.place(node)];
    return across.count == 3 ? Vec3{} : across.free_part(move);
}

bool Slides::place(NodeId node, const Vec3& move, Vec3& at) const {
    const Vec3 from = point_of(mesh_, node);
    at = sum(from, move);
    const double far = length(move);
    if (far == 0 || !holds(node)) return true;
    const auto surfaces = surfaces_[nodes_.place(node)];
    Vec3 x = scaled(difference(at, model_.origin), 1 / model_.side);
    const tape::ProjectionLimits limits = {kReach * far / model_.side, kTangent,
                                           std::max(kSettled * far / model_.side, kRounding)};
    if (!tape::project(model_, surfaces.begin(), surfaces.size(), limits, x.data())) return false;
    at = sum(scaled(x, model_.side), model_.origin);
    return true;
}

}  // namespace mortise::layers
