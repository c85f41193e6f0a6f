#include "host/second_order/curves.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/projection.hpp"
#include "kernels/shared/surface.h"

namespace mortise::second_order {
namespace {

constexpr std::size_t kFacetChunk = 4096;
constexpr std::size_t kMostSurfaces = 3;  ///< of an edge

/// Of an edge's length: how far its middle may move, how far an end may lie beside a surface that it is on,
/// below what the edge is straight, and Newton's last step.
constexpr double kReach = 0.25, kOnSurface = 1e-6, kStraight = 1e-9, kSettled = 1e-11;
constexpr double kTangent = 0.05;      ///< sine between gradients below which surfaces count as tangent
constexpr double kRounding = 0x1p-48;  ///< of a position, in edges of the root box

/// An edge of a facet, and the facet's surface.
struct FacetEdge {
    std::size_t edge;
    NodeId lower, upper;
    std::uint32_t surface;
    bool operator<(const FacetEdge& other) const {
        return edge != other.edge ? edge < other.edge : surface < other.surface;
    }
    bool operator==(const FacetEdge& other) const { return edge == other.edge && surface == other.surface; }
};

/// Each edge with each of its surfaces, sorted.
std::vector<FacetEdge> list_facet_edges(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                        const Edges& edges, int threads) {
    std::vector<FacetEdge> list(4 * mesh.facets.size());
    parallel_chunks(mesh.facets.size(), kFacetChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t f = begin; f < end; ++f) {
            for_sides(mesh.facets, f, [&](std::size_t k, NodeId a, NodeId b) {
                list[4 * f + k] = {edges.number(a, b), std::min(a, b), std::max(a, b), facet_surface[f]};
            });
        }
    });
    parallel_sort(list, threads);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
}

/// An edge between two points, model units, and the surfaces that it may lie on.
class OnModel {
  public:
    OnModel(const tape::BoundModel& model, const Vec3& a, const Vec3& b)
        : model_(model), a_(to_local(a)), b_(to_local(b)), size_(length(difference(b_, a_))) {}

    /// How its middle moves onto the surfaces, model units; zero: the edge is straight.
    Vec3 displacement(const std::uint32_t* surfaces, std::size_t count) const {
        for (std::size_t i = 0; i < count; ++i) {
            if (!lies_on(surfaces[i], a_) || !lies_on(surfaces[i], b_)) return {};
        }
        const Vec3 middle = scaled(sum(a_, b_), 0.5);
        Vec3 place = middle;
        const tape::ProjectionLimits limits = {kReach * size_, kTangent,
                                               std::max(kSettled * size_, kRounding)};
        // Surfaces that touch along the edge are not crossed by two steps at once: either tells.
        if (!tape::project(model_, surfaces, count, limits, place.data()) &&
            !tape::project(model_, surfaces, 1, limits, place.data()))
            return {};
        const Vec3 moved = difference(place, middle);
        return length(moved) > kStraight * size_ ? scaled(moved, model_.side) : Vec3{};
    }

  private:
    Vec3 to_local(const Vec3& p) const { return scaled(difference(p, model_.origin), 1 / model_.side); }

    bool lies_on(std::uint32_t surface, const Vec3& x) const {
        const SurfaceSample s =
            surface_sample(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2]);
        const double slope = length({s.gradient[0], s.gradient[1], s.gradient[2]});
        return std::fabs(s.value) <= (kOnSurface * size_ + kRounding) * slope;
    }

    const tape::BoundModel& model_;
    const Vec3 a_, b_;  ///< box-local
    const double size_;
};

Vec3 point_of(const Mesh& mesh, NodeId node) {
    const double* const p = mesh.points.data() + 3 * std::size_t{node};
    return {p[0], p[1], p[2]};
}

}  // namespace

std::vector<CurvedEdge> find_curved_edges(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                          const tape::BoundModel& model, const Edges& edges, int threads) {
    const std::vector<FacetEdge> list = list_facet_edges(mesh, facet_surface, edges, threads);
    std::vector<std::vector<CurvedEdge>> parts(chunk_count(list.size(), kFacetChunk));
    parallel_chunks(list.size(), kFacetChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        std::vector<CurvedEdge>& part = parts[begin / kFacetChunk];
        std::vector<std::uint32_t> surfaces;
        for (std::size_t i = begin; i < end; ++i) {
            const FacetEdge& edge = list[i];
            if (i > 0 && list[i - 1].edge == edge.edge) continue;
            surfaces.clear();
            for (std::size_t j = i; j < list.size() && list[j].edge == edge.edge; ++j)
                surfaces.push_back(list[j].surface);
            if (surfaces.size() > kMostSurfaces) continue;
            const OnModel on_model(model, point_of(mesh, edge.lower), point_of(mesh, edge.upper));
            const Vec3 moved = on_model.displacement(surfaces.data(), surfaces.size());
            if (squared_length(moved) > 0) part.push_back({edge.edge, moved});
        }
    });
    std::vector<CurvedEdge> curved;
    for (const auto& part : parts) curved.insert(curved.end(), part.begin(), part.end());
    return curved;
}

}  // namespace mortise::second_order
