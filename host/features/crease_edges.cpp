// Mesh edges on creases, with the model's own angle there.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/common/constants.hpp"
#include "host/common/index_set.hpp"
#include "host/features/features.hpp"
#include "host/features/surfaces.hpp"

namespace mortise::features {
namespace {

constexpr std::size_t kMostAround = 64;  // facets about one edge; meshes have two to six

/// What a facet separates, and by which surface.
struct Label {
    std::uint32_t surface;
    std::uint16_t inside, outside;
    bool operator==(const Label& other) const {
        return surface == other.surface && inside == other.inside && outside == other.outside;
    }
};

struct EdgeOfFacet {
    NodeId a, b;  ///< a < b
    std::uint32_t facet;
    bool forward;  ///< the facet runs from a to b
};

class EdgeFinder {
  public:
    EdgeFinder(const Mesh& mesh, const std::vector<std::uint32_t>& surface, const tape::BoundModel& model)
        : mesh_(mesh), surface_(surface), model_(model) {}

    SurfaceEdges find() {
        const std::vector<EdgeOfFacet> edges = mixed_edges();
        SurfaceEdges result;
        for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
            while (j < edges.size() && edges[j].a == edges[i].a && edges[j].b == edges[i].b) ++j;
            CreaseEdge edge;
            switch (meet(edges.data() + i, std::min(j - i, kMostAround), &edge)) {
                case Meeting::kOneSurface: break;
                case Meeting::kSmooth: result.smooth.push_back(edge); break;
                case Meeting::kCrease: result.creases.push_back(edge); break;
            }
        }
        return result;
    }

  private:
    Label label(std::size_t facet) const {
        return {surface_[facet], mesh_.facets.inside[facet], mesh_.facets.outside[facet]};
    }

    /// Edges whose two nodes touch facets of different labels, sorted: no others can be creases.
    std::vector<EdgeOfFacet> mixed_edges() const {
        constexpr std::uint32_t kNone = 0xffffffffu;
        const FacetBlock& facets = mesh_.facets;
        IndexSet on_facets(mesh_.node_count());
        for (const NodeId node : facets.nodes) on_facets.insert(node);
        on_facets.number();
        std::vector<std::uint32_t> first(on_facets.size(), kNone);
        IndexSet mixed(mesh_.node_count());
        for (std::size_t f = 0; f < facets.size(); ++f) {
            for (std::size_t k = 0; k < 4; ++k) {
                const NodeId node = facets.nodes[4 * f + k];
                std::uint32_t& seen = first[on_facets.place(node)];
                if (seen == kNone) seen = static_cast<std::uint32_t>(f);
                if (!(label(seen) == label(f))) mixed.insert(node);
            }
        }
        std::vector<EdgeOfFacet> edges;
        for (std::size_t f = 0; f < facets.size(); ++f) {
            const FacetNodes n = facets.facet(f);
            for (std::size_t k = 0; k < n.size(); ++k) {
                const NodeId a = n[k], b = n.after(k);
                if (!mixed.holds(a) || !mixed.holds(b)) continue;
                edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(f), a < b});
            }
        }
        std::sort(edges.begin(), edges.end(), [](const EdgeOfFacet& p, const EdgeOfFacet& q) {
            return std::tie(p.a, p.b, p.facet) < std::tie(q.a, q.b, q.facet);
        });
        return edges;
    }

    Vector centre(std::uint32_t facet) const {
        const FacetNodes nodes = mesh_.facets.facet(facet);
        Vector sum;
        for (const NodeId node : nodes) sum = sum + point_of(mesh_, node);
        return (1.0 / static_cast<double>(nodes.size())) * sum;
    }

    enum class Meeting { kOneSurface, kSmooth, kCrease };

    Meeting meet(const EdgeOfFacet* around, std::size_t count, CreaseEdge* edge) const {
        bool same = true, same_regions = true;
        for (std::size_t i = 1; i < count; ++i) {
            const Label a = label(around[0].facet), b = label(around[i].facet);
            same = same && a == b;
            same_regions = same_regions && a.inside == b.inside && a.outside == b.outside;
        }
        if (same) return Meeting::kOneSurface;
        const Vector a = point_of(mesh_, around[0].a), b = point_of(mesh_, around[0].b);
        const Vector middle = to_local(model_, 0.5 * (a + b));
        Vector normal[kMostAround];
        Vector tangent = unit(b - a);
        bool sharp = false;
        for (std::size_t i = 0; i < count; ++i) {
            normal[i] = unit_normal(model_, surface_[around[i].facet], middle);
            for (std::size_t j = 0; j < i; ++j) {
                if (sharp || !is_sharp(normal[i], normal[j])) continue;
                sharp = true;
                const Vector along = unit(cross(normal[i], normal[j]));
                tangent = (dot(along, tangent) < 0 ? -1.0 : 1.0) * along;
            }
        }
        edge->a = around[0].a;
        edge->b = around[0].b;
        if (count == 2) {
            const auto [low_surface, high_surface] =
                std::minmax(surface_[around[0].facet], surface_[around[1].facet]);
            edge->bound = {low_surface, high_surface};
        }
        std::uint32_t low = 0xffffffffu, high = 0, second = 0xffffffffu;
        for (std::size_t i = 0; i < count; ++i) low = std::min(low, name(around[i].facet));
        for (std::size_t i = 0; i < count; ++i) {
            high = std::max(high, name(around[i].facet));
            if (name(around[i].facet) > low) second = std::min(second, name(around[i].facet));
        }
        edge->surfaces = {low, high > low ? second : low};
        edge->model_angle = smallest_wedge(around, count, normal, tangent, 0.5 * (a + b));
        return !sharp && same_regions && count == 2 ? Meeting::kSmooth : Meeting::kCrease;
    }

    std::uint32_t name(std::uint32_t facet) const { return mesh_.facets.surface[facet]; }

    /// Turns about the edge: between two neighbouring facets lies one region. The angle of the tangent planes
    /// there, the smallest over wedges that hold material.
    double smallest_wedge(const EdgeOfFacet* around, std::size_t count, const Vector* normal,
                          const Vector& tangent, const Vector& middle) const {
        struct Side {
            double facet_angle, model_angle;
            std::uint16_t after;  ///< region on the side of larger angles
        };
        const Vector x = unit(cross(std::fabs(tangent.x) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0}, tangent));
        const Vector y = cross(tangent, x);
        std::vector<Side> sides;
        for (std::size_t i = 0; i < count; ++i) {
            const Vector out = centre(around[i].facet) - middle;
            Vector plane = unit(cross(tangent, normal[i]));
            if (dot(plane, plane) == 0) plane = unit(out);
            if (dot(plane, out) < 0) plane = -1.0 * plane;
            // A facet that runs along the tangent has its front, the outside, at larger angles.
            const Label l = label(around[i].facet);
            sides.push_back({std::atan2(dot(out, y), dot(out, x)), std::atan2(dot(plane, y), dot(plane, x)),
                             around[i].forward ? l.outside : l.inside});
        }
        std::sort(sides.begin(), sides.end(),
                  [](const Side& a, const Side& b) { return a.facet_angle < b.facet_angle; });
        double smallest = 360;
        for (std::size_t i = 0; i < count; ++i) {
            const Side &from = sides[i], &to = sides[(i + 1) % count];
            if (from.after == 0) continue;
            double turn = kDegrees * (to.model_angle - from.model_angle);
            if (turn < 0) turn += 360;
            // Tangent planes that nearly coincide may come out in the other order than the facets.
            double seen = kDegrees * (to.facet_angle - from.facet_angle);
            if (seen < 0) seen += 360;
            if (turn - seen > 180) turn = 360 - turn;
            if (seen - turn > 180) turn = 360 - turn;
            smallest = std::min(smallest, turn);
        }
        return smallest;
    }

    const Mesh& mesh_;
    const std::vector<std::uint32_t>& surface_;
    const tape::BoundModel& model_;
};

}  // namespace

SurfaceEdges find_surface_edges(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                const tape::BoundModel& model) {
    return EdgeFinder(mesh, facet_surface, model).find();
}

}  // namespace mortise::features
